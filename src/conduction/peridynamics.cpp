#include "conduction/peridynamics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/cracks.hpp"
#include "cloud/lattice.hpp"
#include "conduction/cracked_pairs.hpp"
#include "conduction/mirror_images.hpp"

namespace calor {

namespace {

constexpr double usual_horizon = 3.015, short_horizon = 2;

/// The horizon that the case asks for, or what suits the cloud: lattices in cells with images beyond all walls take the
/// customary one; elsewhere a short reach leaves fewer negative weights and smaller errors at walls.
Support horizon_of(const Table& options, bool lattice_in_cells) {
  if (!options.has("horizon")) return lattice_in_cells ? usual_horizon : short_horizon;
  const auto given = options.quantities_with_units("horizon");
  if (given.size() != 1)
    options.refuse("horizon", "several numbers", "give one: a multiple of the spacing or a length");
  const auto& [value, unit] = given.front();
  if (unit.empty()) {
    if (!(value >= 1 && value <= 30))
      options.refuse(
          "horizon", fmt::format("a horizon of {:g} spacings does not lie between 1 and 30", value),
          "take 3.015 on lattices of cells without heat fluxes on walls, 2 on other clouds; a length needs its unit");
    return value;
  }
  const double length = options.in_si("horizon", given.front(), "m", "length",
                                      "give a multiple of the spacing, such as 3.015, or a length, such as \"0.3 mm\"");
  if (!(length > 0))
    options.refuse("horizon", fmt::format("a horizon of {:g} m is not positive", length), "give a positive one");
  return {0, length};
}

bool is_paper(const Table& options) { return options.text("correction") == "paper"; }

Peridynamics options_of(const Table& table, bool lattice_in_cells) {
  Peridynamics options{.n = static_cast<int>(table.integer("n")),
                       .horizon = horizon_of(table, lattice_in_cells),
                       .partial_volumes = table.flag("partial_volumes"),
                       .surface_correction = table.flag("surface_correction")};
  if (options.n < 0 || options.n > 2)
    table.refuse("n", fmt::format("n = {}", options.n), "take 0, 1 or 2, the power of the distance in the bond");
  if (!options.surface_correction && !is_paper(table))
    table.refuse("surface_correction", "surface_correction belongs to correction = \"paper\"",
                 "write correction = \"paper\", or leave it out");
  return options;
}

Support support_of(const Case& c) { return options_of(c.section("peridynamics"), true).support(); }

Discretisation build(const Case& c, const Cloud& cloud, const Conditions& conditions, const MaterialField& material,
                     MethodReport& report) {
  const Table table = c.section("peridynamics");
  const bool has_fluxes = any(
      cloud.comm, std::ranges::any_of(conditions.fluxes, [](const SurfaceTerm& term) { return !term.facet.empty(); }));
  const bool in_cells = cloud.lattice && has_images(c, cloud, material.parts());
  const Peridynamics options = options_of(table, in_cells && (!has_fluxes || is_paper(table)));
  const Layers layers = table.text("fictitious_layers") == "odd" ? Layers::odd : Layers::constant;
  if (is_paper(table) && has_cracks(c))
    table.refuse("correction", "correction = \"paper\" knows no cracks", "use correction = \"consistent\"");
  if (is_paper(table) && cloud.axisymmetric)
    table.refuse("correction", "correction = \"paper\" knows no axisymmetric bodies",
                 "use correction = \"consistent\"");
  if (!is_paper(table) && !cloud.has_areas)
    table.refuse(
        "correction",
        "correction = \"consistent\" needs to know the surface of the body, but the cloud has no boundary areas",
        "give the columns area_x, area_y, area_z of the boundary points in the cloud's file, or take "
        "correction = \"paper\"");
  if (is_paper(table) && !material.is_isotropic())
    table.refuse("correction", "correction = \"paper\" knows no anisotropy", "use correction = \"consistent\"");
  const PairDirections directions = pair_directions(c, cloud, material, true);
  MirroredNeighbours mirrored =
      neighbours_of_body(c, cloud, material.parts(), options.support(), conditions, table.text("insulated") == "even");
  count_pairs(cloud, mirrored.neighbours, report);
  std::optional<Cloud> copy;
  if (is_paper(table)) {
    auto G = bond_weights(without_cracks(cloud, copy), mirrored.neighbours, options);
    return pair_discretisation(cloud, material.parts(), conditions, std::move(mirrored), std::move(G), layers);
  }
  CorrectionReport done;
  auto G = peridynamic_weights(without_cracks(cloud, copy), mirrored.neighbours, options, done, directions);
  require_sound(cloud, done, directions.in_weights.has_value());
  auto discretisation =
      with_cracks(c, cloud, material, conditions, std::move(mirrored), std::move(G), layers, done, report, directions);
  add_to_report(done, report);
  return discretisation;
}

}  // namespace

double micro_conductivity(int dimension, int n, double horizon) {
  // kappa = 2 / integral of xi_x^2 / |xi|^n dV over the family.
  constexpr double pi = std::numbers::pi;
  const int power = dimension + 2 - n;
  const double sphere = dimension == 1 ? 2 : dimension == 2 ? 2 * pi : 4 * pi;
  return 2 * dimension * power / (sphere * std::pow(horizon, power));
}

Support Peridynamics::support() const {
  return partial_volumes ? Support{horizon.over_spacing + 0.5, horizon.length}
                         : Support{horizon.over_spacing * (1 + 2e-9), horizon.length * (1 + 2e-9)};
}

std::vector<double> base_weights(const Cloud& cloud, const Neighbours& neighbours, const Peridynamics& options) {
  std::vector<double> g = PairRows::weights_of(neighbours);
  const double kappa = micro_conductivity(cloud.dimension, options.n, 1);
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      const Vec3 x_ji = neighbours.x_ji(cloud.x, i, n), s = cloud.mean_metric(i, j), delta = options.horizon.radius(s);
      const double r = norm(quotient(x_ji, s)), rho = norm(quotient(x_ji, delta));  // over spacings, over the horizon
      double family = delta.x;
      for (int a = 1; a < cloud.dimension; ++a) family *= delta[a];
      const double v = options.partial_volumes ? std::clamp(r / rho + 0.5 - r, 0.0, 1.0) : 1;
      const double rho_n = options.n == 0 ? rho * rho : options.n == 1 ? rho : 1;
      g[n] = kappa * v * (cloud.volume[i] * cloud.volume[j]) / family * (rho_n / dot(x_ji, x_ji)) / cloud.section(i, j);
    }
  }
  return g;
}

