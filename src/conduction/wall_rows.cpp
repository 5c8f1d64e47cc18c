#include "conduction/wall_rows.hpp"

#include <map>

namespace calor {

WallRows zeta_rows(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G) {
  WallRows walls;
  walls.row.push_back(0);
  for (auto facet = cloud.facets.begin(); facet != cloud.facets.end();) {
    const int i = facet->point;
    // One normal per face, then their sum: at an edge the rows of its faces are added.
    std::map<int, Vec3> area;
    for (; facet != cloud.facets.end() && facet->point == i; ++facet) area[facet->face] += facet->area * facet->normal;
    Vec3 normals;
    for (const auto& [face, a] : area) normals += (1 / norm(a)) * a;

    walls.point.push_back(i);
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      walls.column.push_back(j);
      walls.weight.push_back(G[n] / cloud.full_volume[i] * dot(cloud.x[j] - cloud.x[i], normals));
    }
    walls.row.push_back(static_cast<std::int64_t>(walls.column.size()));
  }
  return walls;
}

}  // namespace calor
