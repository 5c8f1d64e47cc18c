#pragma once
// The heat that a material holds whose density or specific heat depends on place and temperature: rho c as a cubic on
// intervals of temperature, with the integral up to each. Every point keeps the one interval it is in, so that the
// formulas are asked only where a temperature leaves it.
#include <functional>
#include <span>
#include <vector>

#include "base/function.hpp"
#include "base/sampler.hpp"
#include "material/material.hpp"

namespace calor {

class HeatByPoint {
 public:
  /// Functions of place and temperature, kg/m^3 and J/(kg K), at the points x, which must outlive this. Intervals are
  /// halved until the cubics differ from rho c by less than 1e-11 of its largest value, tried at some of the points
  /// over the range (at most 2^12 intervals). Where rho c jumps or has a kink, it is as in a sampled curve (curve.hpp).
  HeatByPoint(const Function& rho, const Function& c, std::span<const Vec3> x, const TemperatureRange& range);

  /// Of the points first, first + 1, ...: enthalpy above the reference temperature, J/m^3, and rho c, J/(m^3 K); either
  /// may be empty. Throws Error where a function is not finite.
  void evaluate(std::size_t first, std::span<const double> T, std::span<double> H, std::span<double> rho_c) const;

 private:
  /// rho c on one interval; `before`: the integral up to it, and the `rest` that its last digit leaves out; so it does
  /// not depend on the way that temperatures took.
  struct Piece {
    double knot, before, rest;
    SampledInterval interval;
    double value(double s) const { return interval.at<Ask::value>(s); }
    double integral(double s) const { return interval.at<Ask::integral>(s); }
  };
  /// rho c of one point at four temperatures.
  void sample(const Vec3& x, std::span<const double, 4> T, std::span<double, 4> rho_c) const;
  Piece piece(const Vec3& x, double knot) const;
  /// Goes from the piece to the interval with that knot, through those in between.
  void move(const Vec3& x, Piece& p, double knot) const;
  bool is_fine_enough(const TemperatureRange& range);
  /// rho c of one point, for a Sampler.
  std::function<double(double)> of_temperature(const Vec3& x) const;

  Function rho_, c_;
  std::span<const Vec3> x_;
  double reference_, step_, ramp_;
  bool may_jump_;
  double largest_ = 0;                 ///< rho c over the range, at some of the points
  mutable std::vector<Piece> pieces_;  ///< of the points; empty before the first question
};

}  // namespace calor
