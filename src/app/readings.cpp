#include "app/readings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace calor {

Readings::Readings(const Case& c, const Probes& probes, HeatSystem& system, std::shared_ptr<WeldResults> weld,
                   std::shared_ptr<const ThermalStress> stress)
    : probes_(probes), system_(system), weld_(std::move(weld)), stress_(std::move(stress)) {
  const Table output = c.section("output");
  if (!output.has("derivatives_of")) return;
  if (!output.has("derivatives"))
    output.refuse("derivatives_of", "derivatives by no number of the case", "name some in 'derivatives'");
  balance_.emplace(system);
  std::vector<std::string> names;
  for (const ReportNumber& number : listed()) names.push_back(number.name);
  for (const std::string& wanted : output.texts("derivatives_of")) {
    const auto found = std::ranges::find(names, wanted);
    if (found == names.end())
      output.refuse("derivatives_of", fmt::format("no derivatives are known of '{}' in this case", wanted),
                    fmt::format("take some of {}", fmt::join(names, ", ")));
    entries_.push_back(found - names.begin());
  }
}

std::vector<ReportNumber> Readings::listed() const {
  std::vector<ReportNumber> all = balance_->listed();
  if (weld_) std::ranges::copy(weld_->listed(), std::back_inserter(all));
  if (stress_) std::ranges::copy(ExtremeStresses::listed(), std::back_inserter(all));
  return all;
}

std::vector<std::string> Readings::headings() const {
  std::vector<std::string> headings;
  for (const std::string& probe : probes_.names()) headings.push_back(probe + " [K]");
  if (entries_.empty()) return headings;
  const std::vector<ReportNumber> all = listed();
  for (const std::size_t n : entries_) headings.push_back(fmt::format("{} [{}]", all[n].name, all[n].unit));
  return headings;
}

void Readings::observe(State& state) {
  if (entries_.empty() || !(weld_ || stress_)) return;
  const std::vector<double> T = system_.temperatures(state.T);  // and the ghosts of state.T
  if (weld_) weld_->observe(state, T);
  if (stress_) extremes_.add(stress_->deformation(state.T));
}

std::vector<double> Readings::at(double t, std::span<const double> u) const {
  std::vector<double> values = probes_.temperatures(u);
  if (entries_.empty()) return values;
  std::vector<double> numbers = balance_->numbers(t, u);
  if (weld_) std::ranges::copy(weld_->numbers(), std::back_inserter(numbers));
  if (stress_) {
    ExtremeStresses extremes = extremes_;
    extremes.add(stress_->deformation(u));
    std::ranges::copy(extremes.numbers(), std::back_inserter(numbers));
  }
  for (const std::size_t n : entries_) values.push_back(numbers[n]);
  return values;
}

}  // namespace calor
