#include "solve/range_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/archive.hpp"
#include "base/parallel.hpp"

namespace calor {
namespace {

/// Methods of second order overshoot a little, where data jump or points are few.
constexpr double part_of_spread = 1e-2;

}  // namespace

void RangeWatch::begin(HeatSystem& system, const State& state) {
  std::vector<double> u = state.T;
  range_ = system.body_temperatures(u);
  see(system, state.t, state.t);
}

void RangeWatch::see(HeatSystem& system, double t_old, double t_new) {
  for (const double t : {0.5 * (t_old + t_new), t_new}) {
    const ValueRange outer = system.outer_temperatures(t);
    range_ = {.low = std::min(range_.low, outer.low), .high = std::max(range_.high, outer.high)};
  }
}

void RangeWatch::exchange(Archive& archive) {
  archive.value("lowest temperature of the data", range_.low);
  archive.value("highest temperature of the data", range_.high);
}

double RangeWatch::excess_of(const HeatSystem& system, double T) const {
  if (system.keeps_range()) return std::max(range_.low - T, T - range_.high);
  return is_absolute() ? -T : 0;
}

double RangeWatch::excess_of(const HeatSystem& system, const ValueRange& body) const {
  constexpr double round_off = 1e-9;  // of the hottest point: walls may be at 0 K
  const double largest = std::max({0.0, excess_of(system, body.low), excess_of(system, body.high)});
  return largest > round_off * std::max(std::abs(body.low), std::abs(body.high)) ? largest : 0;
}

double RangeWatch::excess(HeatSystem& system, std::span<double> u) const {
  return excess_of(system, system.body_temperatures(u));
}

void RangeWatch::require(HeatSystem& system, std::optional<double> t, std::span<double> u, double allowed) const {
  const ValueRange body = system.body_temperatures(u);
  const double largest = excess_of(system, body);
  if (!system.keeps_range())  // nothing tells how far temperatures may go, but what they are
    allowed = std::max(allowed, part_of_spread * (std::max(0.0, body.high) - std::min(0.0, body.low)));
  if (!(largest > allowed)) return;
  const Cloud& cloud = system.cloud();
  const std::vector<double> T = system.temperatures(u);
  collective_try(cloud.comm, [&] {
    for (std::size_t i = 0; i < T.size(); ++i) {
      if (excess_of(system, T[i]) < largest) continue;
      const Vec3& x = cloud.x[i];
      const std::string where =
          fmt::format("the temperature of point {} at ({:.6g}, {:.6g}, {:.6g}) m is {:.6g} K {}", cloud.id[i], x.x, x.y,
                      x.z, T[i], t ? fmt::format("at t = {:.6g} s", *t) : "in the steady state");
      if (!system.keeps_range())
        throw Error(Fault::numbers, where + ", below absolute zero",
                    t ? "take out less heat, or take a smaller [time] step if the one taken was too long"
                      : "take out less heat");
      throw Error(Fault::numbers,
                  fmt::format("{}, outside the range of start, walls and surroundings, {:.6g} to {:.6g} K", where,
                              range_.low, range_.high),
                  t ? "take a smaller [time] step, or an integrator that chooses it"
                    : "take closer points, or a method and support whose weights are positive (calor check)");
    }
  });
}

}  // namespace calor
