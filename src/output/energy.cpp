#include "output/energy.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"

namespace calor {

EnergyLog::EnergyLog(HeatSystem& system, std::vector<double> start_E, const std::string& folder)
    : system_(system), comm_(system.cloud().comm), start_E_(std::move(start_E)) {
  if (folder.empty()) return;
  std::string header = "time [s],stored [J]";
  int account = 0;
  for (const std::string& name : system.accounts())
    header += (account++ < system.boundary_accounts() ? ",through " : ",from ") + name + " [J]";
  for (auto name = system.accounts().begin() + system.boundary_accounts(); name != system.accounts().end(); ++name)
    header += ",asked of " + *name + " [W],deposited by " + *name + " [W]";
  log_ = CsvLog(comm_, folder + "/energy.csv", header + ",imbalance");
}

EnergyBalance EnergyLog::record(const State& state) {
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
  return balance;
}

}  // namespace calor
