#include "material/heat_by_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace calor {
namespace {

/// With the temperature? Only of formulas of place it is known that they do not.
bool may_jump(const Function& f) { return f.depends_on_temperature() && (f.may_jump() || !f.depends_on_place()); }

}  // namespace

HeatByPoint::HeatByPoint(const Function& rho, const Function& c, std::span<const Vec3> x, const TemperatureRange& range)
    : rho_(rho), c_(c), x_(x), reference_(range.reference), may_jump_(may_jump(rho) || may_jump(c)) {
  // A power of two; a few thousandths of the temperature at most, as for curves (curve.cpp).
  const double largest = std::max(std::abs(range.low), std::abs(range.high)), level = largest > 0 ? largest : 1;
  const double width = std::max(range.high - range.low, level / 128);
  ramp_ = Sampler::ramp(level);
  constexpr double finest = 0x1p12;
  step_ = std::exp2(std::floor(std::log2(std::min(width / 8, level / 16))));
  while (!is_fine_enough(range) && width / (step_ / 2) <= finest) step_ /= 2;
}

void HeatByPoint::sample(const Vec3& x, std::span<const double, 4> T, std::span<double, 4> rho_c) const {
  const std::array<Vec3, 4> here{x, x, x, x};
  std::array<double, 4> c;
  rho_.evaluate({.x = here, .T = T}, rho_c);
  c_.evaluate({.x = here, .T = T}, c);
  for (std::size_t n = 0; n < 4; ++n) rho_c[n] *= c[n];
}

std::function<double(double)> HeatByPoint::of_temperature(const Vec3& x) const {
  return [this, x](double T) { return rho_(x, 0, T) * c_(x, 0, T); };
}

HeatByPoint::Piece HeatByPoint::piece(const Vec3& x, double knot) const {
  if (may_jump_) {
    const auto rho_c = of_temperature(x);
    return {knot, 0, 0, Sampler(rho_c, step_, largest_, ramp_).interval(knot)};
  }
  const std::array<double, 4> T{knot * step_, (knot + 0.25) * step_, (knot + 0.75) * step_, (knot + 1) * step_};
  std::array<double, 4> f;
  sample(x, T, f);
  // The cubic through the samples; its error has its maximum in the middle.
  const double d1 = f[1] - f[0], d2 = f[2] - f[0], d3 = f[3] - f[0];
  const Cubic cubic{.c0 = f[0],
                    .c1 = 8 * d1 - 8. / 3 * d2 + d3,
                    .c2 = (-56 * d1 + 40 * d2 - 16 * d3) / 3,
                    .c3 = (32 * d1 - 32 * d2 + 16 * d3) / 3};
  return {knot, 0, 0, {cubic, nullptr}};
}

bool HeatByPoint::is_fine_enough(const TemperatureRange& range) {
  constexpr std::size_t most_points = 16;
  const std::size_t stride = std::max<std::size_t>(1, x_.size() / most_points);
  double error = 0;
  std::int64_t all = 0, rough = 0;
  for (std::size_t i = 0; i < x_.size(); i += stride) {
    const auto rho_c = of_temperature(x_[i]);
    const Sampler sampler(rho_c, step_, largest_, ramp_);
    for (double knot = std::floor(range.low / step_); knot * step_ <= range.high; ++knot, ++all) {
      const double T = (knot + 0.5) * step_;
      std::array<double, 4> f;
      sample(x_[i], std::array{T, T, T, T}, f);
      largest_ = std::max(largest_, std::abs(f[0]));
      if (may_jump_)
        rough += !sampler.is_smooth(knot);
      else
        error = std::max(error, std::abs(piece(x_[i], knot).value(0.5) - f[0]));
    }
  }
  return error <= Sampler::accuracy * largest_ && Sampler::are_few(rough, all);
}

void HeatByPoint::move(const Vec3& x, Piece& p, double knot) const {
  while (p.knot != knot) {
    const bool up = p.knot < knot;
    Piece next = piece(x, up ? p.knot + 1 : p.knot - 1);
    const double area = up ? step_ * p.integral(1) : -step_ * next.integral(1);
    // p.before + p.rest + area, in twice the digits.
    const double sum = p.before + area, of_area = sum - p.before;
    const double lost = (p.before - (sum - of_area)) + (area - of_area) + p.rest;
    next.before = sum + lost;
    next.rest = lost - (next.before - sum);
    p = next;
  }
}

void HeatByPoint::evaluate(std::size_t first, std::span<const double> T, std::span<double> H,
                           std::span<double> rho_c) const {
  const double start_knot = std::floor(reference_ / step_);
  const auto start = [&](const Vec3& x) {
    Piece p = piece(x, start_knot);
    p.before = -step_ * p.integral(reference_ / step_ - start_knot);
    return p;
  };
  if (pieces_.empty())
    for (const Vec3& x : x_) pieces_.push_back(start(x));
  constexpr double farthest = 1e5;    // intervals: temperatures have run away, or are none
  const double per_step = 1 / step_;  // exact: a power of two
  for (std::size_t i = 0; i < T.size(); ++i) {
    Piece& p = pieces_[first + i];
    const double u = T[i] * per_step;
    if (!(u >= p.knot && u < p.knot + 1)) {
      const double knot = std::floor(u);
      // Back from temperatures that a step which was much too long had led to.
      if (std::abs(knot - start_knot) < std::abs(knot - p.knot)) p = start(x_[first + i]);
      if (!(std::abs(knot - p.knot) < farthest))
        throw Error(Fault::numbers, c_.location(),
                    "the heat capacity is asked for at " + std::to_string(T[i]) + " K, too far from where it is known",
                    "look why the temperatures run away");
      move(x_[first + i], p, knot);
    }
    if (!H.empty()) H[i] = p.before + step_ * p.integral(u - p.knot);
    if (!rho_c.empty()) rho_c[i] = p.value(u - p.knot);
  }
}

}  // namespace calor
