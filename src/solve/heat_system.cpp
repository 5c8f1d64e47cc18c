#include "solve/heat_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "solve/heat_system_parts.hpp"

namespace calor {

HeatSystem::Parts::Parts(const Cloud& cloud, std::unique_ptr<FluxSites> sites_, SystemMaterial material_,
                         Conditions conditions_, std::vector<std::unique_ptr<Source>> sources_)
    : cloud(cloud),
      sites(std::move(sites_)),
      fields(std::move(material_)),
      material(fields.points),
      conditions(std::move(conditions_)),
      sources(std::move(sources_)),
      accounts(conditions.accounts),
      role(cloud.local(), Role::free) {
  for (const auto& source : sources) accounts.push_back(source->name);
  const QuadraturePoints* between = sites->conduction_quadrature();
  k_.resize(between ? between->x.size() : cloud.x.size());
  if (const SparseRows* phi = sites->point_values()) point_values = std::make_unique<NodalValues>(cloud, *phi);
  is_nodal = !point_values, points_hold_heat = !sites->capacity_quadrature();

  std::vector<double> is_prescribed(cloud.local());  // a double, as the halo carries doubles
  if (const PenaltyWalls* by_penalty = sites->penalty_walls())
    penalty = std::make_unique<PenaltyHeat>(*by_penalty, *sites->point_values(), conditions.temperatures, material);
  else
    for (const PrescribedTerm& term : conditions.temperatures)
      for (int i : term.point) is_prescribed[i] = 1;
  for (int i = 0; i < cloud.owned; ++i)
    if (is_prescribed[i] != 0) prescribed.push_back(i);
  for (const PrescribedTerm& term : conditions.temperatures) {
    prescribed_is_constant = prescribed_is_constant && !term.temperature.depends_on_time();
    std::vector<int>& at = place.emplace_back();
    for (int i : term.point)
      at.push_back(static_cast<int>(std::ranges::lower_bound(prescribed, i) - prescribed.begin()));
  }
  held_E.resize(prescribed.size());
  cloud.halo.update(is_prescribed);

  std::vector<double> is_wall(cloud.local());
  if (const WallRows* rows = sites->wall_rows()) {
    std::vector<char> active(rows->point.size());
    for (std::size_t n = 0; n < active.size(); ++n) active[n] = is_prescribed[rows->point[n]] == 0;
    for (std::size_t n = 0; n < active.size(); ++n) is_wall[rows->point[n]] = active[n];
    if (any(cloud.comm, std::ranges::count(active, 1) > 0))
      walls = std::make_unique<AlgebraicWalls>(cloud, *rows, conditions.fluxes, std::move(active));
  }
  cloud.halo.update(is_wall);
  if (const WallBonds* bonds = sites->wall_bonds())
    images = std::make_unique<ImageHeat>(*bonds, conditions.temperatures, material);
  for (int i = 0; i < cloud.local(); ++i)
    role[i] = is_prescribed[i] != 0 ? Role::prescribed : is_wall[i] != 0 ? Role::wall : Role::free;
}

std::span<const double> HeatSystem::Parts::values(std::span<const double> T) {
  if (!point_values) return T.first(cloud.owned);
  T_values_.resize(cloud.owned);
  point_values->phi().apply(T, T_values_);
  return T_values_;
}

void HeatSystem::Parts::hold(std::span<const double> T, std::span<double> E, std::span<double> C) {
  const CellQuadrature* places = sites->capacity_quadrature();
  if (!places) {
    material.enthalpy(values(T), E, C);
    for (std::span<double> held : {E, C})
      for (std::size_t i = 0; i < held.size(); ++i) held[i] = role[i] == Role::wall ? 0 : cloud.volume[i] * held[i];
    return;
  }
  T_capacity_.resize(places->x.size()), H_capacity_.resize(places->x.size());
  places->phi.apply(T, T_capacity_);
  const auto add_up = [&](std::span<double> held) {
    for (int i = 0; i < cloud.owned; ++i) {
      held[i] = 0;
      for (std::int64_t q = places->cell[i]; q < places->cell[i + 1]; ++q)
        held[i] += places->volume[q] * H_capacity_[q];
    }
  };
  if (!E.empty()) fields.capacity->enthalpy(T_capacity_, H_capacity_, {}), add_up(E);
  if (!C.empty()) fields.capacity->enthalpy(T_capacity_, {}, H_capacity_), add_up(C);
}

Conductivity HeatSystem::Parts::conductivity(double t, std::span<const double> T, For purpose) {
  const bool depends_on_T = material.conductivity_depends_on_T();
  if (const QuadraturePoints* places = sites->conduction_quadrature()) {
    T_conduction_.resize(k_.size());
    places->phi.apply(T, T_conduction_);
    const bool with_derivative = purpose == For::jacobian && depends_on_T;
    dk_dT_.resize(with_derivative ? k_.size() : 0);
    if (!k_is_known_) fields.conduction->conductivity(t, T_conduction_, k_, dk_dT_);
    k_is_known_ = !depends_on_T && !material.conductivity_depends_on_time();
    return {.mean = Mean::arithmetic, .k = k_, .dk_dT = dk_dT_, .theta = {}};
  }
  const bool by_theta = material.mean() == Mean::integral;
  if (by_theta && purpose == For::rate) {
    theta_.resize(k_.size());
    material.theta(T, theta_);
    return {.mean = Mean::integral, .k = {}, .dk_dT = {}, .theta = theta_};
  }
  // With the integral mean dF/dT has no term in dk/dT, but algebraic wall rows have one.
  const bool with_derivative = purpose == For::jacobian && depends_on_T && (!by_theta || walls);
  if (with_derivative) dk_dT_.resize(k_.size());
  const std::span<double> dk_dT = with_derivative ? std::span<double>(dk_dT_) : std::span<double>();
  if (!k_is_known_) material.conductivity(t, T, k_, dk_dT);
  k_is_known_ = !depends_on_T && !material.conductivity_depends_on_time();
  return {.mean = material.mean(), .k = k_, .dk_dT = dk_dT, .theta = {}};
}

void HeatSystem::Parts::add_rate(double t, std::span<const double> T, std::span<double> F, std::span<double> power) {
  const Conductivity k = conductivity(t, T, For::rate);
  sites->add_rate(k, T, F);
  if (images) images->add_rate(t, k, T, F, power);
  if (penalty) penalty->add_rate(t, T, values(T), F, power);
  for_each_surface_term(t, T, false, [&](std::size_t, const SurfaceTerm& term, std::span<const double> q) {
    double total = 0;
    for (std::size_t p = 0; p < q.size(); ++p) {
      const double heat = q[p] * term.area[p];
      F[term.point[p]] += heat;
      total += heat;
    }
    power[term.account] += total;
  });
  for (std::size_t s = 0; s < sources.size(); ++s) {
    source_power_.assign(cloud.owned, 0);
    sources[s]->add_power(t, values(T), source_power_);
    double total = 0;
    for (int i = 0; i < cloud.owned; ++i) {
      F[i] += source_power_[i];
      total += source_power_[i];
    }
    power[conditions.accounts.size() + s] += total;
  }
}

void HeatSystem::Parts::add_exchange_derivative(double t, std::span<const double> T, std::span<double> diagonal) {
  for_each_surface_term(t, T, true, [&](std::size_t, const SurfaceTerm& term, std::span<const double> dq_dT) {
    for (std::size_t p = 0; p < dq_dT.size(); ++p) diagonal[term.point[p]] += dq_dT[p] * term.area[p];
  });
  for (const auto& source : sources)
    if (source->depends_on_temperature()) source->add_derivative(t, values(T), diagonal);
}

HeatSystem::HeatSystem(const Cloud& cloud, std::unique_ptr<FluxSites> sites, SystemMaterial material,
                       Conditions conditions, std::vector<std::unique_ptr<Source>> sources)
    : parts_(std::make_unique<Parts>(cloud, std::move(sites), std::move(material), std::move(conditions),
                                     std::move(sources))) {}

HeatSystem::~HeatSystem() = default;

const Cloud& HeatSystem::cloud() const { return parts_->cloud; }
const FluxSites& HeatSystem::sites() const { return *parts_->sites; }
const MaterialField& HeatSystem::material() const { return parts_->material; }
const std::vector<std::string>& HeatSystem::accounts() const { return parts_->accounts; }
int HeatSystem::boundary_accounts() const { return static_cast<int>(parts_->conditions.accounts.size()); }
std::span<const int> HeatSystem::prescribed() const { return parts_->prescribed; }
bool HeatSystem::has_algebraic_walls() const { return parts_->walls != nullptr; }
bool HeatSystem::is_nodal() const { return parts_->is_nodal; }
bool HeatSystem::points_hold_heat() const { return parts_->points_hold_heat; }

std::span<const double> HeatSystem::values(std::span<double> T) const {
  if (parts_->point_values) parts_->cloud.halo.update(T);
  return parts_->values(T);
}

State HeatSystem::start(double t, std::span<const double> T_owned) const {
  const Cloud& cloud = parts_->cloud;
  State state{.t = t, .E = std::vector<double>(cloud.owned), .T = {}, .exchanged = {}};
  state.T.assign(T_owned.begin(), T_owned.end());
  state.T.resize(cloud.local());
  if (parts_->point_values) parts_->point_values->unknowns(T_owned, state.T);
  state.exchanged.resize(parts_->accounts.size());
  cloud.halo.update(state.T);
  energy(state.T, state.E);
  return state;
}

void HeatSystem::rate(double t, std::span<double> T, std::span<double> F, std::span<double> power) const {
  parts_->cloud.halo.update(T);
  std::ranges::fill(F, 0);
  std::ranges::fill(power, 0);
  for (const auto& source : parts_->sources) source->prepare(t);
  collective_try(parts_->cloud.comm, [&] { parts_->add_rate(t, T, F, power); });
  if (!parts_->walls) return;
  for (int i = 0; i < parts_->cloud.owned; ++i)
    if (parts_->role[i] == Role::wall) F[i] = 0;
}

void HeatSystem::energy(std::span<const double> T, std::span<double> E) const {
  collective_try(parts_->cloud.comm, [&] { parts_->hold(T, E, {}); });
}

void HeatSystem::capacity(std::span<const double> T, std::span<double> C) const {
  collective_try(parts_->cloud.comm, [&] { parts_->hold(T, {}, C); });
}

void HeatSystem::Parts::temperatures(std::span<const double> E, std::span<double> T) {
  std::vector<double>& H = scratch;
  H.resize(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) H[i] = E[i] / cloud.volume[i];
  // Prescribed points keep their temperature: before the wall's reaction is booked, what F alone would make of them can
  // lie far outside the material's range. So do algebraic wall points, which hold no heat.
  kept_T.clear();
  for (int i = 0; i < cloud.owned; ++i) {
    if (role[i] == Role::free) continue;
    kept_T.push_back(T[i]);
    H[i] = 0;
  }
  collective_try(cloud.comm, [&] { material.temperature(H, T); });
  auto value = kept_T.begin();
  for (int i = 0; i < cloud.owned; ++i)
    if (role[i] != Role::free) T[i] = *value++;
}

void HeatSystem::temperature(std::span<const double> E, std::span<double> T) const {
  if (is_nodal()) {
    parts_->temperatures(E, T);
    return;
  }
  const std::span<const double> guess = values(T);
  std::vector<double>& change = parts_->T_points;
  change.assign(guess.begin(), guess.end());
  parts_->temperatures(E, change);
  for (std::size_t i = 0; i < change.size(); ++i) change[i] -= guess[i];
  parts_->point_values->add(change, T);
}

void HeatSystem::step_in_enthalpy(std::span<double> T, std::span<double> dT) const {
  Parts& parts = *parts_;
  const std::size_t n = dT.size();
  parts.cloud.halo.update(T);
  std::vector<double> E(n), C(n), step(T.size());
  energy(T, E);
  capacity(T, C);
  std::ranges::copy(dT, step.begin());
  const std::span<const double> dT_points = values(step);
  std::vector<double> change(dT_points.begin(), dT_points.end());
  const std::span<const double> T_points = parts.values(T);
  std::vector<double> T_new(T_points.begin(), T_points.end());
  for (std::size_t i = 0; i < n; ++i) E[i] += C[i] * change[i];
  parts.temperatures(E, T_new);
  // Where both agree the step stays as it is: the way back from the enthalpy has fewer digits.
  for (std::size_t i = 0; i < n; ++i) {
    const double excess = T_new[i] - (T_points[i] + change[i]);
    const bool differs = parts.role[i] == Role::free && std::abs(excess) > 1e-12 * std::abs(T_points[i]);
    change[i] = differs ? excess : 0;
  }
  if (parts.point_values)
    parts.point_values->add(change, dT);
  else
    for (std::size_t i = 0; i < n; ++i) dT[i] += change[i];
}

void HeatSystem::residual(double t, std::span<double> T, std::span<double> R) const {
  std::vector<double> power(parts_->accounts.size());
  rate(t, T, R, power);
  collective_try(parts_->cloud.comm, [&] {
    parts_->constrain(t, T, R);
    if (parts_->walls) parts_->add_wall_residual(t, T, R);
  });
}

void HeatSystem::heat_flux(double t, std::span<double> T, std::span<Vec3> q) const {
  parts_->cloud.halo.update(T);
  std::ranges::fill(q, Vec3{});
  collective_try(parts_->cloud.comm,
                 [&] { parts_->sites->heat_flux(parts_->conductivity(t, T, Parts::For::rate), T, q); });
}

std::vector<HeatSystem::SourcePower> HeatSystem::source_powers(double t, std::span<const double> T) const {
  const Cloud& cloud = parts_->cloud;
  std::vector<SourcePower> powers;
  for (const auto& source : parts_->sources) {
    source->prepare(t);
    std::vector<double> P(cloud.owned);
    collective_try(cloud.comm, [&] { source->add_power(t, T.first(cloud.owned), P); });
    const double deposited = sum(cloud.comm, P);
    powers.push_back({source->asked(t).value_or(deposited), deposited});
  }
  return powers;
}

std::optional<double> HeatSystem::energy_asked(double t) const {
  double energy = 0;
  for (const auto& source : parts_->sources) {
    const auto asked = source->energy_asked(t);
    if (!asked) return std::nullopt;
    energy += *asked;
  }
  return energy;
}

double HeatSystem::longest_step(double begin, double end) const {
  double longest = std::numeric_limits<double>::infinity();
  for (const auto& source : parts_->sources) longest = std::min(longest, source->longest_step(begin, end));
  return longest;
}

std::vector<double> HeatSystem::events() const {
  std::vector<double> all;
  const auto add = [&](const std::vector<double>& some) { all.insert(all.end(), some.begin(), some.end()); };
  for (const SurfaceTerm& term : parts_->conditions.fluxes) add(term.flux->events());
  for (const PrescribedTerm& term : parts_->conditions.temperatures) add(term.temperature.events());
  for (const auto& source : parts_->sources) add(source->events());
  add(parts_->sites->events());
  std::ranges::sort(all);
  all.erase(std::ranges::unique(all).begin(), all.end());
  return all;
}

void HeatSystem::change_sites(double t) { parts_->sites->change(t); }

bool HeatSystem::level_is_fixed() const {
  bool fixed = !parts_->prescribed.empty() || parts_->images || parts_->penalty;
  for (const SurfaceTerm& term : parts_->conditions.fluxes)
    fixed = fixed || (term.flux->depends_on_temperature() && !term.point.empty());
  return any(parts_->cloud.comm, fixed);
}

double HeatSystem::temperature_span(double t, std::span<const double> T) const {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const auto see = [&](double value) { low = std::min(low, value), high = std::max(high, value); };
  std::ranges::for_each(parts_->values(T), see);
  collective_try(parts_->cloud.comm, [&] {
    for (const PrescribedTerm& term : parts_->conditions.temperatures) {
      std::vector<double> wall(term.x.size());
      term.temperature.evaluate({.x = term.x, .t = t}, wall);
      std::ranges::for_each(wall, see);
    }
    for (const SurfaceTerm& term : parts_->conditions.fluxes) std::ranges::for_each(term.flux->ambient(term.x, t), see);
  });
  return max(parts_->cloud.comm, high) - min(parts_->cloud.comm, low);
}

void HeatSystem::require_finite(double t, std::span<const double> T) const {
  const Cloud& cloud = parts_->cloud;
  collective_try(cloud.comm, [&] {
    for (int i = 0; i < cloud.owned; ++i) {
      if (std::isfinite(T[i])) continue;
      const Vec3& x = cloud.x[i];
      throw Error(Fault::numbers,
                  fmt::format("the temperature of point {} at ({:.6g}, {:.6g}, {:.6g}) m is {} at t = {:.6g} s",
                              cloud.id[i], x.x, x.y, x.z, T[i], t),
                  "take a smaller [time] step, or an integrator that chooses it");
    }
  });
}

}  // namespace calor
