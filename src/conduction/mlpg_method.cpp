// The method as a case file asks for it: its keys, what it refuses, and the discretisation it builds.
#include "conduction/mlpg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/cracks.hpp"
#include "cloud/lattice.hpp"
#include "conduction/brick_weights.hpp"
#include "conduction/constraint.hpp"
#include "conduction/cracked_pairs.hpp"
#include "conduction/mlpg_stability.hpp"
#include "conduction/sph.hpp"

namespace calor {

namespace {

MlpgOptions options_of(const Table& table, int dimension, bool regular) {
  MlpgOptions o = MlpgOptions::defaults(dimension, regular, table.text("basis") == "quadratic" ? 2 : 1);
  if (table.has("support") && table.has("neighbours"))
    table.refuse("neighbours", "the supports are given twice, by spacings and by neighbours", "keep one of them");
  if (table.has("support")) o.support.spacings = table.number("support");
  if (!(o.support.spacings >= 1.1 && o.support.spacings <= 5))
    table.refuse("support", fmt::format("support = {:g}: it must lie between 1.1 and 5 spacings", o.support.spacings),
                 "take 2.3 in two dimensions, 1.6 in three, 1.8 on irregular clouds");
  if (table.has("neighbours")) {
    o.support.neighbours = static_cast<int>(table.integer("neighbours"));
    if (o.support.neighbours < o.mls.terms() || o.support.neighbours > 200)
      table.refuse("neighbours",
                   fmt::format("neighbours = {}: a {} basis in {} dimensions needs {} to 200", o.support.neighbours,
                               table.text("basis"), dimension, o.mls.terms()),
                   "take 14 in two dimensions, 25 in three");
  }
  if (table.text("weight") == "wendland") o.mls.weight = MlsWeight::wendland;
  if (table.text("subdomain") == "sphere") o.subdomain = MlpgSubdomain::sphere, o.flux = MlpgFlux::parameters;
  if (table.has("flux")) o.flux = table.text("flux") == "parameters" ? MlpgFlux::parameters : MlpgFlux::edge_stabilised;
  if (table.has("capacity"))
    o.capacity = table.text("capacity") == "consistent" ? MlpgCapacity::consistent : MlpgCapacity::one_point;
  if (table.text("prescribed") == "penalty") o.prescribed = MlpgPrescribed::penalty;
  o.radius = table.number("radius");
  return o;
}

void refuse_what_does_not_fit(const Case& c, const Cloud& cloud, const MlpgOptions& o, bool between_points = false) {
  const Table body = c.section("cloud");
  if (!cloud.points_on_walls && !cloud.walls.empty() && !between_points)
    body.refuse(body.has("at") ? "at" : "", "mlpg needs points on the walls, and the cloud has none",
                "use at = \"walls\"");
  if (!cloud.has_areas)
    body.refuse("", "mlpg needs to know the surface of the body, but the cloud has no boundary areas",
                "give the columns area_x, area_y, area_z of the boundary points in the cloud's file");
  const Table table = c.section("mlpg");
  const bool values = o.flux == MlpgFlux::edge_stabilised;
  if (values && o.subdomain == MlpgSubdomain::sphere)
    table.refuse("flux", "the edge-stabilised flux goes through the face between two points; spheres have none",
                 "take flux = \"parameters\", or subdomain = \"tiles\"");
  if (values && table.has("capacity") && o.capacity == MlpgCapacity::consistent)
    table.refuse("capacity", "with flux = \"edge-stabilised\" every point holds the heat of its cell by itself",
                 "leave capacity out, or take flux = \"parameters\"");
  if (values && o.prescribed == MlpgPrescribed::penalty)
    table.refuse("prescribed",
                 "with flux = \"edge-stabilised\" the temperatures of the points are the unknowns themselves",
                 "leave prescribed out, or take flux = \"parameters\"");
  if (o.subdomain == MlpgSubdomain::sphere && cloud.axisymmetric)
    table.refuse("subdomain", "circles do not conserve the heat of rings: an axisymmetric body has none",
                 "take subdomain = \"tiles\"");
  if (o.prescribed == MlpgPrescribed::penalty && cloud.axisymmetric)
    table.refuse("prescribed", "an axisymmetric body takes no penalty", "take prescribed = \"collocation\"");
  if (o.subdomain == MlpgSubdomain::sphere && !(o.radius > 0.05 && o.radius < 1))
    table.refuse("radius", fmt::format("radius = {:g}: it must lie between 0.05 and 1 spacing", o.radius), "take 0.7");
}

Support support_of(const Case& c) {
  // Before there is a cloud: what any cloud may need. Values out of range are refused when the scheme is built.
  const Table table = c.section("mlpg");
  MlpgOptions o;
  if (table.has("support")) o.support.spacings = std::clamp(table.number("support"), 1.0, 5.0);
  if (table.has("neighbours"))
    o.support.neighbours = static_cast<int>(std::clamp(table.integer("neighbours"), 1l, 200l));
  return mlpg_support(o);
}

/// An unjittered lattice of one spacing along every axis, and of one thickness.
bool is_regular(const Cloud& cloud) { return cloud.lattice && !cloud.lattice->graded() && !cloud.axisymmetric; }

struct Stability {
  std::string unstable = {};            ///< why waves grow; empty: they do not
  std::vector<std::string> notes = {};  ///< where circles bias the diffusivity
};

Stability stability_of(const Table& table, const Cloud& cloud, const MlpgOptions& o, const FaceConduction& conduction,
                       bool transient, MethodReport& report) {
  const bool spheres = o.subdomain == MlpgSubdomain::sphere;
  if (is_regular(cloud) && o.support.neighbours == 0 && !o.anisotropy) {
    const bool one_point = o.capacity == MlpgCapacity::one_point;
    const auto cell =
        spheres ? lattice_sphere(cloud.dimension, o.radius, one_point) : lattice_box(cloud.dimension, one_point);
    const auto symbols = lattice_symbols(o.mls, o.support.spacings, cell, stretched_conductivity(*cloud.lattice));
    report["least_capacity_symbol"] = symbols.least_capacity;
    report["least_rate_symbol"] = symbols.least_rate;
    report["kappa"] = symbols.kappa;
    if (transient && !symbols.stable())
      return {.unstable = fmt::format("inside the lattice, waves have a heat capacity down to {:.2g} of the cell's and "
                                      "rates of decay down to {:.3g} diffusivity / spacing^2",
                                      symbols.least_capacity, symbols.least_rate)};
    if (!spheres || std::abs(symbols.kappa - 1) <= 1e-3) return {};
    return {.notes = {fmt::format(
                "{}: circles of radius {:g} with support {:g} conduct as if the diffusivity were {:.4f} of what it is, "
                "however fine the cloud; subdomain = \"tiles\" has no such error",
                table.location("subdomain").text(), o.radius, o.support.spacings, symbols.kappa)}};
  }
  const bool always_stable = o.mls.degree == 1 && cloud.dimension < 3 && !cloud.axisymmetric &&
                             o.support.neighbours == 0 && o.support.spacings <= 2.8 && !spheres && !o.anisotropy;
  if (!transient || always_stable) return {};
  const double growth = start_up_growth(
      cloud, conduction,
      o.anisotropy ? std::max({o.anisotropy->factors.x, o.anisotropy->factors.y, o.anisotropy->factors.z}) : 1);
  report["start_up_growth"] = growth;
  if (growth <= 1.02) return {};
  return {.unstable =
              std::isinf(growth)
                  ? "random temperatures blow up within 60 steps of a tenth of spacing^2 / diffusivity"
                  : fmt::format("random temperatures grow by a factor of {:.3g} in 20 steps of a tenth of spacing^2 / "
                                "diffusivity",
                                growth)};
}

/// The scheme as a discretisation.
Discretisation parameter_discretisation(const Cloud& cloud, const Conditions& conditions, MlpgScheme scheme) {
  const FaceRows& rows = scheme.conduction->rows();
  Discretisation d;
  d.locations = {&rows.conduction};
  if (rows.cells) d.locations.push_back(&*rows.cells);
  d.dofs = std::make_unique<Dofs>(cloud, rows.value, std::move(scheme.shapes));
  if (rows.cells)
    d.capacity = std::make_unique<CellCapacity>(*rows.cells, 2);
  else
    d.capacity =
        std::make_unique<LumpedCapacity>(std::vector(cloud.volume.begin(), cloud.volume.begin() + cloud.owned));
  if (!cloud.points_on_walls)
    d.walls.push_back(std::make_unique<SeriesWalls>(cloud, conditions.temperatures));
  else if (scheme.walls)
    d.walls.push_back(std::move(scheme.walls));
  else if (auto prescribed = prescribed_points(cloud, conditions.temperatures, *d.dofs, *d.capacity))
    d.constraints.push_back(std::move(prescribed));
  d.conduction = std::move(scheme.conduction);
  d.subdomains = std::move(scheme.subdomains);
  return d;
}

/// Bodies of several parts and cracked ones: a gradient of moving least squares would reach across interfaces, where it
/// jumps. The faces are parallel to the lines between the points then, a_ij = G_ij x_ji, so that the edge-stabilised
/// flux is that of the two points alone, in series through what lies between them. On lattices these are the faces of
/// the cells, elsewhere and beside cracks those of consistent weights.
Discretisation between_parts(const Case& c, const Cloud& cloud, const Conditions& conditions,
                             const MaterialField& material, MethodReport& report) {
  const bool tiles = cloud.lattice && !has_cracks(c);
  const PairDirections directions = pair_directions(c, cloud, material, tiles);
  const double smoothing = cloud.lattice && !directions.in_weights ? 1 : 1.2;  // the least that suits the cloud
  MirroredNeighbours pairs{find_neighbours(cloud, tiles ? 1.1 : sph_support(smoothing))};
  count_pairs(cloud, pairs.neighbours, report);
  CorrectionReport done;
  std::optional<Cloud> copy;
  auto G = tiles ? neighbour_line_weights(cloud, pairs.neighbours, done)
                 : sph_consistent_weights(without_cracks(cloud, copy), pairs.neighbours, smoothing, done, directions);
  require_sound(cloud, done, directions.in_weights.has_value());
  auto discretisation = with_cracks(c, cloud, material, conditions, std::move(pairs), std::move(G), Layers::odd, done,
                                    report, directions);
  add_to_report(done, report);
  return discretisation;
}

/// Is heat released inside the body?
bool has_sources_inside(const Case& c) {
  const auto sources = c.section("source").children();
  return !std::ranges::all_of(sources, [](const auto& child) { return child.second.has("surface"); });
}

/// Is heat given, and not drawn from surroundings?
bool is_heated(const Case& c) {
  const auto boundaries = c.section("boundary").children();
  return !c.section("source").children().empty() ||
         std::ranges::any_of(boundaries, [](const auto& child) { return child.second.has("flux"); });
}

/// In space on a lattice, does heat come through the surface, where the averaged flux is the better one? Inside, with
/// sources and in time, the differences across the faces alone have the smaller error.
bool comes_through_surface(const Case& c) { return !has_sources_inside(c) && (!c.root().has("time") || is_heated(c)); }

/// Largest factor by which the conductivity of a place changes within a tenth of the temperatures that the case brings
/// in; where the body is heated, which may lead far beyond them, within 20 K at least. Collective.
double steepest_conductivity(const Case& c, const Cloud& cloud, const MaterialField& material) {
  if (!material.conductivity_depends_on_T()) return 1;
  const bool heated = is_heated(c);
  const auto& [low, high, reference] = material.expected_range();
  const double window = std::max((high - low) / 10, heated ? 20.0 : 0.0), end = high + (heated ? 1500 : 0);
  constexpr int per_window = 4, most_places = 64;
  const std::size_t places = std::min(cloud.owned, most_places);
  std::vector<std::vector<double>> k;  // at the last temperatures
  double steepest = 1;
  try {
    for (int n = 0; window > 0 && low + n * window / per_window <= end; ++n) {
      const std::vector<double> T(places, low + n * window / per_window);
      material.conductivity(0, T, k.emplace_back(places), {});
      if (k.size() > per_window + 1) k.erase(k.begin());
      for (const std::vector<double>& before : k)
        for (std::size_t i = 0; i < places; ++i)
          steepest = std::max(steepest, std::max(before[i], k.back()[i]) / std::min(before[i], k.back()[i]));
    }
  } catch (const Error&) {  // the law ends there
  }
  return max(cloud.comm, steepest);
}

/// Is the averaged flux asked for, or the default?
bool averages(const Case& c, const Cloud& cloud, const MaterialField& material) {
  const Table table = c.section("mlpg");
  const bool can = cloud.lattice && cloud.points_on_walls && !cloud.axisymmetric && !has_cracks(c) &&
                   material.parts().count() == 1 && material.is_isotropic();
  if (!table.has("flux")) return can && cloud.dimension == 3 && table.keys().empty() && comes_through_surface(c);
  if (table.text("flux") != "averaged") return false;
  if (!can)
    table.refuse("flux",
                 "the averaged flux is one between the points of a lattice, in one part without cracks that "
                 "conducts alike in all directions",
                 "leave it out, or take flux = \"edge-stabilised\"");
  for (const char* key : {"basis", "support", "neighbours", "weight", "capacity", "subdomain", "prescribed"})
    if (table.has(key)) table.refuse(key, "the averaged flux takes differences between points alone", "leave it out");
  return true;
}

/// Of the gradient along the line between two points nothing but differences of temperatures remains on a lattice,
/// across the face and beside it.
Discretisation averaged_discretisation(const Cloud& cloud, const Conditions& conditions, MethodReport& report) {
  BrickWeights weights = brick_weights(cloud);
  report["pairs"] = static_cast<double>(total(cloud.comm, static_cast<std::int64_t>(weights.G.size())));
  report["negative_weights"] = 0;
  return nodal_discretisation(
      cloud, conditions, std::make_unique<PairConduction>(cloud, std::move(weights.neighbours), std::move(weights.G)));
}

Discretisation build(const Case& c, const Cloud& cloud, const Conditions& conditions, const MaterialField& material,
                     MethodReport& report) {
  if (averages(c, cloud, material)) return averaged_discretisation(cloud, conditions, report);
  const Table table = c.section("mlpg");
  MlpgOptions o = options_of(table, cloud.dimension, is_regular(cloud));
  const Parts& parts = material.parts();
  const bool is_broken = has_cracks(c) || parts.has_contacts();
  std::string asked;  // a key that only parameters have
  for (const char* key : {"flux", "subdomain", "capacity", "prescribed"})
    if (asked.empty() && table.has(key) && table.text(key) != "edge-stabilised") asked = key;
  if (is_broken && !asked.empty())
    table.refuse(asked, "the supports of moving least squares with parameters reach across cracks and contacts",
                 "leave it out, or take flux = \"edge-stabilised\"");
  if (is_broken || (parts.count() > 1 && asked.empty())) {
    o.flux = MlpgFlux::edge_stabilised;
    refuse_what_does_not_fit(c, cloud, o, true);
    return between_parts(c, cloud, conditions, material, report);
  }
  if (!material.is_isotropic() && parts.count() > 1)
    table.refuse(asked, "a material that conducts differently by direction is one part of several",
                 "leave it out, or take flux = \"edge-stabilised\"");
  if (!material.is_isotropic() && !cloud.points_on_walls) {
    const Table body = c.section("cloud");
    body.refuse(body.has("file") ? "file" : "at",
                "a material that conducts differently by direction needs points on the walls",
                body.has("file") ? "let the file describe points on the surface of the body" : "use at = \"walls\"");
  }
  if (const Anisotropy* anisotropy = material.anisotropy(0)) {
    if (anisotropy->cylinder && cloud.axisymmetric)
      c.section("cloud").refuse("axisymmetric", "the material is wound around a line of its own",
                                "give its factors along x, the radius, and y, the axis");
    o.anisotropy = *anisotropy;
    if (asked.empty()) o.flux = MlpgFlux::edge_stabilised;
  }
  // T^h of parameters has no kinks: the edge of a source comes out blurred over a spacing or so, and temperatures about
  // which the conductivity changes much are passed too far away.
  constexpr double steep = 1.5;
  const double steepest = o.flux == MlpgFlux::parameters ? steepest_conductivity(c, cloud, material) : 1;
  const bool has_kinks = (cloud.lattice && !c.root().has("time") && has_sources_inside(c)) || steepest > steep;
  if (table.keys().empty() && has_kinks) o.flux = MlpgFlux::edge_stabilised;
  // A point that holds its heat by itself melts by itself; the temperatures inside a cell hang together.
  if (!table.has("capacity") && material.capacity_depends_on_T() && o.subdomain == MlpgSubdomain::tiles)
    o.capacity = MlpgCapacity::one_point;
  refuse_what_does_not_fit(c, cloud, o);
  MlpgReport done;
  MlpgScheme scheme = mlpg_scheme(cloud, o, done, conditions.temperatures);
  report["pairs"] = static_cast<double>(done.faces.pairs);
  report["neighbours"] = done.neighbours;
  report["weight_residual"] = done.faces.residual;
  report["face_iterations"] = done.faces.iterations;
  report["face_moment_error"] = done.faces.moment_error;
  report["enlarged_supports"] = static_cast<double>(done.supports.enlarged);
  report["largest_support"] = done.supports.largest;
  if (o.flux == MlpgFlux::edge_stabilised) return nodal_discretisation(cloud, conditions, std::move(scheme.conduction));
  Stability stability = stability_of(table, cloud, o, *scheme.conduction, c.root().has("time"), report);
  if (!stability.unstable.empty() && !table.keys().empty())
    table.refuse("support", "the scheme is unstable: " + stability.unstable,
                 "take a smaller support (1.6 in three dimensions on lattices, 1.8 on other clouds; 2.3 in two), the "
                 "linear basis, or flux = \"edge-stabilised\"");
  if (!stability.unstable.empty()) {
    o.flux = MlpgFlux::edge_stabilised;
    Discretisation stable = nodal_discretisation(
        cloud, conditions, std::move(mlpg_scheme(cloud, o, done, conditions.temperatures).conduction));
    stable.notes.push_back("mlpg takes flux = \"edge-stabilised\": by parameters " + stability.unstable);
    return stable;
  }
  Discretisation discretisation = parameter_discretisation(cloud, conditions, std::move(scheme));
  if (steepest > steep)
    stability.notes.push_back(
        fmt::format("{}: the conductivity changes by a factor of {:.3g} within a tenth of the range of temperatures; "
                    "those of parameters have no kinks, and may err much there: take flux = \"edge-stabilised\"",
                    table.location("").text(), steepest));
  discretisation.notes = std::move(stability.notes);
  return discretisation;
}

void declare_mlpg(Schema& schema) {
  schema.add(
      {.path = "mlpg",
       .sentence = "Options of the meshless local Petrov-Galerkin method.",
       .keys = {
           {"basis", Kind::choice, "", "linear", "Polynomials of the moving least squares.", {"linear", "quadratic"}},
           {"support", Kind::number, "", optional,
            "Radius of the moving least squares' supports over spacing; default: 2.3 in one and two dimensions and for "
            "the quadratic basis, 1.6 in three on box lattices, 1.8 on other clouds. Enlarged where a place sees too "
            "few points."},
           {"neighbours", Kind::integer, "", optional,
            "Instead of the support: it reaches 1.1 times as far as the n-th nearest point."},
           {"weight",
            Kind::choice,
            "",
            "quartic",
            "Weight of the moving least squares: quartic spline, or Wendland's smoother C4 function, which wants a "
            "larger support.",
            {"quartic", "wendland"}},
           {"flux",
            Kind::choice,
            "",
            optional,
            "Unknowns and flux: \"parameters\" of the moving least squares (default in one and two dimensions for a "
            "body of one part, but for steady states with sources on lattices and conductivities that change by more "
            "than a factor of 1.5 within a tenth of the range of temperatures), or \"edge-stabilised\" from the "
            "temperatures of the points (default in three, and for "
            "layers, regions and cracks, which conduct in series; never seen unstable), or the latter \"averaged\" "
            "over "
            "a face and those beside it (on lattices of one part; default in three dimensions where there are no "
            "sources inside, in steady states and where the surface is heated by a flux).",
            {"parameters", "edge-stabilised", "averaged"}},
           {"capacity",
            Kind::choice,
            "",
            optional,
            "Heat of a cell: \"consistent\", integrated over it, or \"one-point\", from the temperature of its point "
            "(default on tiles where the heat capacity depends on temperature, and in three dimensions on irregular "
            "clouds).",
            {"consistent", "one-point"}},
           {"subdomain",
            Kind::choice,
            "",
            "tiles",
            "\"tiles\" fill the body and conserve heat; \"sphere\" are the papers' overlapping circles and spheres, "
            "for comparison.",
            {"tiles", "sphere"}},
           {"prescribed",
            Kind::choice,
            "",
            "collocation",
            "How parameters meet a prescribed temperature: \"collocation\" of T^h at the points on the wall, or a "
            "\"penalty\" in their heat balances, as in the papers.",
            {"collocation", "penalty"}},
           {"radius", Kind::number, "", "0.7", "Radius of the circles or spheres over spacing."},
       }});
}

}  // namespace

Method mlpg_method() {
  return {.name = "mlpg",
          .sentence = "the meshless local Petrov-Galerkin method",
          .declare = declare_mlpg,
          .support = support_of,
          .build = build};
}

}  // namespace calor
