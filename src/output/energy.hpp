#pragma once
// Where the heat came from and where it is.
#include <string>
#include <vector>

#include "output/files.hpp"
#include "solve/heat_system.hpp"

namespace calor {

struct EnergyBalance {
  double stored = 0;            ///< since the start, J
  std::vector<double> through;  ///< into the body by every account, J
  double imbalance = 0;         ///< |stored - sum through| / max(|stored|, sum |through|); 0 if nothing happened
};

/// Writes energy.csv (time, stored, through each boundary, from each source, power asked of and deposited by each
/// source at that time, imbalance); only rank 0 writes.
class EnergyLog {
 public:
  /// `start_E` (owned points, J) before walls were imposed, so that the jump at t = 0 counts. Empty folder: writes
  /// nothing. Collective.
  EnergyLog(HeatSystem& system, std::vector<double> start_E, const std::string& folder);
  EnergyBalance record(const State& state);  ///< Collective.
  double worst_imbalance() const { return worst_; }
  /// Largest |deposited / asked - 1| of a source's power so far.
  double worst_source_error() const { return worst_source_error_; }

 private:
  HeatSystem& system_;
  MPI_Comm comm_;
  std::vector<double> start_E_;
  CsvLog log_;
  double worst_ = 0, worst_source_error_ = 0;
};

}  // namespace calor
