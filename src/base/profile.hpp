#pragma once
// How a value changes along one coordinate: the laws of graded materials.
#include <functional>
#include <span>

#include "base/curve.hpp"

namespace calor {

/// f at many coordinates at once; both spans have the same size.
using Profile = std::function<void(std::span<const double> coordinate, std::span<double> f)>;

/// An interval of a coordinate: s = (coordinate - from) / (to - from). Outside the interval the values at its ends
/// hold; a coordinate within 1e-9 of its length is the end, so that rounding does not show in laws as steep as s^0.01.
struct Interval {
  double from, to;  ///< m; from may be the larger one
};

/// f = first + (last - first) s^power; power > 0.
Profile power_profile(const Interval& interval, double power, double first, double last);

/// f = first + (last - first) (e^(rate s) - 1) / (e^rate - 1); straight for rate = 0, and
/// f = first (last / first)^s for rate = ln(last / first).
Profile exponential_profile(const Interval& interval, double rate, double first, double last);

/// f = factor s^n (1 - s)^z, highest at s = n / (n + z); n, z >= 0. A porosity of graded plates: Obata & Noda, Trans.
/// JSME A 59 (1993) 1090.
Profile hump_profile(const Interval& interval, double factor, double n, double z);

Profile curve_profile(Curve curve);

}  // namespace calor
