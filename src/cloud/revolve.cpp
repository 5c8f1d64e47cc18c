// From a plane cloud of thickness 1 to the body that it makes when it is revolved about the y axis.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cell_moments.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/lattice.hpp"
#include "cloud/points.hpp"
#include "surface/body.hpp"

namespace calor {
namespace {

constexpr double turn = 2 * std::numbers::pi;

/// A piece of surface in the plane: the integral of x n over it, and its length times the mean of x.
struct Revolved {
  Vec3 vector;
  double area = 0;
};

/// Of a lattice: a piece of the wall of a cell.
Revolved revolved_side(const Cloud& cloud, const Facet& facet) {
  const auto [low, high] = cloud.lattice->cell(0, cloud.lattice->index(cloud.id[facet.point])[0]);
  const double x = facet.face / 2 == 0 ? cloud.walls[facet.face] : 0.5 * (low + high);
  return {x * facet.area * facet.normal, x * facet.area};
}

/// Elsewhere the piece is the part that the point has by linear functions between it and its neighbours on the wall: so
/// sum A and sum x cross A are those of the polygon through the points. The centroid of such a part lies at 2/3 of the
/// way half to the neighbour.
Revolved revolved_piece(const Cloud& cloud, const CellSampler& sampler, int n) {
  const Facet& facet = cloud.facets[n];
  const Vec3 &x = cloud.x[facet.point], A = facet.area * facet.normal;
  const auto ends = sampler.ends_of_facet(n);
  Revolved out{x.x * A, x.x * facet.area};
  for (const Vec3& end : {ends[0], ends[2]}) {
    const Vec3 way = end - x;
    Vec3 normal{way.y, -way.x, 0};
    if (dot(normal, facet.normal) < 0) normal = -normal;
    out.vector += 2. / 3 * way.x * normal;
    out.area += 2. / 3 * way.x * norm(way);
  }
  return out;
}

/// Surface and area vectors of the owned points; what lies on the axis is no surface.
void revolve_surface(Cloud& cloud) {
  constexpr double nothing = 1e-9;  // of the area that a spacing from the axis would have
  std::vector<Facet> kept;
  std::vector<Vec3> area(cloud.local());
  std::vector<double> on_faces(cloud.local());
  std::vector<std::uint32_t> faces(cloud.owned, 0);
  {
    const CellSampler sampler(cloud);
    for (std::size_t n = 0; n < cloud.facets.size(); ++n) {
      const Facet& facet = cloud.facets[n];
      const Revolved plane =
          cloud.lattice ? revolved_side(cloud, facet) : revolved_piece(cloud, sampler, static_cast<int>(n));
      if (!(plane.area > nothing * facet.area * cloud.spacing[facet.point])) continue;
      const double length = norm(plane.vector);
      area[facet.point] += turn * plane.vector;
      faces[facet.point] |= std::uint32_t{1} << facet.face;
      kept.push_back(
          {.point = facet.point, .face = facet.face, .area = turn * length, .normal = (1 / length) * plane.vector});
    }
  }
  cloud.facets = std::move(kept);
  std::ranges::copy(faces, on_faces.begin());
  cloud.halo.update(std::span<double>(on_faces));
  cloud.halo.update(std::span<Vec3>(area));
  for (int i = 0; i < cloud.local(); ++i) cloud.on_faces[i] = static_cast<std::uint32_t>(on_faces[i]);
  cloud.area = std::move(area);
}

/// sum (A - S e_x) = 0 and sum x cross (A - S e_x) = 0 are what makes it possible that pairs balance them. Volumes that
/// are no integrals of linear functions miss the second one a little: S changes linearly along the axis to meet both.
/// Collective.
void close(Cloud& cloud) {
  constexpr int columns = 5;  // S, S y, S y^2, A_x, (x cross A)_z
  std::vector<double> rows;
  rows.reserve(columns * static_cast<std::size_t>(cloud.owned));
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 &x = cloud.x[i], &A = cloud.area[i];
    const double S = cloud.hoop[i];
    rows.insert(rows.end(), {S, S * x.y, S * x.y * x.y, A.x, x.x * A.y - x.y * A.x});
  }
  const auto s = sums(cloud.comm, rows, columns);
  const double middle = s[1] / s[0], spread = s[2] - middle * s[1];
  const double shift = (s[3] - s[0]) / s[0], slope = -(s[4] + middle * s[3]) / spread;
  // A surface that is open stays so, and is refused later.
  constexpr double largest = 0.01;
  if (!(std::abs(shift) < largest && std::abs(slope) * std::sqrt(spread / s[0]) < largest)) return;
  for (int i = 0; i < cloud.owned; ++i) cloud.hoop[i] *= 1 + shift + slope * (cloud.x[i].y - middle);
}

/// Integral of x over a body in the plane, by Gauss's theorem those of x^2 / 2 n_x and y^2 / 2 n_y over its outline.
Vec3 moment_of(const Surface& outline) {
  Vec3 sum;
  for (int f = 0; f < static_cast<int>(outline.facets.size()); ++f) {
    const auto& vertex = outline.facets[f].vertex;
    const Vec3 &a = outline.vertices[vertex[0]], &b = outline.vertices[vertex[1]];
    sum += 1. / 6 * product(outline.area(f), product(a, a) + product(a, b) + product(b, b));
  }
  return sum;
}

/// The moments of the cells about their points, in the plane, are known by samples. Changes them in proportion such
/// that the cells have the moment of the whole body together. Collective.
void meet(Cloud& cloud, const Vec3& whole) {
  constexpr int columns = 4;
  std::vector<double> rows;
  rows.reserve(columns * static_cast<std::size_t>(cloud.owned));
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 &m = cloud.moment[i], all = cloud.volume[i] * cloud.x[i] + m;
    rows.insert(rows.end(), {all.x, std::abs(m.x), all.y, std::abs(m.y)});
  }
  const auto s = sums(cloud.comm, rows, columns);
  for (const int axis : {0, 1}) {
    const double surplus = s[2 * axis] - whole[axis], size = s[2 * axis + 1];
    if (!(std::abs(surplus) < 0.5 * size)) continue;  // too few points to tell
    for (int i = 0; i < cloud.owned; ++i) cloud.moment[i][axis] -= surplus / size * std::abs(cloud.moment[i][axis]);
  }
}

