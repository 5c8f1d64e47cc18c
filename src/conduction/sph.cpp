#include "conduction/sph.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cracks.hpp"
#include "conduction/cracked_pairs.hpp"
#include "conduction/mirror_images.hpp"
#include "conduction/zeta_rows.hpp"

namespace calor {

namespace {

/// C of W = C / h^D w(r/h): the integral of W is 1.
double kernel_constant(int dimension) {
  constexpr double pi = std::numbers::pi;
  return dimension == 1 ? 2.0 / 3 : dimension == 2 ? 10 / (7 * pi) : 1 / pi;
}

double power(double h, int n) {
  double p = 1;
  for (; n > 0; --n) p *= h;
  return p;
}

/// The smoothing that the case asks for, or what suits the cloud.
double smoothing_of(const Table& options, bool exact_lattice) {
  if (!options.has("smoothing")) return exact_lattice ? 1 : 1.2;
  const double smoothing = options.number("smoothing");
  if (!(smoothing > 0.5 && smoothing <= 5)) {
    options.refuse("smoothing",
                   fmt::format("smoothing = {:g}: h over spacing must lie above 0.5 and not beyond 5", smoothing),
                   "take 1 on box lattices, 1.2 on other clouds");
  }
  return smoothing;
}

/// Weights that end where those of a lattice do.
bool is_one_layer(double smoothing) { return std::abs(smoothing - 1) < 1e-9; }

Support support_of(const Case& c) { return sph_support(smoothing_of(c.section("sph"), false)); }

/// The paper's own scheme with corrected constants (docs/theory, "paper"): full cell volumes in all pairs, and at wall
/// points, which hold no heat, the rows k_i 2 sum_j V_j (T_j - T_i) grad W_ij . n = heat flux into the body. The pair
/// sum is not divided by its second moment, as printed.
Discretisation paper_scheme(const Cloud& cloud, const Parts& parts, const Conditions& conditions, Neighbours neighbours,
                            double smoothing) {
  auto G = sph_base_weights(cloud, neighbours, cloud.full_volume, smoothing);
  // 2 V_j grad W_ij = 2 V_j F_ij x_ji = G_ij x_ji / V_i, all volumes full.
  auto walls = zeta_rows(cloud, neighbours, G, conditions);
  auto pairs = std::make_unique<PairConduction>(cloud, parts, std::move(neighbours), std::move(G));
  return nodal_discretisation(cloud, conditions, std::move(pairs), {}, std::move(walls));
}

Discretisation build(const Case& c, const Cloud& cloud, const Conditions& conditions, const MaterialField& material,
                     MethodReport& report) {
  const Table options = c.section("sph");
  const bool paper = options.text("correction") == "paper";
  if (!cloud.has_areas) {
    c.section("cloud").refuse(
        "file",
        fmt::format("correction = \"{}\" needs to know the surface of the body, but the cloud has no boundary areas",
                    options.text("correction")),
        "give the columns area_x, area_y, area_z of the boundary points in the cloud's file");
  }
  if (paper && has_cracks(c))
    options.refuse("correction", "correction = \"paper\" knows no cracks", "use correction = \"consistent\"");
  if (paper && cloud.axisymmetric)
    options.refuse("correction", "correction = \"paper\" knows no axisymmetric bodies",
                   "use correction = \"consistent\"");
  if (paper && !cloud.points_on_walls) {
    options.refuse("correction",
                   "correction = \"paper\" writes the wall conditions at points on the walls, and the cloud has none",
                   "use at = \"walls\" in [cloud], or correction = \"consistent\"");
  }
  if (paper && !material.is_isotropic())
    options.refuse("correction", "correction = \"paper\" knows no anisotropy", "use correction = \"consistent\"");
  const bool one_layer = !options.has("smoothing") || is_one_layer(options.number("smoothing"));
  const PairDirections directions = pair_directions(c, cloud, material, one_layer);
  const double smoothing = smoothing_of(options, cloud.lattice && !directions.in_weights);
  MirroredNeighbours mirrored =
      neighbours_of_body(c, cloud, material.parts(), sph_support(smoothing), conditions, true);
  count_pairs(cloud, mirrored.neighbours, report);
  report["smoothing"] = smoothing;
  if (paper) return paper_scheme(cloud, material.parts(), conditions, std::move(mirrored.neighbours), smoothing);

  CorrectionReport done;
  std::optional<Cloud> copy;
  auto G = sph_consistent_weights(without_cracks(cloud, copy), mirrored.neighbours, smoothing, done, directions);
  require_sound(cloud, done, directions.in_weights.has_value());
  auto discretisation = with_cracks(c, cloud, material, conditions, std::move(mirrored), std::move(G), Layers::odd,
                                    done, report, directions);
  add_to_report(done, report);
  return discretisation;
}

}  // namespace

double cubic_spline(double r, double h, int dimension) {
  const double z = r / h, c = kernel_constant(dimension) / power(h, dimension);
  if (z < 1) return c * (1 - 1.5 * z * z + 0.75 * z * z * z);
  if (z < 2) return c * 0.25 * (2 - z) * (2 - z) * (2 - z);
  return 0;
}

double cubic_spline_F(double r, double h, int dimension) {
  const double z = r / h, c = kernel_constant(dimension) / power(h, dimension + 2);
  if (z < 1) return c * (3 - 2.25 * z);
  if (z < 2) return c * 0.75 * (2 - z) * (2 - z) / z;
  return 0;
}

std::vector<double> sph_base_weights(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> V,
                                     double smoothing) {
  std::vector<double> g = PairRows::weights_of(neighbours);
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      const Vec3 x_ji = neighbours.x_ji(cloud.x, i, n);
      const double square = square_in_spacings(cloud, neighbours, i, n);
      const double F = cubic_spline_F(std::sqrt(square), smoothing, cloud.dimension) / cell_size(cloud, i, j);
      g[n] = 2 * (V[i] * V[j]) * (F * square / dot(x_ji, x_ji)) / cloud.section(i, j);
    }
  }
  return g;
}

