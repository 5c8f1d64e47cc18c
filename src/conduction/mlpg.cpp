#include "conduction/mlpg.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "conduction/faces.hpp"
#include "conduction/quadrature.hpp"

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

/// R a: across a face of area a flows k R a . grad T.
std::vector<Vec3> conormals(const MlpgOptions& o, std::span<const Vec3> x, std::span<const Vec3> area) {
  std::vector<Vec3> out(area.begin(), area.end());
  for (std::size_t q = 0; o.anisotropy && q < out.size(); ++q) out[q] = o.anisotropy->at(x[q]) * area[q];
  return out;
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
PenaltyRows penalty_rows(const Cloud& cloud, const MlpgOptions& o, const ShapeRows& shapes, std::size_t first,
                         std::span<const PrescribedTerm> temperatures) {
  constexpr double alpha = 1e5;  // in conductivity / spacing: walls are off by 1e-5 of what T changes over a spacing
  PenaltyRows walls;
  for (const PrescribedTerm& term : temperatures) {
    SparseRows& slope = walls.slope.emplace_back();
    std::vector<double>& stiffness = walls.stiffness.emplace_back();
    const std::vector<Vec3> area = conormals(o, term.x, term.area);
    for (std::size_t n = 0; n < term.point.size(); ++n) {
      add_slopes(shapes, first++, slope);
      slope.close_row();
      stiffness.push_back(alpha * norm(quotient(area[n], cloud.metric[term.point[n]])));
    }
  }
  return walls;
}

MlpgScheme parameter_scheme(const Cloud& cloud, const MlpgOptions& o, Faces faces, std::optional<CellQuadrature> cells,
                            std::span<const PrescribedTerm> temperatures, MlpgReport& report) {
  std::vector<Vec3> places = faces.x, along = conormals(o, faces.x, faces.area);
  if (o.prescribed == MlpgPrescribed::collocation) temperatures = {};
  if (!cloud.points_on_walls) temperatures = {};  // held by the layer before the wall
  for (const PrescribedTerm& term : temperatures) {
    places.insert(places.end(), term.x.begin(), term.x.end());
    const std::vector<Vec3> at_wall = conormals(o, term.x, term.area);
    along.insert(along.end(), at_wall.begin(), at_wall.end());
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
        std::make_unique<PenaltyWalls>(penalty_rows(cloud, o, shapes, faces.size(), temperatures), temperatures);
  const std::size_t in_cells = rows.cells ? rows.cells->x.size() : 0;
  rows.conduction.phi = shapes.phi.part(0, faces.size());
  if (rows.cells) rows.cells->phi = shapes.phi.part(with_slope, in_cells);
  rows.value = shapes.phi.part(with_slope + in_cells, cloud.owned);
  scheme.conduction = std::make_unique<FaceConduction>(cloud, std::move(faces), std::move(rows), false);
  return scheme;
}

/// k [R a.g + max(0, R a.v) (T_j - T_i - g.x_ji)], g = sum_J grad phi_J T_J and v = x_ji / r^2 as the metric has it, so
/// that v.x_ji = 1: in spacings, the line between two flat points is as good a guide to the flux as that between cubes.
/// Across a face of a lattice, R a parallel to x_ji, g drops out and two points remain. R a may point far from x_ji,
/// even away from it: the difference along the line then must not count the wrong way round.
MlpgScheme nodal_scheme(const Cloud& cloud, const MlpgOptions& o, Faces faces, MlpgReport& report) {
  std::vector<double> along(faces.size());  // the lines i-j
  std::vector<Vec3> across = conormals(o, faces.x, faces.area);
  for (std::size_t q = 0; q < faces.size(); ++q) {
    const Vec3 r = cloud.x[faces.b[q]] - cloud.x[faces.a[q]];
    const Vec3 s = cloud.mean_metric(faces.a[q], faces.b[q]), xi = quotient(r, s);
    along[q] = dot(across[q], quotient(xi, s)) / dot(xi, xi);
    if (o.anisotropy) along[q] = std::max(0.0, along[q]);
    across[q] -= along[q] * r;
  }
  const bool two_points = cloud.lattice && (!o.anisotropy || o.anisotropy->is_diagonal());
  ShapeRows shapes;
  if (!two_points) shapes = shape_rows(cloud, o.mls, o.support, faces.x, across, report.supports);
  FaceRows rows;
  rows.flux.column.reserve(shapes.phi.column.size() + 2 * faces.size());
  rows.flux.value.reserve(shapes.phi.column.size() + 2 * faces.size());
  for (std::size_t q = 0; q < faces.size(); ++q) {
    if (!two_points) add_slopes(shapes, q, rows.flux);
    add_to(rows.flux, faces.a[q], -along[q]);
    add_to(rows.flux, faces.b[q], along[q]);
    rows.flux.close_row();
  }
  return {.conduction = std::make_unique<FaceConduction>(cloud, std::move(faces), std::move(rows), true)};
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

}  // namespace calor
