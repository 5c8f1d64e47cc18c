#include "app/readings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace calor {

Readings::Readings(const Case& c, const Probes& probes, HeatSystem& system) : probes_(probes) {
  const Table output = c.section("output");
  if (!output.has("derivatives_of")) return;
  if (!output.has("derivatives"))
    output.refuse("derivatives_of", "derivatives by no number of the case", "name some in 'derivatives'");
  balance_.emplace(system);
  std::vector<std::string> names;
  for (const ReportNumber& number : balance_->listed()) names.push_back(number.name);
  for (const std::string& wanted : output.texts("derivatives_of")) {
    const auto found = std::ranges::find(names, wanted);
    if (found == names.end())
      output.refuse("derivatives_of", fmt::format("the balance of this case has no '{}'", wanted),
                    fmt::format("it has {}", fmt::join(names, ", ")));
    entries_.push_back(found - names.begin());
  }
}

std::vector<std::string> Readings::headings() const {
  std::vector<std::string> headings;
  for (const std::string& probe : probes_.names()) headings.push_back(probe + " [K]");
  const std::vector<ReportNumber> listed = balance_ ? balance_->listed() : std::vector<ReportNumber>();
  for (const std::size_t n : entries_) headings.push_back(fmt::format("{} [{}]", listed[n].name, listed[n].unit));
  return headings;
}

std::vector<double> Readings::at(double t, std::span<const double> u) const {
  std::vector<double> values = probes_.temperatures(u);
  if (entries_.empty()) return values;
  const std::vector<double> numbers = balance_->numbers(t, u);
  for (const std::size_t n : entries_) values.push_back(numbers[n]);
  return values;
}

}  // namespace calor
