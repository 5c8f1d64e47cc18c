// Clouds of points that somebody else made: where their walls are, and what that says of the spacing.
#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/cells.hpp"
#include "cloud/points.hpp"
#include "cloud/search.hpp"

namespace calor {
namespace {

/// How far around a point its next ones are looked for, in spacings.
constexpr double reach = 1.6;

/// Do all pieces of surface of the point face one way?
bool faces_one_way(std::span<const Facet> facets) {
  return std::ranges::all_of(facets, [&](const Facet& f) { return dot(f.normal, facets.front().normal) > 0.9; });
}

/// Calls use(i, facets of i, local points around it) for the owned points that have a piece of the surface.
template <class Use>
void for_each_surface_point(const Cloud& cloud, const Use& use) {
  const Search search(cloud, {std::min(reach, cloud.halo_support.over_spacing), 0});
  std::vector<std::int32_t> buffer, around;
  for (std::size_t n = 0; n < cloud.facets.size();) {
    const int i = cloud.facets[n].point;
    std::size_t end = n;
    while (end < cloud.facets.size() && cloud.facets[end].point == i) ++end;
    int coincident = 0;
    around.clear();
    for (const std::int32_t position : search.find(cloud.x[i], cloud.metric[i], buffer, coincident))
      if (const std::int32_t j = search.local(position); j != i) around.push_back(j);
    use(i, std::span(cloud.facets).subspan(n, end - n), std::span<const std::int32_t>(around));
    n = end;
  }
}

/// Distance to the next layer of points behind the wall at point i; 0 where there is none.
double to_next_layer(const Cloud& cloud, int i, const Vec3& normal, std::span<const std::int32_t> around) {
  constexpr double cone = 0.7;  // cosine
  double nearest = 0, depth = 0;
  for (const std::int32_t j : around) {
    const Vec3 r = cloud.x[j] - cloud.x[i];
    const double length = norm(r), inwards = -dot(r, normal);
    if (inwards < cone * length || (nearest > 0 && length >= nearest)) continue;
    nearest = length, depth = inwards;
  }
  return depth;
}

/// Do the points lie on the walls? There a cell reaches from the wall half way to the next layer; off the walls, a
/// whole layer. And sum x.A over the surface is D times the volume on the walls; off them it lacks half of V_i a piece.
/// The first tells more where volumes are wrong, the second where points lie in disorder.
bool points_lie_on_walls(const Cloud& cloud) {
  Bounds box = bounds_of(cloud.owned_points());
  for (int a = 0; a < 3; ++a) box.low[a] = min(cloud.comm, box.low[a]), box.high[a] = max(cloud.comm, box.high[a]);
  const Vec3 middle = 0.5 * (box.low + box.high);
  constexpr int columns = 4;  // V and A times the depth of plain points; V; V_i / 2 of pieces, and x.A in their rows
  std::vector<double> rows;
  for (const double volume : cloud.volume) {
    if (rows.size() == columns * static_cast<std::size_t>(cloud.owned)) break;
    rows.insert(rows.end(), {0, 0, cloud.dimension * volume, 0});
  }
  for_each_surface_point(cloud, [&](int i, std::span<const Facet> facets, std::span<const std::int32_t> around) {
    double* row = rows.data() + columns * static_cast<std::size_t>(i);
    row[2] -= dot(cloud.x[i] - middle, cloud.area[i]);
    row[3] = 0.5 * cloud.volume[i] * static_cast<double>(facets.size());
    if (!faces_one_way(facets)) return;
    const double depth = to_next_layer(cloud, i, facets.front().normal, around);
    if (depth > 0) row[0] = cloud.volume[i], row[1] = norm(cloud.area[i]) * depth;
  });
  const std::vector<double> s = sums(cloud.comm, rows, columns);
  const double by_surface = s[3] > 0 ? std::clamp(s[2] / s[3], 0.0, 1.0) : 0;
  const double by_layers = s[1] > 0 ? std::clamp(2 * s[0] / s[1] - 1, 0.0, 1.0) : by_surface;
  return (2 * by_layers + by_surface) / 3 < 0.5;
}

/// Does the surface enclose far less than the volumes?
bool lacks_pieces(const Cloud& cloud) {
  std::vector<double> rows(2 * static_cast<std::size_t>(cloud.owned));
  const Vec3 origin = cloud.x.empty() ? Vec3{} : cloud.x.front();
  const Vec3 shift = gather(cloud.comm, std::vector<Vec3>{origin}).front();
  for (int i = 0; i < cloud.owned; ++i) rows[2 * i] = cloud.dimension * cloud.volume[i];
  for (const Facet& facet : cloud.facets)
    rows[2 * facet.point + 1] +=
        facet.area * (dot(cloud.x[facet.point] - shift, facet.normal) + wall_distance(cloud, facet));
  const std::vector<double> s = sums(cloud.comm, rows, 2);
  return s[1] > 0 && s[1] < 0.9 * s[0];
}

/// The area vector that the surface of point i lacks: that of the neighbours on one side alone, by weights whose second
/// moment is that of the point's volume, less what is along the normals of the pieces that it has.
Vec3 lacking_area(const Cloud& cloud, int i, std::span<const Facet> pieces, std::span<const std::int32_t> around) {
  double moment = 0;
  Vec3 sum;
  for (const std::int32_t j : around) {
    const Vec3 r = cloud.x[j] - cloud.x[i];
    const double u = norm(r) / (reach * 0.5 * (cloud.spacing[i] + cloud.spacing[j]));
    const double weight = std::pow(std::max(0.0, 1 - u * u), 2);
    moment += weight * dot(r, r);
    sum += weight * r;
  }
  if (moment == 0) return {};
  Vec3 area = (-2 * cloud.dimension * cloud.volume[i] / moment) * sum;
  for (const Facet& piece : pieces) area += -dot(area, piece.normal) * piece.normal;
  constexpr double as_in_disorder = 0.4;  // of a side of the cell
  return norm(area) > as_in_disorder * cloud.volume[i] / cloud.spacing[i] ? area : Vec3{};
}

/// Walls that no piece of surface describes become pieces of a face of their own, which nothing heats: without them no
/// heat would run along their normals. Collective.
void close_surface(Cloud& cloud) {
  if (cloud.faces.size() == 32) return;
  const auto face = static_cast<int>(cloud.faces.size());
  const Search search(cloud, {std::min(reach, cloud.halo_support.over_spacing), 0});
  std::vector<std::int32_t> buffer, around;
  std::vector<Facet> all;
  auto next = cloud.facets.begin();
  for (int i = 0; i < cloud.owned; ++i) {
    const auto begin = next;
    while (next != cloud.facets.end() && next->point == i) ++next;
    int coincident = 0;
    around.clear();
    for (const std::int32_t position : search.find(cloud.x[i], cloud.metric[i], buffer, coincident))
      if (const std::int32_t j = search.local(position); j != i) around.push_back(j);
    all.insert(all.end(), begin, next);
    const Vec3 area = lacking_area(cloud, i, {begin, next}, around);
    if (area == Vec3{}) continue;
    all.push_back({.point = i, .face = face, .area = norm(area), .normal = (1 / norm(area)) * area});
    cloud.area[i] += area;
    cloud.on_faces[i] |= std::uint32_t{1} << face;
  }
  cloud.facets = std::move(all);
  cloud.faces.emplace_back(undescribed_face);
  cloud.halo.update(std::span<Vec3>(cloud.area));
  std::vector<double> on_faces(cloud.on_faces.begin(), cloud.on_faces.end());
  cloud.halo.update(std::span<double>(on_faces));
  for (int j = cloud.owned; j < cloud.local(); ++j) cloud.on_faces[j] = static_cast<std::uint32_t>(on_faces[j]);
}

}  // namespace

void settle_walls(Cloud& cloud) {
  cloud.points_on_walls = points_lie_on_walls(cloud);
  if (!cloud.points_on_walls) {  // their cells are full
    for (const Facet& facet : cloud.facets) {
      const int i = facet.point;
      cloud.full_volume[i] = cloud.volume[i];
      const double d = cloud.spacing[i] = std::pow(cloud.volume[i] / cloud.cross_section, 1.0 / cloud.dimension);
      cloud.metric[i] = {d, d, d};
    }
    cloud.halo.update(std::span<double>(cloud.spacing));
    cloud.halo.update(std::span<Vec3>(cloud.metric));
  }
  if (lacks_pieces(cloud)) close_surface(cloud);
}

}  // namespace calor
