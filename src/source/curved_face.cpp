#include "source/curved_face.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"

namespace calor {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Of the facets of a point on a face: the mean of where they are and of where they look.
Foot mean_of_facets(const Cloud& cloud, int face, int point, const Vec3& place) {
  Foot mean;
  Vec3 towards;  // the place, of the two sides of a plate that is one point thick
  double area = 0;
  for (const Facet& facet : cloud.facets) {
    if (facet.face != face || facet.point != point) continue;
    mean.x += facet.area * place_on_wall(cloud, facet);
    mean.normal += facet.area * facet.normal;
    area += facet.area;
    if (norm(towards) == 0 || dot(facet.normal - towards, place - cloud.x[point]) > 0) towards = facet.normal;
  }
  mean.x *= 1 / area;
  const double length = norm(mean.normal);
  mean.normal = length > 1e-6 * area ? 1 / length * mean.normal : towards;
  return mean;
}

}  // namespace

Foot foot_on_face(const Cloud& cloud, int face, const Vec3& place) {
  double nearest = infinity, id = infinity;
  int point = -1;
  for (const Facet& facet : cloud.facets) {
    if (facet.face != face) continue;
    const double distance = norm(place_on_wall(cloud, facet) - place);
    if (distance > nearest || (distance == nearest && cloud.id[facet.point] > id)) continue;
    nearest = distance, id = static_cast<double>(cloud.id[facet.point]), point = facet.point;
  }
  const double least = min(cloud.comm, nearest);
  const double first = min(cloud.comm, nearest == least ? id : infinity);
  Foot foot;
  if (nearest == least && id == first && point >= 0) foot = mean_of_facets(cloud, face, point, place);
  const std::vector<double> all =
      sums(cloud.comm, std::vector{foot.x.x, foot.x.y, foot.x.z, foot.normal.x, foot.normal.y, foot.normal.z}, 6);
  const Vec3 on_face{all[0], all[1], all[2]}, normal{all[3], all[4], all[5]};
  return {.x = place - dot(place - on_face, normal) * normal, .normal = normal};
}

}  // namespace calor
