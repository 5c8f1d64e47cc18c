#include "solve/wall_fluxes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"

namespace calor {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace

WallFluxes::WallFluxes(const Cloud& cloud, const MaterialField& material, std::span<const SurfaceTerm> terms,
                       const WallLayers* layers)
    : cloud_(cloud), layers_(layers) {
  for (const SurfaceTerm& term : terms) {
    if (term.is_plate) continue;
    fluxes_.push_back({.term = &term, .wall = {}});
    depends_on_T_ = depends_on_T_ || term.flux->depends_on_temperature();
    is_linear_ = is_linear_ && (!term.flux->depends_on_temperature() || term.flux->linear_in_temperature());
  }
  find_walls();
  if (!layers && !material.is_isotropic()) count_direction(material);
}

/// Multiplies the conductances by n.R n.
void WallFluxes::count_direction(const MaterialField& material) {
  std::vector<int> part;
  collective_try(cloud_.comm, [&] { part = material.parts().at(cloud_.x, cloud_.tag); });
  for (Wall& wall : walls_) {
    const Vec3& n = cloud_.facets[wall.facet].normal;
    if (const Anisotropy* R = material.anisotropy(part[wall.point]))
      wall.area_over_depth *= dot(n, R->at(cloud_.x[wall.point]) * n);
  }
}

void WallFluxes::find_walls() {
  // The fluxes of one section act on the same part of a facet, those of several sections on parts that may overlap.
  struct Parts {
    std::map<int, double> of_section;
  };
  std::map<int, Parts> facets;
  for (const Flux& flux : fluxes_) {
    std::map<int, double> area;
    for (std::size_t p = 0; p < flux.term->facet.size(); ++p) area[flux.term->facet[p]] += flux.term->area[p];
    for (const auto& [facet, a] : area) {
      double& most = facets[facet].of_section[flux.term->account];
      most = std::max(most, a);
    }
  }
  std::map<int, int> number;
  for (const auto& [n, parts] : facets) {
    const Facet& facet = cloud_.facets[n];
    double area = 0;
    for (const auto& [section, part] : parts.of_section) area += part;
    number[n] = static_cast<int>(walls_.size());
    Wall& wall = walls_.emplace_back();
    wall.facet = n, wall.point = facet.point;
    wall.share = std::min(1.0, area / facet.area);
    wall.area_over_depth = wall.share * facet.area / wall_distance(cloud_, facet);
  }
  for (Flux& flux : fluxes_) {
    for (const int facet : flux.term->facet) flux.wall.push_back(number[facet]);
    for (auto* values : {&flux.T, &flux.q, &flux.dq_dT, &flux.q_new, &flux.dq_dT_new}) values->resize(flux.wall.size());
  }
}

void WallFluxes::begin(Evaluation& at) {
  const std::span<const double> T = at.T(), k = coefficients(at).k();
  for (Wall& wall : walls_) {
    wall.G = layers_ ? wall.share * layers_->conductance(wall.facet, k) : wall.area_over_depth * k[wall.point];
    wall.T_point = wall.T = T[wall.point];
    wall.given = 0, wall.low = -infinite, wall.high = infinite, wall.step = 0, wall.is_open = true;
  }
  for (Flux& flux : fluxes_) {
    if (flux.term->flux->depends_on_temperature() || flux.wall.empty()) continue;
    flux.term->flux->evaluate({.x = flux.term->x, .t = at.t()}, flux.q, {});
    for (std::size_t p = 0; p < flux.q.size(); ++p) walls_[flux.wall[p]].given += flux.term->area[p] * flux.q[p];
  }
}

void WallFluxes::bound_by_ambients(double t) {
  for (Wall& wall : walls_) wall.low = wall.high = wall.T_point;
  for (const Flux& flux : fluxes_) {
    const SurfaceFlux& law = *flux.term->flux;
    if (!law.depends_on_temperature() || flux.wall.empty()) continue;
    const std::vector<double> ambient = law.draws_to_ambient() ? law.ambient(flux.term->x, t) : std::vector<double>();
    for (std::size_t p = 0; p < flux.wall.size(); ++p) {
      Wall& wall = walls_[flux.wall[p]];
      wall.low = std::min(wall.low, ambient.empty() ? -infinite : ambient[p]);
      wall.high = std::max(wall.high, ambient.empty() ? infinite : ambient[p]);
    }
  }
  for (Wall& wall : walls_) {
    wall.low += std::min(0.0, wall.given / wall.G);
    wall.high += std::max(0.0, wall.given / wall.G);
  }
}

void WallFluxes::evaluate(Flux& flux, double t) {
  for (std::size_t p = 0; p < flux.T.size(); ++p) flux.T[p] = walls_[flux.wall[p]].T;
  flux.term->flux->evaluate({.x = flux.term->x, .t = t, .T = flux.T}, flux.q_new, flux.dq_dT_new);
  for (std::size_t p = 0; p < flux.T.size(); ++p) {
    Wall& wall = walls_[flux.wall[p]];
    if (!wall.is_open) continue;  // what one wall takes must not depend on how many steps the others need
    flux.q[p] = flux.q_new[p], flux.dq_dT[p] = flux.dq_dT_new[p];
    wall.Q += flux.term->area[p] * flux.q[p];
    wall.slope += flux.term->area[p] * flux.dq_dT[p];
  }
}

/// Newton's method; where it leaves the bounds between which the residual changes sign, they are halved, or widened
/// where one of them is not known yet.
void WallFluxes::take_step(Wall& wall) const {
  const double residual = wall.Q + wall.G * (wall.T_point - wall.T), slope = wall.slope - wall.G;
  if (residual == 0) {
    wall.step = 0, wall.is_open = false;
    return;
  }
  (residual > 0 ? wall.low : wall.high) = wall.T;
  double next = slope < 0 ? wall.T - residual / slope : residual > 0 ? infinite : -infinite;
  const bool is_newton = slope < 0 && (is_linear_ || (next >= wall.low && next <= wall.high));
  if (!is_newton) {
    const double wider = std::max(1.0, 2 * std::abs(wall.step));
    next = std::isfinite(wall.low) && std::isfinite(wall.high) ? 0.5 * (wall.low + wall.high)
           : residual > 0                                      ? wall.T + wider
                                                               : wall.T - wider;
  }
  wall.step = next - wall.T;
  wall.T = next;
  // The heat follows the last step by its derivative: what is left is of the square of this.
  constexpr double small = 1e-8;
  const bool is_small = std::abs(wall.step) <= small * std::max(std::abs(wall.T), std::abs(wall.T_point));
  const bool at_jump = wall.high - wall.low <= 1e-14 * std::abs(wall.T);
  wall.is_open = !((is_newton && (is_linear_ || is_small)) || at_jump);
  if (!is_newton && !wall.is_open) wall.step = 0;
}

void WallFluxes::solve(Evaluation& at) {
  begin(at);
  if (!depends_on_T_) {
    for (Wall& wall : walls_) wall.Q = wall.given, wall.slope = 0;
    return;
  }
  if (!is_linear_) bound_by_ambients(at.t());
  constexpr int most_steps = 200;
  for (int n = 0; std::ranges::any_of(walls_, &Wall::is_open); ++n) {
    if (n == most_steps) {
      const Wall& wall = *std::ranges::find_if(walls_, &Wall::is_open);
      const Vec3& x = cloud_.x[wall.point];
      throw Error(Fault::numbers,
                  fmt::format("no temperature of the wall beside the point at ({:.6g}, {:.6g}, {:.6g}) m balances its "
                              "heat at t = {:.6g} s: after {} steps it is {:.6g} K",
                              x.x, x.y, x.z, at.t(), most_steps, wall.T),
                  "the flux grows faster with the temperature than the body conducts: take more points, or mend the "
                  "law of the flux");
    }
    for (Wall& wall : walls_)
      if (wall.is_open) wall.Q = wall.given, wall.slope = 0;
    for (Flux& flux : fluxes_)
      if (flux.term->flux->depends_on_temperature() && !flux.wall.empty()) evaluate(flux, at.t());
    for (Wall& wall : walls_)
      if (wall.is_open) take_step(wall);
  }
}

void WallFluxes::add_rate(Evaluation& at, std::span<double> F, std::span<double> power) {
  if (walls_.empty()) return;
  solve(at);
  for (const Flux& flux : fluxes_) {
    const bool follows = flux.term->flux->depends_on_temperature();
    double total = 0;
    for (std::size_t p = 0; p < flux.q.size(); ++p) {
      const Wall& wall = walls_[flux.wall[p]];
      const double heat = flux.term->area[p] * (flux.q[p] + (follows ? flux.dq_dT[p] * wall.step : 0));
      F[wall.point] += heat;
      total += heat;
    }
    power[flux.term->account] += total;
  }
}

/// dQ/dT_i, by the derivative of the wall's balance.
double WallFluxes::derivative(const Wall& wall, std::span<const double> k, std::span<const double> dk_dT) const {
  if (wall.slope == 0) return 0;
  const double dG = dk_dT.empty() ? 0
                    : layers_     ? wall.share * layers_->derivative(wall.facet, k, dk_dT)
                                  : wall.area_over_depth * dk_dT[wall.point];
  return wall.slope * (wall.G + dG * (wall.T_point - wall.T)) / (wall.G - wall.slope);
}

void WallFluxes::add_jacobian(Evaluation& at, JacobianEntries& J) {
  if (walls_.empty() || !depends_on_T_) return;
  solve(at);
  const std::span<const double> dk_dT = coefficients(at).dk_dT(), k = coefficients(at).k();
  for (const Wall& wall : walls_) J.add_nodal(wall.point, derivative(wall, k, dk_dT));
}

void WallFluxes::add_row_sums(Evaluation& at, std::span<double> sums) {
  if (walls_.empty() || !depends_on_T_) return;
  solve(at);
  for (const Wall& wall : walls_) sums[wall.point] += std::abs(derivative(wall, {}, {}));
}

Traits WallFluxes::traits() const {
  bool is_constant = true;
  for (const Flux& flux : fluxes_) {
    const SurfaceFlux& law = *flux.term->flux;
    if (law.depends_on_temperature())
      is_constant = is_constant && law.linear_in_temperature() && !law.derivative_depends_on_time();
  }
  return {.is_constant = is_constant, .fixes_level = depends_on_T_ && !walls_.empty()};
}

Changes WallFluxes::changes() const {
  Changes all;
  for (const Flux& flux : fluxes_) all.add(flux.term->flux->changes());
  return all;
}

void WallFluxes::wall_temperatures(Evaluation& at, std::span<double> T) {
  if (walls_.empty()) return;
  solve(at);
  for (const Wall& wall : walls_)
    T[wall.facet] = depends_on_T_ ? wall.T : wall.T_point + (wall.G > 0 ? wall.given / wall.G : 0);
}

}  // namespace calor