std::vector<double> peridynamic_weights(const Cloud& cloud, const Neighbours& neighbours, const Peridynamics& options,
                                        CorrectionReport& report, const PairDirections& directions) {
  // G |x_ji|^2 of points r spacings apart, delta the horizon in spacings.
  const auto conductance = [&](double r, double delta) {
    const double whole = r <= delta * (1 + 1e-9) ? 1 : 0;
    const double v = options.partial_volumes ? std::clamp(delta + 0.5 - r, 0.0, 1.0) : whole;
    return v * std::pow(r, 2 - options.n);
  };
  if ((cloud.lattice && !cloud.box_lattice) || !directions.of_parts.empty()) {
    const LineForce force = [&](std::int64_t /*steps*/, double distance, double spacing) {
      const double r = distance / spacing, delta = options.horizon.radius(spacing) / spacing;
      return conductance(r, delta) / r * std::pow(delta, options.n - 3);
    };
    return lattice_line_weights(cloud, neighbours, force, report);
  }
  const BaseWeights base = [&] { return base_weights(cloud, neighbours, options); };
  LatticeWeight on_lattice;
  if (cloud.lattice) {
    const double spacing = cloud.lattice->largest_dx();
    on_lattice = [=](double r) { return conductance(r, options.horizon.radius(spacing) / spacing); };
  }
  return directions.in_weights ? anisotropic_weights(cloud, neighbours, *directions.in_weights, base, report)
                               : consistent_weights(cloud, neighbours, base, on_lattice, report);
}

std::vector<double> bond_weights(const Cloud& cloud, const Neighbours& neighbours, const Peridynamics& options) {
  std::vector<double> G = base_weights(cloud, neighbours, options);
  if (!options.surface_correction) return G;
  // Potentials of T = x_d: classical V_i / 2, of the bonds 1/4 sum_j G_ij xi_d^2.
  std::vector<Vec3> factor(cloud.local());
  for (int i = 0; i < cloud.owned; ++i) {
    Vec3 bonds;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 xi = neighbours.x_ji(cloud.x, i, n);
      bonds += G[n] * Vec3{xi.x * xi.x, xi.y * xi.y, xi.z * xi.z};
    }
    for (int d = 0; d < cloud.dimension; ++d) factor[i][d] = 2 * cloud.volume[i] / bonds[d];
  }
  cloud.halo.update(std::span<Vec3>(factor));
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 xi = neighbours.x_ji(cloud.x, i, n), mean = 0.5 * (factor[i] + factor[neighbours.column[n]]);
      double squares = 0;
      for (int d = 0; d < cloud.dimension; ++d) squares += xi[d] * xi[d] / (mean[d] * mean[d]);
      G[n] *= norm(xi) / std::sqrt(squares);
    }
  }
  return G;
}

namespace {

void declare_peridynamics(Schema& schema) {
  schema.add(
      {.path = "peridynamics",
       .sentence = "Options of bond-based peridynamics.",
       .keys = {
           {"n", Kind::integer, "", "2", "Heat of a bond falls with this power of its length: 0, 1 or 2."},
           {"horizon", Kind::raw_quantities, "", optional,
            "Radius within which points exchange heat: a multiple of the spacing, or a length with its unit; default: "
            "3.015 on lattices of cells without heat fluxes on walls and without cracks, 2 on other clouds."},
           {"correction",
            Kind::choice,
            "",
            "consistent",
            "How the bonds are corrected: \"consistent\" conserves heat and is of second order on any cloud; \"paper\" "
            "scales them by direction (surface correction).",
            {"consistent", "paper"}},
           {"partial_volumes", Kind::flag, "", "true", "Do cells that the horizon cuts count in part?"},
           {"surface_correction", Kind::flag, "", "true", "With correction = \"paper\": scale the bonds at all?"},
           {"fictitious_layers",
            Kind::choice,
            "",
            "odd",
            "Temperatures beyond walls of prescribed temperature on cell-centred clouds: \"odd\" reflection, of "
            "second order, or \"constant\" temperature, of first order.",
            {"odd", "constant"}},
           {"insulated",
            Kind::choice,
            "",
            "even",
            "Insulated walls of cell-centred boxes: \"even\" reflection beyond them, or \"truncated\" families.",
            {"even", "truncated"}}}});
}

}  // namespace

Method peridynamics_method() {
  return {.name = "peridynamics",
          .sentence = "bond-based peridynamics",
          .declare = declare_peridynamics,
          .support = support_of,
          .build = build};
}

}  // namespace calor
