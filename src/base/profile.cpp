#include "base/profile.hpp"

#include <cmath>
#include <utility>

namespace calor {
namespace {

/// f = law(s).
template <class Law>
Profile along(const Interval& interval, Law law) {
  return [=](std::span<const double> coordinate, std::span<double> f) {
    constexpr double near = 1e-9;
    for (std::size_t i = 0; i < f.size(); ++i) {
      const double s = (coordinate[i] - interval.from) / (interval.to - interval.from);
      f[i] = law(s < near ? 0 : s > 1 - near ? 1 : s);
    }
  };
}

}  // namespace

Profile power_profile(const Interval& interval, double power, double first, double last) {
  return along(interval, [=](double s) { return first + (last - first) * std::pow(s, power); });
}

Profile exponential_profile(const Interval& interval, double rate, double first, double last) {
  return along(interval, [=](double s) {
    // For rate > 0 written with e^-rate, which does not overflow.
    const double part = rate == 0  ? s
                        : rate < 0 ? std::expm1(rate * s) / std::expm1(rate)
                                   : std::exp(rate * (s - 1)) * std::expm1(-rate * s) / std::expm1(-rate);
    return first + (last - first) * part;
  });
}

Profile hump_profile(const Interval& interval, double factor, double n, double z) {
  return along(interval, [=](double s) { return factor * std::pow(s, n) * std::pow(1 - s, z); });
}

Profile curve_profile(Curve curve) {
  return [curve = std::move(curve)](std::span<const double> coordinate, std::span<double> f) {
    curve.values(coordinate, f);
  };
}

}  // namespace calor