std::vector<double> sph_consistent_weights(const Cloud& cloud, const Neighbours& neighbours, double smoothing,
                                           CorrectionReport& report, const PairDirections& directions) {
  const bool one_layer = is_one_layer(smoothing);
  if ((one_layer && cloud.lattice && !cloud.box_lattice) || !directions.of_parts.empty())
    return neighbour_line_weights(cloud, neighbours, report);
  const BaseWeights base = [&] { return sph_base_weights(cloud, neighbours, cloud.volume, smoothing); };
  if (directions.in_weights) return anisotropic_weights(cloud, neighbours, *directions.in_weights, base, report);
  const LatticeWeight on_lattice = [&](double r) { return r * r * cubic_spline_F(r, smoothing, cloud.dimension); };
  return consistent_weights(cloud, neighbours, base, on_lattice, report);
}

namespace {

void declare_sph(Schema& schema) {
  schema.add(
      {.path = "sph",
       .sentence = "Options of smoothed particle hydrodynamics.",
       .keys = {{"smoothing", Kind::number, "", optional,
                 "Smoothing length over spacing; default: 1 on box lattices without jitter, where it is "
                 "exact, 1.2 on other clouds."},
                {"correction",
                 Kind::choice,
                 "",
                 "consistent",
                 "How the pairs are corrected: \"consistent\" conserves heat and is of second order on any cloud; "
                 "\"paper\" is the paper's own treatment of walls, for comparison.",
                 {"consistent", "paper"}}}});
}

}  // namespace

Method sph_method() {
  return {.name = "sph",
          .sentence = "smoothed particle hydrodynamics",
          .declare = declare_sph,
          .support = support_of,
          .build = build};
}

}  // namespace calor
