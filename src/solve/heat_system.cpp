#include "solve/heat_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "solve/exchange_terms.hpp"
#include "solve/wall_fluxes.hpp"

namespace calor {
namespace {

std::vector<Coefficients> coefficients(const std::vector<MaterialField>& materials, const Discretisation& d) {
  std::vector<Coefficients> all{Coefficients(materials.front())};
  for (std::size_t n = 0; n < d.locations.size(); ++n) all.emplace_back(materials[n + 1], &d.locations[n]->phi);
  return all;
}

}  // namespace

HeatSystem::HeatSystem(const Cloud& cloud, Discretisation discretisation, std::vector<MaterialField> materials,
                       Conditions conditions, std::vector<std::unique_ptr<Source>> sources)
    : cloud_(cloud),
      materials_(std::move(materials)),
      conditions_(std::move(conditions)),
      sources_(std::move(sources)),
      discretisation_(std::move(discretisation)),
      at_(evaluation()),
      accounts_(conditions_.accounts),
      corners_(cloud, conditions_.temperatures),
      role_(cloud.owned, Role::free) {
  const auto draws_to_ambient = [](const SurfaceTerm& term) { return term.flux->draws_to_ambient(); };
  const bool all_draw = std::ranges::all_of(conditions_.fluxes, draws_to_ambient);
  for (const SurfaceTerm& term : conditions_.fluxes) {
    if (!term.is_plate && !cloud.points_on_walls) continue;
    exchange_.push_back(std::make_unique<SurfaceFluxTerm>(term));
    if (!draws_to_ambient(term)) given_.push_back(exchange_.back().get());
  }
  if (!cloud.points_on_walls) {
    auto walls = std::make_unique<WallFluxes>(cloud, material(), conditions_.fluxes, discretisation_.wall_layers.get());
    wall_fluxes_ = walls.get();
    exchange_.push_back(std::move(walls));
    if (!all_draw) given_.push_back(wall_fluxes_);
  }
  for (const auto& source : sources_) {
    exchange_.push_back(std::make_unique<SourceTerm>(*source, static_cast<int>(accounts_.size())));
    accounts_.push_back(source->name);
    given_.push_back(exchange_.back().get());
  }
  terms_.push_back(discretisation_.conduction.get());
  for (const auto& term : discretisation_.walls) terms_.push_back(term.get());
  for (const auto& term : exchange_) terms_.push_back(term.get());

  keeps_range_ = discretisation_.weights_are_positive && sources_.empty() && all_draw;
  for (int i = 0; i < cloud.owned; ++i) per_volume_.push_back(1 / cloud.volume[i]);
  std::vector<double> is_known(cloud.local());  // doubles, as the halo carries them
  for (const auto& constraint : discretisation_.constraints) {
    has_massless_points_ = has_massless_points_ || constraint->is_massless();
    for (const int i : constraint->points()) {
      role_[i] = constraint->is_massless() ? Role::massless : Role::prescribed;
      if (!constraint->is_massless()) prescribed_.push_back(i);
      if (constraint->fixes_dofs()) is_known[i] = 1;
    }
  }
  for (int i = 0; i < cloud.owned; ++i)
    if (role_[i] != Role::free) not_free_.push_back(i);
  cloud.halo.update(is_known);
  is_known_.assign(is_known.begin(), is_known.end());
  find_changes();
}

void HeatSystem::exchange_materials(std::vector<MaterialField>& materials) {
  materials_.swap(materials);
  at_.emplace(evaluation());
}

Evaluation HeatSystem::evaluation() const { return {*discretisation_.dofs, coefficients(materials_, discretisation_)}; }

int HeatSystem::boundary_accounts() const { return static_cast<int>(conditions_.accounts.size()); }

State HeatSystem::start(double t, std::span<const double> T_owned) {
  State state{.t = t, .E = std::vector<double>(cloud_.owned), .T = {}, .cumulative_heat = {}};
  state.T.resize(cloud_.local());
  discretisation_.dofs->solve(T_owned, state.T);
  state.cumulative_heat.resize(accounts_.size());
  cloud_.halo.update(state.T);
  energy(state.T, state.E);
  return state;
}

void HeatSystem::exchange(Archive& archive, State& state) const {
  archive.value("time", state.t);
  archive.points("enthalpy", state.E);
  archive.points("degrees of freedom", std::span(state.T).first(cloud_.owned));
  archive.shares("cumulative heat", state.cumulative_heat);
  if (archive.reads()) cloud_.halo.update(state.T);
}

std::vector<double> HeatSystem::temperatures(std::span<double> u) const {
  if (!discretisation_.dofs->are_temperatures()) cloud_.halo.update(u);
  std::vector<double> T(cloud_.owned);
  discretisation_.dofs->temperatures(u, T);
  return T;
}

void HeatSystem::rate(double t, std::span<double> u, std::span<double> F, std::span<double> power) {
  cloud_.halo.update(u);
  std::ranges::fill(F, 0);
  std::ranges::fill(power, 0);
  for (HeatTerm* term : terms_) term->prepare(t);
  at_->begin(t, u);
  collective_try(cloud_.comm, [&] {
    for (HeatTerm* term : terms_) term->add_rate(*at_, F, power);
  });
  if (!has_massless_points_) return;
  for (int i = 0; i < cloud_.owned; ++i)
    if (role_[i] == Role::massless) F[i] = 0;
}

std::vector<double> HeatSystem::wall_temperatures(double t, std::span<double> u) {
  cloud_.halo.update(u);
  at_->begin(t, u);
  std::vector<double> T_wall;
  collective_try(cloud_.comm, [&] {
    const std::span<const double> T = at_->T();
    for (const Facet& facet : cloud_.facets) T_wall.push_back(T[facet.point]);
    if (wall_fluxes_) wall_fluxes_->wall_temperatures(*at_, T_wall);
    for (const PrescribedTerm& term : conditions_.temperatures) {
      if (term.facet.empty()) continue;
      std::vector<double> held(term.x.size());
      term.temperature.evaluate({.x = term.x, .t = t}, held);
      for (std::size_t n = 0; n < held.size(); ++n) T_wall[term.facet[n]] = held[n];
    }
  });
  return T_wall;
}

std::vector<double> HeatSystem::heat_flows(double t, std::span<double> u) {
  std::vector<double> F(cloud_.owned), power(accounts_.size()), C(cloud_.owned);
  rate(t, u, F, power);
  if (!conditions_.temperatures.empty()) capacity(u, C);
  collective_try(cloud_.comm, [&] {
    for (const PrescribedTerm& term : conditions_.temperatures) {
      if (term.point.empty()) continue;  // held by mirror images, which book their heat
      // A wall whose temperature changes holds more or less heat: C dT/dt, by a difference backwards in time.
      const double dt = 1e-6 * t;
      std::vector<double> now(term.x.size()), before = now;
      term.temperature.evaluate({.x = term.x, .t = t}, now);
      term.temperature.evaluate({.x = term.x, .t = t - dt}, before);
      for (std::size_t n = 0; n < term.point.size(); ++n) {
        const int i = term.point[n];
        const double held = now[n] != before[n] ? C[i] * (now[n] - before[n]) / dt : 0;
        power[term.account] += term.share[n] * (held - F[i]);
      }
    }
  });
  const std::vector<double> shifted = shifted_at_corners(t, u);
  for (std::size_t account = 0; account < power.size(); ++account) power[account] += shifted[account];
  return sums(cloud_.comm, power, static_cast<int>(power.size()));
}

void HeatSystem::energy(std::span<const double> u, std::span<double> E) {
  at_->begin(0, u);
  collective_try(cloud_.comm, [&] { discretisation_.capacity->evaluate(*at_, E, {}); });
}

void HeatSystem::capacity(std::span<const double> u, std::span<double> C) {
  at_->begin(0, u);
  collective_try(cloud_.comm, [&] { discretisation_.capacity->evaluate(*at_, {}, C); });
}

void HeatSystem::find_temperatures(std::span<const double> E, std::span<double> T) {
  // Prescribed points keep their temperature: before the wall's reaction is booked, what F alone would make of them can
  // lie far outside the material's range. So do points that hold no heat.
  H_.resize(cloud_.owned), kept_.clear();
  for (std::size_t i = 0; i < H_.size(); ++i) H_[i] = E[i] * per_volume_[i];
  for (const int i : not_free_) H_[i] = 0, kept_.push_back(T[i]);
  collective_try(cloud_.comm, [&] { material().temperature(H_, T); });
  for (std::size_t n = 0; n < not_free_.size(); ++n) T[not_free_[n]] = kept_[n];
}

void HeatSystem::temperature(std::span<const double> E, std::span<double> u) {
  if (discretisation_.dofs->are_temperatures()) return find_temperatures(E, u);
  const std::vector<double> guess = temperatures(u);
  std::vector<double> change = guess;
  find_temperatures(E, change);
  for (std::size_t i = 0; i < change.size(); ++i) change[i] -= guess[i];
  discretisation_.dofs->add(change, u);
}

void HeatSystem::temperature_after_stage(std::span<const double> E, std::span<double> u) {
  if (discretisation_.dofs->are_temperatures()) temperature(E, u);
}

void HeatSystem::correct_by_enthalpy(std::span<double> u, std::span<double> du) {
  const std::size_t n = du.size();
  cloud_.halo.update(u);
  std::vector<double> E(n), C(n), step(u.size());
  energy(u, E);
  capacity(u, C);
  std::ranges::copy(du, step.begin());
  const std::vector<double> T = temperatures(u);
  std::vector<double> dT = temperatures(step);
  for (std::size_t i = 0; i < n; ++i) E[i] += C[i] * dT[i];
  std::vector<double> T_new = T;
  find_temperatures(E, T_new);
  // Where both agree the step stays as it is: the way back from the enthalpy has fewer digits.
  for (std::size_t i = 0; i < n; ++i) {
    const double excess = T_new[i] - (T[i] + dT[i]);
    const bool differs = role_[i] == Role::free && std::abs(excess) > 1e-12 * std::abs(T[i]);
    dT[i] = differs ? excess : 0;
  }
  discretisation_.dofs->add(dT, du);
}

void HeatSystem::impose(double t, std::span<double> u, std::span<double> E, std::span<double> cumulative_heat) {
  for (const auto& constraint : discretisation_.constraints) constraint->impose(*at_, t, u, E, cumulative_heat);
}

void HeatSystem::set_known(double t, std::span<double> u) {
  collective_try(cloud_.comm, [&] {
    for (const auto& constraint : discretisation_.constraints) constraint->set_known(t, u);
  });
}

double HeatSystem::largest_free(std::span<const double> values) const {
  double largest = 0;
  if (not_free_.empty()) {
    const ValueRange range = range_of(values);
    largest = all_finite(values) ? std::max({-range.low, range.high, 0.0}) : std::numeric_limits<double>::infinity();
  } else {
    for (int i = 0; i < cloud_.owned; ++i) {
      if (role_[i] != Role::free) continue;
      const double size = std::abs(values[i]);
      if (!(size <= largest)) largest = std::isnan(size) ? std::numeric_limits<double>::infinity() : size;
    }
  }
  return max(cloud_.comm, largest);
}

void HeatSystem::residual(double t, std::span<double> u, double rate_factor, std::span<const double> known,
                          std::span<double> R, Rate& rate) {
  rate.F.resize(cloud_.owned), rate.power.resize(accounts_.size());
  this->rate(t, u, rate.F, rate.power);
  collective_try(cloud_.comm, [&] {
    if (known.empty())
      std::ranges::fill(R, 0);
    else
      discretisation_.capacity->evaluate(*at_, R, {});
    for (int i = 0; i < cloud_.owned; ++i) R[i] -= rate_factor * rate.F[i] + (known.empty() ? 0 : known[i]);
    for (const auto& constraint : discretisation_.constraints) {
      constraint->residual(*at_, R);
      for (const int i : constraint->points()) R[i] = -R[i];
    }
  });
}

void HeatSystem::residual_scale(double t, std::span<double> u, std::span<double> scale) {
  cloud_.halo.update(u);
  at_->begin(t, u);
  collective_try(cloud_.comm, [&] {
    discretisation_.capacity->evaluate(*at_, {}, scale);
    for (const auto& constraint : discretisation_.constraints) constraint->scale(*at_, scale);
  });
}

void HeatSystem::heat_flux(double t, std::span<double> u, std::span<Vec3> q) {
  cloud_.halo.update(u);
  std::ranges::fill(q, Vec3{});
  at_->begin(t, u);
  std::vector<int> points(cloud_.owned);
  std::iota(points.begin(), points.end(), 0);
  collective_try(cloud_.comm, [&] { discretisation_.conduction->heat_flux(*at_, points, q); });
}

std::vector<double> HeatSystem::shifted_at_corners(double t, std::span<double> u) {
  std::vector<double> power(accounts_.size());
  if (!corners_.exist()) return power;
  cloud_.halo.update(u);
  at_->begin(t, u);
  std::vector<Vec3> q(corners_.points().size());
  collective_try(cloud_.comm, [&] { discretisation_.conduction->heat_flux(*at_, corners_.points(), q); });
  corners_.shift(q, power);
  return power;
}

std::vector<HeatSystem::SourcePower> HeatSystem::source_powers(double t, std::span<const double> T) {
  std::vector<SourcePower> powers;
  for (const auto& source : sources_) {
    source->prepare(t);
    std::vector<double> P(cloud_.owned);
    collective_try(cloud_.comm, [&] { source->add_power(t, T.first(cloud_.owned), P); });
    const double deposited = sum(cloud_.comm, P);
    powers.push_back({source->asked(t).value_or(deposited), deposited});
  }
  return powers;
}

std::optional<double> HeatSystem::energy_asked(double t) const {
  double energy = 0;
  for (const auto& source : sources_) {
    const auto asked = source->energy_asked(t);
    if (!asked) return std::nullopt;
    energy += *asked;
  }
  return energy;
}

double HeatSystem::longest_step(double begin, double end) const {
  double longest = std::numeric_limits<double>::infinity();
  for (const auto& source : sources_) longest = std::min(longest, source->longest_step(begin, end));
  return longest;
}

void HeatSystem::find_changes() {
  for (const HeatTerm* term : terms_) changes_.add(term->changes());
  for (const PrescribedTerm& term : conditions_.temperatures) changes_.add(term.temperature.changes());
  for (std::vector<double>* times : {&changes_.events, &changes_.marks}) {
    std::ranges::sort(*times);
    times->erase(std::unique(times->begin(), times->end()), times->end());
  }
}

void HeatSystem::apply(double t) {
  for (HeatTerm* term : terms_) term->apply(t);
}

bool HeatSystem::level_is_fixed() const {
  bool fixed = std::ranges::any_of(terms_, [](const HeatTerm* term) { return term->traits().fixes_level; });
  for (const auto& constraint : discretisation_.constraints) fixed = fixed || constraint->traits().fixes_level;
  return any(cloud_.comm, fixed);
}

ValueRange HeatSystem::outer_temperatures(double t) {
  ValueRange range;
  const auto see = [&](double T) { range.low = std::min(range.low, T), range.high = std::max(range.high, T); };
  collective_try(cloud_.comm, [&] {
    for (const PrescribedTerm& term : conditions_.temperatures) {
      std::vector<double> wall(term.x.size());
      term.temperature.evaluate({.x = term.x, .t = t}, wall);
      std::ranges::for_each(wall, see);
    }
    for (const SurfaceTerm& term : conditions_.fluxes) std::ranges::for_each(term.flux->ambient(term.x, t), see);
  });
  return {.low = min(cloud_.comm, range.low), .high = max(cloud_.comm, range.high)};
}

ValueRange HeatSystem::body_temperatures(std::span<double> u) {
  if (!discretisation_.dofs->are_temperatures()) cloud_.halo.update(u);
  at_->begin(0, u);
  const ValueRange range = range_of(at_->T());
  return {.low = min(cloud_.comm, range.low), .high = max(cloud_.comm, range.high)};
}

ValueRange HeatSystem::given_heat(double t, std::span<double> u) {
  if (given_.empty()) return {.low = 0, .high = 0};
  cloud_.halo.update(u);
  std::vector<double> F(cloud_.owned), power(accounts_.size());
  for (HeatTerm* term : given_) term->prepare(t);
  at_->begin(t, u);
  collective_try(cloud_.comm, [&] {
    for (HeatTerm* term : given_) term->add_rate(*at_, F, power);
  });
  const ValueRange range = range_of(F);
  return {.low = min(cloud_.comm, range.low), .high = max(cloud_.comm, range.high)};
}

ValueRange HeatSystem::temperature_extremes(double t, std::span<const double> u) {
  const ValueRange outer = outer_temperatures(t);
  at_->begin(t, u);
  const ValueRange body = range_of(at_->T());
  return {.low = min(cloud_.comm, std::min(body.low, outer.low)),
          .high = max(cloud_.comm, std::max(body.high, outer.high))};
}

void HeatSystem::require_finite(double t, std::span<const double> u) const {
  collective_try(cloud_.comm, [&] {
    if (all_finite(u.first(cloud_.owned))) return;
    for (int i = 0; i < cloud_.owned; ++i) {
      if (std::isfinite(u[i])) continue;
      const Vec3& x = cloud_.x[i];
      throw Error(Fault::numbers,
                  fmt::format("the temperature of point {} at ({:.6g}, {:.6g}, {:.6g}) m is {} at t = {:.6g} s",
                              cloud_.id[i], x.x, x.y, x.z, u[i], t),
                  "take a smaller [time] step, or an integrator that chooses it");
    }
  });
}

}  // namespace calor
