#include "surface/edges.hpp"

#include <algorithm>
#include <tuple>

namespace calor {

std::vector<Side> sides_by_edge(const Surface& surface) {
  std::vector<Side> sides;
  sides.reserve(surface.facets.size() * surface.dimension);
  for (std::size_t f = 0; f < surface.facets.size(); ++f) {
    const auto& vertex = surface.facets[f].vertex;
    for (int k = 0; k < surface.dimension; ++k) {
      const auto facet = static_cast<std::int32_t>(f);
      if (surface.dimension == 2) {
        sides.push_back({facet, k, {vertex[k], -1}, k == 0});
        continue;
      }
      const std::int32_t from = vertex[k], to = vertex[(k + 1) % 3];
      sides.push_back({facet, k, {std::min(from, to), std::max(from, to)}, from < to});
    }
  }
  std::ranges::sort(sides, {}, [](const Side& s) { return std::tuple(s.edge, s.facet, s.side); });
  return sides;
}

Vec3 middle(const Surface& surface, const Side& side) {
  const Vec3& a = surface.vertices[side.edge[0]];
  return surface.dimension == 2 ? a : 0.5 * (a + surface.vertices[side.edge[1]]);
}

double length(const Surface& surface, const Side& side) {
  if (surface.dimension == 2) return 0;
  return norm(surface.vertices[side.edge[1]] - surface.vertices[side.edge[0]]);
}

}  // namespace calor
