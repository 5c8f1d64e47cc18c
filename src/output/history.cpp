#include "output/history.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace calor {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The parabola through the last three values, T = T2 + (t - t2) (slope + (t - t1) bend).
struct Parabola {
  double t1, t2, T2, slope, bend;

  double at(double t) const { return T2 + (t - t2) * (slope + (t - t1) * bend); }
  /// Time between t1 and t2 at which it falls through a level that lies between its values there.
  double falls_through(double level) const {
    double low = t1, high = t2, t = t2 + (level - T2) / slope;
    for (int iteration = 0; iteration < 60 && high - low > 1e-14 * t2; ++iteration) {
      (at(t) > level ? low : high) = t;
      const double derivative = slope + (2 * t - t1 - t2) * bend;
      const double next = t - (at(t) - level) / derivative;
      if (std::abs(next - t) <= 1e-14 * t2) return t;
      t = next > low && next < high ? next : 0.5 * (low + high);
    }
    return t;
  }
};

}  // namespace

ThermalHistory::ThermalHistory(std::size_t count, std::optional<Levels> levels)
    : levels_(levels),
      T1_(count),
      T0_(count),
      peak_(count, -std::numeric_limits<double>::infinity()),
      below_high_(levels ? count : 0, nan),
      cooling_(levels ? count : 0, -1) {}

void ThermalHistory::observe(double t, std::span<const double> T) {
  if (known_ > 0 && t <= t1_) return;
  for (std::size_t i = 0; i < T.size(); ++i) {
    peak_[i] = std::max(peak_[i], T[i]);
    if (known_ == 0) continue;
    Parabola p{.t1 = t1_, .t2 = t, .T2 = T[i], .slope = (T[i] - T1_[i]) / (t - t1_), .bend = 0};
    if (known_ > 1) {
      const double before = (T1_[i] - T0_[i]) / (t1_ - t0_);
      p.bend = (p.slope - before) / (t - t0_);
      if (before > 0 && p.slope < 0)  // the top lies between t0 and t
        peak_[i] = std::max(peak_[i], p.at(0.5 * (t1_ + t) - 0.5 * p.slope / p.bend));
    }
    if (!levels_) continue;
    const auto falls = [&](double level) { return T1_[i] > level && T[i] <= level; };
    if (falls(levels_->high)) below_high_[i] = p.falls_through(levels_->high);
    if (falls(levels_->low) && !std::isnan(below_high_[i])) {
      cooling_[i] = p.falls_through(levels_->low) - below_high_[i];
      below_high_[i] = nan;
    }
  }
  std::swap(T0_, T1_);
  std::ranges::copy(T, T1_.begin());
  t0_ = t1_, t1_ = t;
  known_ = std::min(known_ + 1, 2);
}

}  // namespace calor
