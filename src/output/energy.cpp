#include "output/energy.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/archive.hpp"
#include "base/parallel.hpp"

namespace calor {

EnergyLog::EnergyLog(HeatSystem& system, std::vector<double> start_E, const std::string& folder)
    : system_(system), comm_(system.cloud().comm), start_E_(std::move(start_E)) {
  if (folder.empty()) return;
  std::string header = "time [s],stored [J]", powers;
  int account = 0;
  for (const std::string& name : system_.accounts()) {
    const bool is_boundary = account++ < system_.boundary_accounts();
    header += "," + csv_field(fmt::format("{} {} [J]", is_boundary ? "through" : "from", name));
    if (is_boundary) continue;
    for (const char* what : {"asked of", "deposited by"})
      powers += "," + csv_field(fmt::format("{} {} [W]", what, name));
  }
  log_ = CsvLog(comm_, folder + "/energy.csv", header + powers + ",imbalance");
}

void EnergyLog::exchange(Archive& archive) {
  archive.value("worst imbalance", worst_);
  archive.value("worst error of sources", worst_source_error_);
  log_.exchange(archive);
}

EnergyBalance EnergyLog::add(const State& state) {
  // Differences point by point: of two large totals hardly a digit would be left.
  std::vector<double> gained(start_E_.size()), held(start_E_.size());
  for (std::size_t i = 0; i < gained.size(); ++i) {
    gained[i] = state.E[i] - start_E_[i];
    held[i] = std::max(std::abs(state.E[i]), std::abs(start_E_[i]));
  }
  EnergyBalance balance;
  balance.stored = sum(comm_, gained);
  balance.through = sums(comm_, state.cumulative_heat, static_cast<int>(state.cumulative_heat.size()));

  double net = 0, gross = 0;
  for (double heat : balance.through) net += heat, gross += std::abs(heat);
  const double scale = std::max(std::abs(balance.stored), gross);
  const double rounding = 1e-15 * sum(comm_, held);  // of the enthalpies: a body at rest has exchanged nothing
  balance.imbalance = scale > rounding ? std::abs(balance.stored - net) / scale : 0;
  worst_ = std::max(worst_, balance.imbalance);

  std::vector<double> row{state.t, balance.stored};
  row.insert(row.end(), balance.through.begin(), balance.through.end());
  for (const auto& [asked, deposited] : system_.source_powers(state.t, state.T)) {
    row.insert(row.end(), {asked, deposited});
    if (asked != 0) worst_source_error_ = std::max(worst_source_error_, std::abs(deposited / asked - 1));
  }
  row.push_back(balance.imbalance);
  log_.row(row);
  last_ = balance;
  return balance;
}

void EnergyLog::finish(const Moment&, RunResult& result) {
  result.numbers.insert(
      {{"energy_imbalance", worst_}, {"source_error", worst_source_error_}, {"stored", last_.stored}});
  for (std::size_t account = 0; account < last_.through.size(); ++account)
    result.numbers["heat." + system_.accounts()[account]] = last_.through[account];
  if (worst_source_error_ > 1e-9 && rank_of(comm_) == 0)
    spdlog::warn("sources deposited up to {:.3g} % more or less power than asked for: see energy.csv",
                 100 * worst_source_error_);
}

std::vector<ReportNumber> EnergyLog::numbers() const {
  std::vector<ReportNumber> all{{"energy_imbalance", ""}, {"source_error", ""}, {"stored", "J"}};
  for (const std::string& account : system_.accounts()) all.push_back({"heat." + account, "J"});
  return all;
}

std::unique_ptr<Observer> make_energy_log(const RunSetup& run) {
  if (run.is_steady()) return nullptr;
  return std::make_unique<EnergyLog>(run.system, run.start_E, run.folder);
}

}  // namespace calor
