#pragma once
// A function of one variable as piecewise cubic polynomials, with exact derivative and integral.
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/reduce.hpp"

namespace calor {

enum class Interpolation { linear, cubic };

/// y(x). Outside its knots a curve keeps its end values (and slope 0), except one made by `sampled`, which samples on.
/// Copies are cheap and share the knots. Not safe for several threads at once where a sampled curve may grow.
class Curve {
 public:
  Curve() = default;

  static Curve constant(double value);
  /// Through the given points; cubic means monotone (Fritsch & Carlson 1980). x strictly increasing, at least two
  /// points; throws std::invalid_argument otherwise.
  static Curve through(std::vector<double> x, std::vector<double> y, Interpolation interpolation);
  /// A function of temperature, sampled on knots at multiples of a step (a power of two), which is halved until nearly
  /// all cubics differ from f by less than 1e-11 of max |f| over [lo, hi] (at most 2^17 intervals). A jump becomes a
  /// ramp of 0.01 K with its integral; up and down within 1/16 K may be missed. Values outside are sampled as asked, so
  /// that results depend neither on the order of the questions nor on the rank. Throws Error(numbers) where f is not
  /// finite, and for x so far away that the curve would need more than 1e7 knots.
  static Curve sampled(std::function<double(double)> f, double lo, double hi);

  double value(double x) const;
  double derivative(double x) const;
  /// Exact integral of the curve from 0 to x. A sampled curve, which need not be defined at 0, integrates from its knot
  /// at or below `lo`: there only differences of integrals mean something.
  double integral(double x) const;

  // The same for many; out.size() == x.size().
  void values(std::span<const double> x, std::span<double> out) const;
  void derivatives(std::span<const double> x, std::span<double> out) const;
  void integrals(std::span<const double> x, std::span<double> out) const;

  bool is_constant() const;
  /// Knots where the slope jumps: those of linear tables, and the ends of a table that does not end level. Empty for
  /// sampled curves.
  std::vector<double> kinks() const;
  /// Where the curve is known: from the first to the last row of a table, and without end where it ends level.
  ValueRange reach() const;

  struct Knots;

 private:
  double constant_ = 0;
  std::shared_ptr<const Knots> knots_;  ///< none: the constant
};

}  // namespace calor
