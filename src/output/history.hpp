#pragma once
// What temperatures went through: their peaks, and the time they took to cool between two levels (t8/5).
#include <optional>
#include <span>
#include <vector>

namespace calor {

class ThermalHistory {
 public:
  /// Cooling is from `high` to `low`, K; without them only peaks are kept.
  struct Levels {
    double high, low;
  };
  ThermalHistory(std::size_t count, std::optional<Levels> levels);

  /// Adds temperatures at a later time. Between the times a parabola through three of them gives peaks and crossings.
  void observe(double t, std::span<const double> T);

  std::span<const double> peak() const { return peak_; }
  /// From the last crossing of `high` to the first one of `low` after it, s; of several times the last one counts.
  /// -1 where that has not happened.
  std::span<const double> cooling() const { return cooling_; }

 private:
  std::optional<Levels> levels_;
  double t1_ = 0, t0_ = 0;  ///< times before
  int known_ = 0;           ///< how many of them there are
  std::vector<double> T1_, T0_, peak_, below_high_, cooling_;
};

}  // namespace calor
