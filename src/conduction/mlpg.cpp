#include "conduction/mlpg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/cracks.hpp"
#include "cloud/lattice.hpp"
#include "conduction/constraint.hpp"
#include "conduction/cracked_pairs.hpp"
#include "conduction/faces.hpp"
#include "conduction/mlpg_stability.hpp"
#include "conduction/quadrature.hpp"
#include "conduction/sph.hpp"

namespace calor {

namespace {

/// Adds v to the entry of column j in the open row.
void add_to(SparseRows& rows, std::int32_t j, double v) {
  for (std::size_t n = rows.row.back(); n < rows.column.size(); ++n)
    if (rows.column[n] == j) return void(rows.value[n] += v);
  rows.column.push_back(j);
  rows.value.push_back(v);
}

/// The slopes of place q, into the open row.
void add_slopes(const ShapeRows& shapes, std::size_t q, SparseRows& rows) {
  const auto columns = shapes.phi.columns(q);
  const auto begin = shapes.phi.row[q], end = shapes.phi.row[q + 1];
  rows.column.insert(rows.column.end(), columns.begin(), columns.end());
  rows.value.insert(rows.value.end(), shapes.slope.begin() + begin, shapes.slope.begin() + end);
}

QuadraturePoints places_of(const Cloud& cloud, const Faces& faces) {
  QuadraturePoints places{.x = faces.x, .tag = {}, .phi = {}};
  for (const int a : faces.a) places.tag.push_back(cloud.tag[a]);
  return places;
}

CellSamples samples_of(const CellQuadrature& cells) {
  CellSamples samples{.point = {}, .row = cells.cell, .x = cells.x, .weight = cells.volume};
  samples.point.resize(cells.cell.size() - 1);
  std::iota(samples.point.begin(), samples.point.end(), 0);
  return samples;
}

/// All heat of every subdomain at its point.
void gather_at_points(const Cloud& cloud, CellQuadrature& cells) {
  CellQuadrature gathered = one_point(cloud);
  for (int i = 0; i < cloud.owned; ++i) {
    gathered.volume[i] = 0;
    for (auto q = cells.cell[i]; q < cells.cell[i + 1]; ++q) gathered.volume[i] += cells.volume[q];
  }
  cells = std::move(gathered);
}

/// The walls of prescribed temperature, whose rows of shape functions begin at `first`.
PenaltyRows penalty_rows(const Cloud& cloud, const ShapeRows& shapes, std::size_t first,
                         std::span<const PrescribedTerm> temperatures) {
  constexpr double alpha = 1e5;  // in conductivity / spacing: walls are off by 1e-5 of what T changes over a spacing
  PenaltyRows walls;
  for (const PrescribedTerm& term : temperatures) {
    SparseRows& slope = walls.slope.emplace_back();
    std::vector<double>& stiffness = walls.stiffness.emplace_back();
    for (std::size_t n = 0; n < term.point.size(); ++n) {
      add_slopes(shapes, first++, slope);
      slope.close_row();
      stiffness.push_back(alpha * norm(quotient(term.area[n], cloud.metric[term.point[n]])));
    }
  }
  return walls;
}

MlpgScheme parameter_scheme(const Cloud& cloud, const MlpgOptions& o, Faces faces, std::optional<CellQuadrature> cells,
                            std::span<const PrescribedTerm> temperatures, MlpgReport& report) {
  std::vector<Vec3> places = faces.x, along = faces.area;
  if (o.prescribed == MlpgPrescribed::collocation) temperatures = {};
  if (!cloud.points_on_walls) temperatures = {};  // held by the layer before the wall
  for (const PrescribedTerm& term : temperatures) {
    places.insert(places.end(), term.x.begin(), term.x.end());
    along.insert(along.end(), term.area.begin(), term.area.end());
  }
  const std::size_t with_slope = places.size();
  if (cells) places.insert(places.end(), cells->x.begin(), cells->x.end());
  places.insert(places.end(), cloud.x.begin(), cloud.x.begin() + cloud.owned);
  const auto shapes = shape_rows(cloud, o.mls, o.support, places, along, report.supports);
  FaceRows rows{.flux = {}, .conduction = places_of(cloud, faces), .cells = std::move(cells), .value = {}};
  for (std::size_t q = 0; q < faces.size(); ++q) {
    add_slopes(shapes, q, rows.flux);
    rows.flux.close_row();
  }
  MlpgScheme scheme{.conduction = nullptr, .shapes = {o.mls, o.support, report.supports.R}};
  if (o.prescribed == MlpgPrescribed::penalty && cloud.points_on_walls)
    scheme.walls =
        std::make_unique<PenaltyWalls>(penalty_rows(cloud, shapes, faces.size(), temperatures), temperatures);
  const std::size_t in_cells = rows.cells ? rows.cells->x.size() : 0;
  rows.conduction.phi = shapes.phi.part(0, faces.size());
  if (rows.cells) rows.cells->phi = shapes.phi.part(with_slope, in_cells);
  rows.value = shapes.phi.part(with_slope + in_cells, cloud.owned);
  scheme.conduction = std::make_unique<FaceConduction>(cloud, std::move(faces), std::move(rows), false);
  return scheme;
}

/// k a.[g + v (T_j - T_i - g.x_ji)], g = sum_J grad phi_J T_J and v = x_ji / r^2 as the metric has it, so that v.x_ji =
/// 1: in spacings, the line between two flat points is as good a guide to the flux as that between cubes. Across a face
/// of a lattice, a parallel to x_ji, g drops out and two points remain.
MlpgScheme nodal_scheme(const Cloud& cloud, const MlpgOptions& o, Faces faces, MlpgReport& report) {
  std::vector<double> along(faces.size());  // the lines i-j
  std::vector<Vec3> across(faces.size());
  for (std::size_t q = 0; q < faces.size(); ++q) {
    const Vec3 r = cloud.x[faces.b[q]] - cloud.x[faces.a[q]];
    const Vec3 s = cloud.mean_metric(faces.a[q], faces.b[q]), xi = quotient(r, s);
    along[q] = dot(faces.area[q], quotient(xi, s)) / dot(xi, xi);
    across[q] = faces.area[q] - along[q] * r;
  }
  ShapeRows shapes;
  if (!cloud.lattice) shapes = shape_rows(cloud, o.mls, o.support, faces.x, across, report.supports);
  FaceRows rows;
  rows.flux.column.reserve(shapes.phi.column.size() + 2 * faces.size());
  rows.flux.value.reserve(shapes.phi.column.size() + 2 * faces.size());
  for (std::size_t q = 0; q < faces.size(); ++q) {
    if (!cloud.lattice) add_slopes(shapes, q, rows.flux);
    add_to(rows.flux, faces.a[q], -along[q]);
    add_to(rows.flux, faces.b[q], along[q]);
    rows.flux.close_row();
  }
  return {.conduction = std::make_unique<FaceConduction>(cloud, std::move(faces), std::move(rows), true)};
}

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

void refuse_what_does_not_fit(const Case& c, const Cloud& cloud, const MlpgOptions& o) {
  const Table body = c.section("cloud");
  if (!cloud.points_on_walls && !cloud.walls.empty())
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

/// An unjittered lattice of one spacing along every axis.
bool is_regular(const Cloud& cloud) { return cloud.lattice && !cloud.lattice->graded(); }

/// Refuses schemes whose waves grow; returns a note where circles bias the diffusivity.
std::vector<std::string> check_stability(const Table& table, const Cloud& cloud, const MlpgOptions& o,
                                         const FaceConduction& conduction, bool transient, MethodReport& report) {
  const bool spheres = o.subdomain == MlpgSubdomain::sphere;
  constexpr const char* cure =
      "take a smaller support (1.6 in three dimensions on lattices, 1.8 on other clouds; 2.3 in two), the linear "
      "basis, "
      "or flux = \"edge-stabilised\"";
  if (is_regular(cloud) && o.support.neighbours == 0) {
    const bool one_point = o.capacity == MlpgCapacity::one_point;
    const auto cell =
        spheres ? lattice_sphere(cloud.dimension, o.radius, one_point) : lattice_box(cloud.dimension, one_point);
    const auto symbols = lattice_symbols(o.mls, o.support.spacings, cell, stretched_conductivity(*cloud.lattice));
    report["least_capacity_symbol"] = symbols.least_capacity;
    report["least_rate_symbol"] = symbols.least_rate;
    report["kappa"] = symbols.kappa;
    if (transient && !symbols.stable())
      table.refuse("support",
                   fmt::format("the scheme is unstable: inside the lattice, waves have a heat capacity down to {:.2g} "
                               "of the cell's and rates of decay down to {:.3g} diffusivity / spacing^2",
                               symbols.least_capacity, symbols.least_rate),
                   cure);
    if (!spheres || std::abs(symbols.kappa - 1) <= 1e-3) return {};
    return {fmt::format(
        "{}: circles of radius {:g} with support {:g} conduct as if the diffusivity were {:.4f} of what it is, however "
        "fine the cloud; subdomain = \"tiles\" has no such error",
        table.location("subdomain").text(), o.radius, o.support.spacings, symbols.kappa)};
  }
  const bool always_stable =
      o.mls.degree == 1 && cloud.dimension < 3 && o.support.neighbours == 0 && o.support.spacings <= 2.8 && !spheres;
  if (!transient || always_stable) return {};
  const double growth = start_up_growth(cloud, conduction);
  report["start_up_growth"] = growth;
  if (growth > 1.02)
    table.refuse("support",
                 std::isinf(growth)
                     ? "the scheme is unstable: random temperatures blow up within 60 steps of a tenth of spacing^2 / "
                       "diffusivity"
                     : fmt::format("the scheme is unstable: random temperatures grow by a factor of {:.3g} in 20 steps "
                                   "of a tenth of spacing^2 / diffusivity",
                                   growth),
                 cure);
  return {};
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
Discretisation between_parts(const Case& c, const Cloud& cloud, const Conditions& conditions, const Parts& parts,
                             MethodReport& report) {
  constexpr double smoothing = 1.2;
  const bool tiles = cloud.lattice && !has_cracks(c);
  const LineForce neighbours_alone = [](std::int64_t /*steps*/, double /*distance*/, double /*spacing*/) {
    return 1.0;
  };
  MirroredNeighbours pairs{find_neighbours(cloud, tiles ? 1.1 : sph_support(smoothing))};
  count_pairs(cloud, pairs.neighbours, report);
  CorrectionReport done;
  std::optional<Cloud> copy;
  auto G = tiles ? lattice_line_weights(cloud, pairs.neighbours, neighbours_alone, done)
                 : sph_consistent_weights(without_cracks(cloud, copy), pairs.neighbours, smoothing, done);
  auto discretisation =
      with_cracks(c, cloud, parts, conditions, std::move(pairs), std::move(G), Layers::odd, done, report);
  add_to_report(done, report);
  return discretisation;
}

Discretisation build(const Case& c, const Cloud& cloud, const Conditions& conditions, const MaterialField& material,
                     MethodReport& report) {
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
    refuse_what_does_not_fit(c, cloud, o);
    return between_parts(c, cloud, conditions, parts, report);
  }
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
  auto notes = check_stability(table, cloud, o, *scheme.conduction, c.root().has("time"), report);
  Discretisation discretisation = parameter_discretisation(cloud, conditions, std::move(scheme));
  discretisation.notes = std::move(notes);
  return discretisation;
}

}  // namespace

MlpgOptions MlpgOptions::defaults(int dimension, bool regular, int degree) {
  MlpgOptions o;
  o.mls.dimension = dimension;
  o.mls.degree = degree;
  o.support.spacings = dimension < 3 || degree == 2 ? 2.3 : regular ? 1.6 : 1.8;
  o.flux = dimension < 3 ? MlpgFlux::parameters : MlpgFlux::edge_stabilised;
  if (dimension == 3 && !regular) o.capacity = MlpgCapacity::one_point;
  if (!regular) o.support.least = degree == 2 ? o.mls.terms() + 4 : dimension == 1 ? 3 : dimension == 2 ? 7 : 9;
  return o;
}

double mlpg_support(const MlpgOptions& options) {
  // From an owned point half a pair to a face, from there a support; where the spacing grows, that of farther points.
  return std::max(virtual_face_support(), 2 * options.support.limit());
}

MlpgScheme mlpg_scheme(const Cloud& cloud, const MlpgOptions& options, MlpgReport& report,
                       std::span<const PrescribedTerm> temperatures) {
  report = {};
  const bool values = options.flux == MlpgFlux::edge_stabilised;
  const auto build_scheme = [&] {
    if (options.subdomain == MlpgSubdomain::sphere) {
      Subdomains spheres = sphere_subdomains(cloud, options.radius);
      auto subdomains = std::make_unique<CellSamples>(samples_of(spheres.cells));
      if (options.capacity == MlpgCapacity::one_point) gather_at_points(cloud, spheres.cells);
      MlpgScheme scheme =
          parameter_scheme(cloud, options, std::move(spheres.faces), std::move(spheres.cells), temperatures, report);
      scheme.subdomains = std::move(subdomains);
      return scheme;
    }
    Faces faces = cloud.lattice ? lattice_faces(cloud, values ? 1 : 2) : virtual_faces(cloud, report.faces);
    if (values) return nodal_scheme(cloud, options, std::move(faces), report);
    std::optional<CellQuadrature> cells;
    if (options.capacity == MlpgCapacity::consistent) cells = gauss_points(cloud);
    return parameter_scheme(cloud, options, std::move(faces), std::move(cells), temperatures, report);
  };
  MlpgScheme scheme = build_scheme();
  const SparseRows& flux = scheme.conduction->rows().flux;
  const auto rows = total(cloud.comm, static_cast<std::int64_t>(flux.count()));
  const auto entries = total(cloud.comm, static_cast<std::int64_t>(flux.column.size()));
  report.neighbours = static_cast<double>(entries) / static_cast<double>(std::max<std::int64_t>(1, rows));
  return scheme;
}

namespace {

void declare_mlpg(Schema& schema) {
  schema.add(
      {.path = "mlpg",
       .sentence = "Options of the meshless local Petrov-Galerkin method.",
       .keys = {
           {"basis", Kind::choice, "", "linear", "Polynomials of the moving least squares.", {"linear", "quadratic"}},
           {"support", Kind::number, "", optional,
            "Radius of the moving least squares' supports over spacing; default: 2.3 in one and two dimensions and for "
            "the quadratic basis, 1.6 in three on box lattices, 1.8 on other clouds. Enlarged where a place sees too "
            "few "
            "points."},
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
            "body "
            "of one part), or \"edge-stabilised\" from the temperatures of the points (default in three, and for "
            "layers, "
            "regions and cracks, which conduct in series; never seen unstable).",
            {"parameters", "edge-stabilised"}},
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
            "for "
            "comparison.",
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
