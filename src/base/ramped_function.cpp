#include "base/ramped_function.hpp"

#include <algorithm>
#include <cmath>

namespace calor {
namespace {

constexpr double width = 0.01;  // of the intervals, K

}  // namespace

void RampedFunction::evaluate(const Arguments& args, std::span<double> out) const {
  function_.evaluate(args, out);
  if (!function().depends_on_temperature()) return;
  const Intervals at = intervals(args);
  for (const std::size_t i : jumps(args, at))
    out[i] = std::lerp(at.f_low[i], at.f_high[i], (args.T[i] - at.low[i]) / width);
}

void RampedFunction::derivative(const Arguments& args, std::span<double> out) const {
  function_.derivative(args, out);
  if (!function().depends_on_temperature()) return;
  constexpr double alike = 1e-2;
  const Intervals at = intervals(args);
  for (std::size_t i = 0; i < out.size(); ++i) {
    // That of a formula comes from differences over a wider range, in which there may be a jump.
    const double slope = (at.f_high[i] - at.f_low[i]) / width;
    if (std::abs(slope - out[i]) > alike * std::max(std::abs(slope), std::abs(out[i]))) out[i] = slope;
  }
}

RampedFunction::Intervals RampedFunction::intervals(const Arguments& args) const {
  Intervals at{.low = std::vector<double>(args.T.size()), .f_low = {}, .f_high = {}};
  std::ranges::transform(args.T, at.low.begin(), [](double T) { return width * std::floor(T / width); });
  at.f_low = values(args.x, args.t, at.low, 0), at.f_high = values(args.x, args.t, at.low, width);
  return at;
}

std::vector<double> RampedFunction::values(std::span<const Vec3> x, double t, std::span<const double> low,
                                           double above) const {
  std::vector<double> T(low.begin(), low.end()), f(low.size());
  for (double& value : T) value += above;
  function_.evaluate({.x = x, .t = t, .T = T}, f);
  return f;
}

std::vector<std::size_t> RampedFunction::jumps(const Arguments& args, const Intervals& at) const {
  constexpr double little = 1e-6, much = 4;
  std::vector<std::size_t> steep, found;
  std::vector<Vec3> x;
  std::vector<double> low;
  for (std::size_t i = 0; i < at.low.size(); ++i) {
    if (!(std::abs(at.f_high[i] - at.f_low[i]) > little * std::max(std::abs(at.f_low[i]), std::abs(at.f_high[i]))))
      continue;
    steep.push_back(i);
    x.push_back(args.x[i]);
    low.push_back(at.low[i]);
  }
  const std::vector<double> below = values(x, args.t, low, -width), above = values(x, args.t, low, 2 * width);
  for (std::size_t n = 0; n < steep.size(); ++n) {
    const std::size_t i = steep[n];
    const double change = std::abs(at.f_high[i] - at.f_low[i]);
    if (change > much * (std::abs(at.f_low[i] - below[n]) + std::abs(above[n] - at.f_high[i]))) found.push_back(i);
  }
  return found;
}

}  // namespace calor
