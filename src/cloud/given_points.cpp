#include "cloud/given_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "base/csv.hpp"
#include "cloud/cells.hpp"
#include "cloud/spacings.hpp"
#include "surface/facet_queries.hpp"

namespace calor {
namespace {

/// Points on curved faces lie off the facets by less than this, in spacings.
constexpr double on_wall = 0.05;

SourceLocation location(const GivenPoints& given, std::size_t i) { return {.file = given.file, .line = given.line[i]}; }

/// The patches on which a place lies, within `distance`.
std::vector<BodyPoints::OnPatch> patches_at(const Body& body, const Vec3& x, double distance) {
  const Surface& surface = body.facets();
  const Vec3 around{distance, distance, surface.dimension == 3 ? distance : 0};
  std::vector<BodyPoints::OnPatch> on;
  for (const int f : body.facet_tree().facets_in(x - around, x + around)) {
    const auto& vertex = surface.facets[f].vertex;
    const Vec3 &a = surface.vertices[vertex[0]], &b = surface.vertices[vertex[1]];
    const Vec3 foot = surface.dimension == 2 ? closest_on_segment(a, b, x)
                                             : closest_on_triangle({a, b, surface.vertices[vertex[2]]}, x);
    const int patch = body.features().patch[f];
    if (norm(foot - x) < distance && std::ranges::find(on, patch, &BodyPoints::OnPatch::patch) == on.end())
      on.push_back({patch, body.features().normal[f]});
  }
  return on;
}

/// Every wall larger than a spacing holds points: conditions act there, and so does its area.
void require_points_on_walls(const Body& body, const BodyPoints& points, const GivenPoints& given) {
  const Surface& surface = body.surface();
  std::vector<char> holds(body.features().count);
  for (const auto& on : points.on)
    for (const auto& patch : on) holds[patch.patch] = 1;
  std::vector<double> area(body.features().count);
  for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f)
    area[body.features().patch[f]] += norm(surface.area(f));
  const SpacingField spacing = spacing_of_nearest(points);
  for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f) {
    const int patch = body.features().patch[f];
    const Vec3 x = surface.centroid(f);
    const double d = spacing.at(x);
    if (holds[patch] || area[patch] < (surface.dimension == 3 ? d * d : d)) continue;
    throw Error(Fault::bad_case, {.file = given.file},
                fmt::format("no point lies on the face '{}' around ({:.6g}, {:.6g}, {:.6g}) m",
                            surface.faces[surface.facets[f].face], x.x, x.y, x.z),
                "put points on all walls, edges and corners of the body");
  }
}

}  // namespace

GivenPoints read_given_points(const Table& cloud) {
  GivenPoints given{.file = cloud.file("points"), .x = {}, .line = {}, .least = 0};
  CsvReader csv(given.file, cloud.location("points"));
  const bool has_z = csv.find("z") >= 0;
  int column[3] = {csv.require("x", "m"), csv.require("y", "m"), has_z ? csv.require("z", "m") : -1};
  if (csv.columns().size() != (has_z ? 3 : 2))
    throw Error(Fault::bad_case, SourceLocation{.file = given.file, .line = 1},
                fmt::format("the file has {} columns", csv.columns().size()),
                "points of a body have x [m], y [m] and in space z [m]: it knows their volumes and areas itself; "
                "shape = \"csv\" reads clouds that bring theirs");
  while (csv.next()) {
    Vec3& x = given.x.emplace_back();
    for (int a = 0; a < (has_z ? 3 : 2); ++a) x[a] = csv.number(column[a]);
    given.line.push_back(csv.location().line);
  }
  const std::vector<double> apart = distances_to_nearest(given.x);
  const auto least = std::ranges::min_element(apart) - apart.begin();
  given.least = apart[least];
  if (!(given.least > 0))
    throw Error(Fault::bad_case, location(given, least), "there is no other point, or one at the same place",
                "give every point once");
  return given;
}

PlacedPoints place_given(const Body& body, const GivenPoints& given) {
  const int D = body.surface().dimension;
  const std::vector<double> apart = distances_to_nearest(given.x);
  std::vector<std::vector<BodyPoints::OnPatch>> on(given.x.size());
  std::vector<std::vector<Vec3>> normals(given.x.size());
  for (std::size_t i = 0; i < given.x.size(); ++i) {
    const Vec3& x = given.x[i];
    on[i] = patches_at(body, x, on_wall * apart[i]);
    for (const auto& patch : on[i])
      if (body.is_wall(patch.patch)) normals[i].push_back(patch.normal);
    if (!on[i].empty() || body.tree().is_inside(x)) continue;
    const auto wall = body.tree().closest(x, std::numeric_limits<double>::infinity());
    throw Error(Fault::bad_case, location(given, i),
                fmt::format("the point at ({:.6g}, {:.6g}, {:.6g}) m lies outside the body, {:.3g} m from its surface",
                            x.x, x.y, x.z, wall->distance),
                "move it, or leave it out; points on walls lie within a twentieth of their distance from them");
  }
  const std::vector<double> spacing = spacings_by_distances(D, given.x, normals);
  PlacedPoints out{.points = {PointGrid(bounds_of(given.x).low), {}, {}}, .id = {}};
  for (const bool on_surface : {true, false})
    for (std::size_t i = 0; i < given.x.size(); ++i) {
      if (on[i].empty() == on_surface) continue;
      out.points.grid.add(given.x[i], spacing[i]);
      if (on_surface) out.points.on.push_back(on[i]);
      out.id.push_back(static_cast<std::int64_t>(i));
    }
  out.points.is_lattice.assign(given.x.size(), 0);
  require_points_on_walls(body, out.points, given);
  return out;
}

SpacingField spacing_of_nearest(const BodyPoints& points) {
  return {.at =
              [&grid = points.grid](const Vec3& x) {
                std::pair<double, int> best{std::numeric_limits<double>::max(), 0};
                for (double reach = 1; best.first == std::numeric_limits<double>::max(); reach *= 2)
                  grid.for_each_within(x, reach, [&](int j, double square) { best = std::min(best, {square, j}); });
                return grid.spacing(best.second);
              },
          .is_uniform = false};
}

}  // namespace calor
