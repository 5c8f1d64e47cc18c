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
  for (std::size_t i = 0; i < out.size(); ++i)
    if (is_jump(args, at, i)) out[i] = std::lerp(at.f_low[i], at.f_high[i], (args.T[i] - at.low[i]) / width);
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
  at.f_low = values(args, at.low, 0), at.f_high = values(args, at.low, width);
  return at;
}

std::vector<double> RampedFunction::values(const Arguments& args, std::span<const double> low, double above) const {
  std::vector<double> T(low.begin(), low.end()), f(low.size());
  for (double& value : T) value += above;
  function_.evaluate({.x = args.x, .t = args.t, .T = T}, f);
  return f;
}

bool RampedFunction::is_jump(const Arguments& args, const Intervals& at, std::size_t i) const {
  constexpr double little = 1e-6, much = 4;
  const double change = std::abs(at.f_high[i] - at.f_low[i]);
  if (!(change > little * std::max(std::abs(at.f_low[i]), std::abs(at.f_high[i])))) return false;
  const Arguments here{.x = args.x.subspan(i, 1), .t = args.t};
  const std::span<const double> low(&at.low[i], 1);
  const double below = values(here, low, -width)[0], above = values(here, low, 2 * width)[0];
  return change > much * (std::abs(at.f_low[i] - below) + std::abs(above - at.f_high[i]));
}

}  // namespace calor
