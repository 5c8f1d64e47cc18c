#pragma once
// What curves are made of, and the ways to hold it.
#include <limits>
#include <span>
#include <vector>

#include "base/curve.hpp"

namespace calor {

enum class Ask { value, derivative, integral };

/// On one interval, with s the distance from its left knot: value c0 + c1 s + c2 s^2 + c3 s^3, and the integral of the
/// curve up to that knot.
struct Cubic {
  double c0 = 0, c1 = 0, c2 = 0, c3 = 0;
  double before = 0;

  template <Ask ask>
  double at(double s) const {
    if constexpr (ask == Ask::value) return c0 + s * (c1 + s * (c2 + s * c3));
    if constexpr (ask == Ask::derivative) return c1 + s * (2 * c2 + s * (3 * c3));
    return before + s * (c0 + s * (c1 / 2 + s * (c2 / 3 + s * (c3 / 4))));
  }
};

/// The ways to hold knots; asked for whole arrays at once.
struct Curve::Knots {
  virtual ~Knots() = default;
  virtual void evaluate(Ask ask, std::span<const double> x, std::span<double> out) const = 0;
  virtual std::vector<double> kinks() const { return {}; }
  virtual ValueRange reach() const { return everywhere; }

  static constexpr ValueRange everywhere{.low = -std::numeric_limits<double>::infinity(),
                                         .high = std::numeric_limits<double>::infinity()};
};

}  // namespace calor
