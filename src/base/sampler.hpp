#pragma once
// One interval of a function that is tabulated: a cubic through four samples, or pieces where the function jumps or
// bends.
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <vector>

#include "base/knots.hpp"

namespace calor {

/// A piece of an interval, from `begin` to that of the next one; its cubic counts from `origin`.
struct Piece {
  double begin, origin;
  Cubic cubic;
};

/// An interval that one cubic does not fit: its pieces, and the integral over it.
struct Broken {
  std::vector<Piece> pieces;
  double area = 0;

  const Piece& at(double s) const;
};

/// Places are s = x / step - knot: 0 to 1 in the interval. The derivative is by s, and so is the integral.
struct SampledInterval {
  Cubic cubic;                           ///< of a broken one only the integral up to it
  std::shared_ptr<const Broken> broken;  ///< none: the cubic fits

  template <Ask ask>
  double at(double s) const {
    if (!broken) return cubic.at<ask>(s);
    const Piece& piece = broken->at(s);
    const double value = piece.cubic.at<ask>(s - piece.origin);
    return ask == Ask::integral ? cubic.before + value : value;
  }
  double area() const { return broken ? broken->area : cubic.at<Ask::integral>(1) - cubic.before; }
};

/// Makes intervals that are whole multiples of a step. Where one cubic does not fit they are halved. A jump becomes a
/// ramp about its place, with the integral of the jump.
class Sampler {
 public:
  /// So far apart at most the function is looked at, K: what it does in between may be missed.
  static constexpr double scan = 0x1p-4;
  static constexpr double accuracy = 0.5e-11;  ///< where it is looked at
  /// Of a function that is smooth between a few jumps and kinks, few intervals are rough when the step is small enough.
  static bool are_few(std::int64_t rough, std::int64_t all) { return 16 * rough <= all; }
  /// Width of the ramps, K, for a function of temperatures up to `level`.
  static double ramp(double level);

  /// `f`: of x, must outlive this; `largest`: |f|, which the accuracy refers to.
  Sampler(const std::function<double(double)>& f, double step, double largest, double ramp);

  /// Does one cubic do, and is there no jump whose ramp might reach into the interval? Throws Error(numbers) where f is
  /// not finite.
  bool is_smooth(double knot) const;
  /// From knot * step to (knot + 1) * step; its integral starts at 0. Throws as is_smooth.
  SampledInterval interval(double knot);

 private:
  double margin() const { return 2 * ramp_; }  // ramps of jumps farther away do not reach into the interval
  double sample(double knot, double s) const;
  /// Outside of the interval; nothing where the function is not defined.
  std::optional<double> beyond(double knot, double s) const;
  Cubic cubic(double knot, double a, double b) const;
  bool fits(double knot, double a, double b, const Cubic& c) const;
  void split(double a, double b);
  std::optional<double> jump_between(double a, double b) const;
  SampledInterval broken() const;

  const std::function<double(double)>& f_;
  double step_, largest_, ramp_;
  // Of the interval at hand and its margins.
  double knot_ = 0;
  std::vector<Piece> pieces_;
  std::vector<double> jumps_;
};

}  // namespace calor