/// Of the rectangle that a generator has filled.
double mean_distance(const Cloud& cloud) {
  if (!cloud.walls.empty()) return 0.5 * (cloud.walls[0] + cloud.walls[1]);
  const Bounds box = bounds_of(cloud.owned_points());
  return 0.5 * (min(cloud.comm, box.low.x) + max(cloud.comm, box.high.x));
}

}  // namespace

void revolve(Cloud& cloud, bool volumes_of_cells) {
  cloud.hoop.resize(cloud.local());
  cloud.moment.resize(cloud.local());
  for_each_cell(cloud, [&](int i, const CellMoments& cell) {
    const bool is_inside = !volumes_of_cells && cloud.on_faces[i] == 0;
    cloud.moment[i] = is_inside ? Vec3{} : cloud.volume[i] * (cell.centroid - cloud.x[i]);
  });
  if (cloud.body) meet(cloud, moment_of(cloud.body->surface()));
  for (int i = 0; i < cloud.owned; ++i) {
    const double thickness = turn * (cloud.x[i].x + cloud.moment[i].x / cloud.volume[i]);
    cloud.hoop[i] = turn * cloud.volume[i];
    cloud.moment[i] *= turn;
    cloud.volume[i] *= thickness;
    cloud.full_volume[i] *= thickness;
  }
  revolve_surface(cloud);
  if (!cloud.lattice) close(cloud);
  cloud.exact.volume =
      turn * (cloud.body ? moment_of(cloud.body->surface()).x : cloud.exact.volume * mean_distance(cloud));
  cloud.cross_section = turn;
  cloud.axisymmetric = true;
  cloud.box_lattice = false;
  for (auto* values : {&cloud.volume, &cloud.full_volume, &cloud.hoop}) cloud.halo.update(std::span<double>(*values));
}

}  // namespace calor
