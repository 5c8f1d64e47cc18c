#pragma once
// The heat that a material holds whose density or specific heat depends on place and temperature: rho c as a cubic on
// intervals of temperature, with the integral up to each. Every point keeps the one interval it is in, so that the
// formulas are asked only where a temperature leaves it.
#include <span>
#include <vector>

#include "base/function.hpp"
#include "material/material.hpp"

namespace calor {

class HeatByPoint {
 public:
  /// Functions of place and temperature, kg/m^3 and J/(kg K), at the points x, which must outlive this. Intervals are
  /// halved until the cubics differ from rho c by less than 1e-11 of its largest value, tried at some of the points
  /// over the range (at most 2^12 intervals: where rho c jumps or has a kink, the interval with it is less accurate).
  HeatByPoint(const Function& rho, const Function& c, std::span<const Vec3> x, const TemperatureRange& range);

  /// Of the points first, first + 1, ...: enthalpy above the reference temperature, J/m^3, and rho c, J/(m^3 K); either
  /// may be empty. Throws Error where a function is not finite.
  void evaluate(std::size_t first, std::span<const double> T, std::span<double> H, std::span<double> rho_c) const;

 private:
  /// rho c on one interval, s from 0 to 1 in it: c0 + c1 s + c2 s^2 + c3 s^3; `before`: the integral up to it, and
  /// the `rest` that its last digit leaves out; so it does not depend on the way that temperatures took.
  struct Piece {
    double knot, before, rest, c0, c1, c2, c3;
    double value(double s) const { return c0 + s * (c1 + s * (c2 + s * c3)); }
    double integral(double s) const { return s * (c0 + s * (c1 / 2 + s * (c2 / 3 + s * (c3 / 4)))); }
  };
  /// rho c of one point at four temperatures.
  void sample(const Vec3& x, std::span<const double, 4> T, std::span<double, 4> rho_c) const;
  Piece piece(const Vec3& x, double knot) const;
  /// Goes from the piece to the interval with that knot, through those in between.
  void move(const Vec3& x, Piece& p, double knot) const;
  bool is_fine_enough(const TemperatureRange& range) const;

  Function rho_, c_;
  std::span<const Vec3> x_;
  double reference_, step_;
  mutable std::vector<Piece> pieces_;  ///< of the points; empty before the first question
};

}  // namespace calor
