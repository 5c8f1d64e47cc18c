#pragma once
// Where the heat came from and where it is.
#include <vector>

#include "output/files.hpp"
#include "output/observer.hpp"

namespace calor {

struct EnergyBalance {
  double stored = 0;            ///< since the start, J
  std::vector<double> through;  ///< into the body by every account, J
  double imbalance = 0;         ///< |stored - sum through| / max(|stored|, sum |through|); 0 if nothing happened
};

/// Writes energy.csv (time, stored, through each boundary, from each source, power asked of and deposited by each
/// source at that time, imbalance).
class EnergyLog : public Observer {
 public:
  /// `start_E` (owned points, J) before walls were imposed, so that the jump at t = 0 counts. Empty folder: writes
  /// nothing.
  EnergyLog(HeatSystem& system, std::vector<double> start_E, const std::string& folder = "");

  void begin() override { log_.open(); }
  void exchange(Archive& archive) override;
  void record(const Moment& m) override { add(m.state()); }
  void finish(const Moment& m, RunResult& result) override;
  std::vector<ReportNumber> numbers() const override;

  EnergyBalance add(const State& state);  ///< A row. Collective.
  double worst_imbalance() const { return worst_; }

 private:
  HeatSystem& system_;
  MPI_Comm comm_;
  std::vector<double> start_E_;
  CsvLog log_;
  EnergyBalance last_;
  double worst_ = 0;
  double worst_source_error_ = 0;  ///< largest |deposited / asked - 1| of a source's power
};

}  // namespace calor
