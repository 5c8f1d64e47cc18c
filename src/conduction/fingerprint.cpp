#include "conduction/fingerprint.hpp"

namespace calor {

Fingerprint fingerprint(const Cloud& cloud, const Neighbours& neighbours) {
  Fingerprint from;
  from.add(cloud.dimension).add(cloud.cross_section).add(cloud.axisymmetric).add(cloud.owned).add(cloud.count);
  from.add(cloud.lattice != nullptr).add(cloud.isotropic).add(cloud.nearest_volumes).add(cloud.points_on_walls);
  from.add(cloud.id).add(cloud.global).add(cloud.x).add(cloud.volume).add(cloud.metric).add(cloud.area);
  from.add(cloud.hoop).add(cloud.moment).add(cloud.on_faces).add(cloud.facets).add(cloud.walls);
  from.add(neighbours.row).add(neighbours.column).add(neighbours.image).add(neighbours.mirrors);
  from.add(neighbours.mirrored);
  return from;
}

}  // namespace calor
