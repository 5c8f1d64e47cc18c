// Walls whose temperature does not follow from a heat balance: prescribed ones and algebraic rows.
#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "solve/heat_system_parts.hpp"

namespace calor {

void HeatSystem::prescribed_temperatures(double t, std::span<double> T) const {
  std::vector<double> value;
  for (int i : parts_->prescribed) T[i] = 0;
  for (const PrescribedTerm& term : parts_->conditions.temperatures) {
    if (term.point.empty()) continue;  // held by mirror images
    value.resize(term.x.size());
    term.temperature.evaluate({.x = term.x, .t = t}, value);
    for (std::size_t n = 0; n < value.size(); ++n) T[term.point[n]] += term.share[n] * value[n];
  }
}

void HeatSystem::Parts::constrain(double t, std::span<const double> T, std::span<double> R) {
  for (int i : prescribed) R[i] = 0;
  if (!point_values || penalty) return;
  const std::span<const double> T_here = values(T);
  std::vector<double> wanted;
  for (std::size_t m = 0; m < conditions.temperatures.size(); ++m) {
    const PrescribedTerm& term = conditions.temperatures[m];
    wanted.resize(term.x.size());
    term.temperature.evaluate({.x = term.x, .t = t}, wanted);
    for (std::size_t n = 0; n < wanted.size(); ++n) {
      const int i = term.point[n];
      R[i] += constraint_scale[place[m][n]] * term.share[n] * (wanted[n] - T_here[i]);
    }
  }
}

void HeatSystem::Parts::meet_constraints(double t, std::span<double> T) {
  cloud.halo.update(T);
  if (!constraints_are_scaled) {
    std::vector<double> C(cloud.owned);
    collective_try(cloud.comm, [&] { hold(T, {}, C); });
    for (int i : prescribed) constraint_scale.push_back(C[i]);
    constraints_are_scaled = true;
  }
  std::vector<double> violation(cloud.owned);
  collective_try(cloud.comm, [&] { constrain(t, T, violation); });
  const std::span<const double> T_here = values(T);
  double largest = 0, hottest = 0;
  for (std::size_t n = 0; n < prescribed.size(); ++n) {
    violation[prescribed[n]] /= constraint_scale[n];
    largest = std::max(largest, std::abs(violation[prescribed[n]]));
    hottest = std::max(hottest, std::abs(T_here[prescribed[n]]));
  }
  constexpr double as_newton_leaves_it = 1e-9;
  if (max(cloud.comm, largest) <= as_newton_leaves_it * max(cloud.comm, hottest)) return;
  std::vector<double> wanted(T_here.begin(), T_here.end());
  for (int i : prescribed) wanted[i] += violation[i];
  point_values->unknowns(wanted, T);
  cloud.halo.update(T);
}

void HeatSystem::Parts::hold_prescribed(std::span<const double> T) {
  if (!is_nodal) {
    std::vector<double> E(cloud.owned);
    hold(T, E, {});
    for (std::size_t n = 0; n < prescribed.size(); ++n) held_E[n] = E[prescribed[n]];
    return;
  }
  const bool is_linear = !material.capacity_depends_on_T();
  if (is_linear && !base_E_.empty()) {
    for (std::size_t n = 0; n < prescribed.size(); ++n)
      held_E[n] = base_E_[n] + base_C_[n] * (T[prescribed[n]] - base_T_[n]);
    return;
  }
  std::vector<double> H(cloud.owned), rho_c(cloud.owned);
  material.enthalpy(T.first(cloud.owned), H, rho_c);
  base_T_.clear(), base_E_.clear(), base_C_.clear();
  for (std::size_t n = 0; n < prescribed.size(); ++n) {
    const int i = prescribed[n];
    held_E[n] = cloud.volume[i] * H[i];
    base_T_.push_back(T[i]), base_E_.push_back(held_E[n]), base_C_.push_back(cloud.volume[i] * rho_c[i]);
  }
}

void HeatSystem::impose(double t, std::span<double> T, std::span<double> E, std::span<double> exchanged) const {
  Parts& parts = *parts_;
  if (parts.penalty) return;
  const bool any_prescribed = !parts.conditions.temperatures.empty();
  if (any_prescribed && parts.point_values) parts.meet_constraints(t, T);
  if (any_prescribed && !parts.prescribed_is_held) {
    collective_try(parts.cloud.comm, [&] {
      if (!parts.point_values) prescribed_temperatures(t, T);
      parts.hold_prescribed(T);
    });
    parts.prescribed_is_held = parts.is_nodal && parts.prescribed_is_constant;
    parts.held_T.clear();
    for (int i : parts.prescribed) parts.held_T.push_back(T[i]);
  }
  // The wall's reaction is what is missing between the enthalpy that F alone gives and the one that belongs to T*.
  for (std::size_t m = 0; m < parts.conditions.temperatures.size(); ++m) {
    const PrescribedTerm& term = parts.conditions.temperatures[m];
    double reaction = 0;
    for (std::size_t n = 0; n < term.point.size(); ++n)
      reaction += term.share[n] * (parts.held_E[parts.place[m][n]] - E[term.point[n]]);
    exchanged[term.account] += reaction;
  }
  for (std::size_t n = 0; n < parts.prescribed.size(); ++n) {
    T[parts.prescribed[n]] = parts.held_T[n];
    E[parts.prescribed[n]] = parts.held_E[n];
  }
  if (parts.walls) parts.solve_walls(t, T);
}

std::span<const double> HeatSystem::Parts::wall_exchange(double t, std::span<const double> T, bool derivative) {
  std::vector<double>& exchange = wall_exchange_[derivative];
  exchange.assign(cloud.owned, 0);
  for_each_surface_term(t, T, derivative, [&](std::size_t f, const SurfaceTerm& term, std::span<const double> q) {
    for (std::size_t p = 0; p < q.size(); ++p) exchange[term.point[p]] += walls->share(f, p) * q[p];
  });
  return exchange;
}

void HeatSystem::Parts::add_wall_residual(double t, std::span<const double> T, std::span<double> R) {
  const Conductivity k = conductivity(t, T, For::bound);
  walls->residual(k.k, T, wall_exchange(t, T, false), R);
}

void HeatSystem::Parts::solve_walls(double t, std::span<double> T) {
  constexpr int most_iterations = 40;
  const bool k_is_fixed = !material.conductivity_depends_on_T() && !material.conductivity_depends_on_time();
  const bool is_linear =
      !material.conductivity_depends_on_T() && std::ranges::all_of(conditions.fluxes, [](const SurfaceTerm& term) {
        return !term.flux->depends_on_temperature() || term.flux->linear_in_temperature();
      });
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    cloud.halo.update(T);
    Conductivity k;
    collective_try(cloud.comm, [&] {
      k = conductivity(t, T, For::jacobian);
      wall_exchange(t, T, false);
      wall_exchange(t, T, true);
    });
    const double change = walls->newton_step(k, T, wall_exchange_[false], wall_exchange_[true], k_is_fixed);
    double largest = 0;
    for (int i = 0; i < cloud.owned; ++i) largest = std::max(largest, std::abs(T[i]));
    if (is_linear || change <= 1e-13 * max(cloud.comm, largest)) return;
  }
  throw Error(Fault::numbers, "the temperatures of the wall points did not converge",
              "use correction = \"consistent\", whose wall points hold heat");
}

}  // namespace calor
