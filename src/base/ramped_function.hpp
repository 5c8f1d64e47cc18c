#pragma once
// Functions of temperature that jump, as those of thermostats, conductivities and contacts do.
#include <span>
#include <vector>

#include "base/function.hpp"

namespace calor {

/// A PointFunction that goes over where it jumps with the temperature: in a ramp of 0.01 K, whose slope is its
/// derivative. Heat flows and sources may come to rest on a jump; then any value between those of its two sides is
/// right (Filippov, Differential equations with discontinuous right-hand sides, 1988), and without a ramp no step in
/// time is short enough. Elsewhere it is the function.
class RampedFunction {
 public:
  /// The points must outlive this.
  RampedFunction(const Function& f, std::span<const Vec3> x) : function_(f, x) {}
  explicit RampedFunction(const Function& f) : function_(f, {}) {}

  /// As of PointFunction.
  void evaluate(const Arguments& args, std::span<double> out) const;
  void derivative(const Arguments& args, std::span<double> out) const;
  const Function& function() const { return function_.function(); }

 private:
  /// The temperatures are cut into intervals. Of those in which the arguments lie, the lower ends, K, and the values at
  /// both.
  struct Intervals {
    std::vector<double> low, f_low, f_high;
  };
  Intervals intervals(const Arguments& args) const;
  std::vector<double> values(std::span<const Vec3> x, double t, std::span<const double> low, double above) const;
  /// The entries over whose intervals the function changes much more than over the neighbours.
  std::vector<std::size_t> jumps(const Arguments& args, const Intervals& at) const;

  PointFunction function_;
};

}  // namespace calor
