// The steady state: F(T) = 0 by Newton's method with the exact Jacobian.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "solve/integrator.hpp"
#include "solve/newton.hpp"

namespace calor {
namespace {

/// Largest heat flow through the cross-section of a point, W.
double largest_flow(HeatSystem& system, std::span<double> T) {
  const Cloud& cloud = system.cloud();
  std::vector<Vec3> q(cloud.owned);
  system.heat_flux(0, T, q);
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i)
    largest = std::max(largest, norm(q[i]) * std::pow(cloud.spacing[i], cloud.dimension - 1) * cloud.cross_section);
  return max(cloud.comm, largest);
}

/// The imbalance that rounding of the temperatures alone makes, W: eps |T| times the conductances around a point.
double round_off(HeatSystem& system, std::span<double> T) {
  const Cloud& cloud = system.cloud();
  std::vector<double> C(cloud.owned);
  system.capacity(T, C);
  double hottest = 0, capacity = 0;
  for (int i = 0; i < cloud.owned; ++i)
    hottest = std::max(hottest, std::abs(T[i])), capacity = std::max(capacity, C[i]);
  return std::numeric_limits<double>::epsilon() * max(cloud.comm, hottest) * max(cloud.comm, capacity) *
         system.rate_bound(0, T);
}

}  // namespace

SteadyReport solve_steady(const Case& c, HeatSystem& system, State& state) {
  const Table steady = c.section("steady");
  const double relative = steady.number("tolerance");
  if (!(relative > 0))
    steady.refuse("tolerance", fmt::format("a tolerance of {} is not positive", relative), "take 1e-11");
  const int most_iterations = static_cast<int>(steady.integer("iterations"));

  Newton newton(system,
                {.residual = [&](std::span<double> T, std::span<double> R) { system.residual(0, T, 1, {}, R); },
                 .jacobian = [&](std::span<double> T, Mat J) { system.jacobian(0, T, 0, 1, J); }},
                true);
  SteadyReport report;
  // What is a small imbalance follows from the solution: the first guess, with its steps at the walls, has much larger
  // flows. So the tolerance is taken anew from every solution until the solution meets its own.
  double flow = largest_flow(system, state.T);
  for (bool met = false; !met;) {
    const double allowed = std::max(relative * flow, round_off(system, state.T));
    const std::vector<double> tolerance(system.cloud().owned, std::max(allowed, std::numeric_limits<double>::min()));
    const auto result = newton.solve(state.T, tolerance, most_iterations);
    report.newton_iterations += result.iterations;
    report.linear_iterations += result.linear_iterations;
    if (!result.converged && result.reason) std::rethrow_exception(result.reason);
    if (!result.converged)
      throw Error(
          Fault::numbers,
          fmt::format("Newton's method did not reach the steady state in {} iterations: an imbalance of {:.3g} W "
                      "remains, {:.3g} W are allowed",
                      report.newton_iterations, result.residual * allowed, allowed),
          "start nearer to the solution ([initial]), or march towards it ([time] with steady_below)");
    flow = largest_flow(system, state.T);
    report.residual = result.residual * allowed / std::max(flow, std::numeric_limits<double>::min());
    met = result.residual * allowed <= std::max(relative * flow, round_off(system, state.T));
  }
  system.energy(state.T, state.E);
  return report;
}

}  // namespace calor
