#include "cloud/mesh_groups.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

namespace calor {
namespace {

using Nodes = std::array<std::int32_t, 3>;  // of a facet; in the plane the last one is -1

/// A facet of a simplex, as the simplex sees it.
struct Side {
  Nodes sorted, outward;
  int tag;
};

/// Facets whose nodes run as those of a Surface.
std::vector<Side> sides_of(const Simplices& body, const std::vector<int>& tag_of_simplex) {
  std::vector<Side> sides;
  for (std::size_t t = 0; t < body.simplices.size(); ++t) {
    for (int opposite = 0; opposite <= body.dimension; ++opposite) {
      Nodes nodes = {-1, -1, -1};
      for (int k = 0, n = 0; k <= body.dimension; ++k)
        if (k != opposite) nodes[n++] = body.simplices[t].node[k];
      const Vec3& a = body.x[nodes[0]];
      const Vec3 inward = body.x[body.simplices[t].node[opposite]] - a, ab = body.x[nodes[1]] - a;
      const bool is_turned =
          body.dimension == 2 ? cross(ab, inward).z < 0 : dot(cross(ab, body.x[nodes[2]] - a), inward) > 0;
      if (is_turned) std::swap(nodes[0], nodes[1]);
      Side side{.sorted = nodes, .outward = nodes, .tag = tag_of_simplex[t]};
      std::ranges::sort(side.sorted);
      sides.push_back(side);
    }
  }
  std::ranges::stable_sort(sides, {}, &Side::sorted);
  return sides;
}

/// A surface of facets by the nodes of a mesh, with the vertices that it needs.
class SurfaceOfNodes {
 public:
  explicit SurfaceOfNodes(const Simplices& body) : body_(body) {
    surface_.dimension = body.dimension;
    surface_.faces = {"surface"};
  }

  void add(const Nodes& nodes) {
    Surface::Triangle facet;
    for (int k = 0; k < body_.dimension; ++k) {
      const auto next = static_cast<std::int32_t>(surface_.vertices.size());
      const auto [vertex, is_new] = vertex_of_.try_emplace(nodes[k], next);
      if (is_new) surface_.vertices.push_back(body_.x[nodes[k]]);
      facet.vertex[k] = vertex->second;
    }
    surface_.facets.push_back(facet);
  }
  Surface take() { return std::move(surface_); }

 private:
  const Simplices& body_;
  std::unordered_map<std::int32_t, std::int32_t> vertex_of_;
  Surface surface_;
};

}  // namespace

std::shared_ptr<const Solids> solids_of_groups(const Simplices& body, const std::vector<int>& tag_of_simplex) {
  const std::set<int> tags(tag_of_simplex.begin(), tag_of_simplex.end());
  if (tags.size() < 2) return nullptr;
  std::map<int, SurfaceOfNodes> surface_of;
  for (const int tag : tags) surface_of.emplace(tag, body);
  SurfaceOfNodes interfaces(body);
  const std::vector<Side> sides = sides_of(body, tag_of_simplex);
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].sorted == sides[begin].sorted) ++end;
    // Between two simplices of one group there is no surface.
    const bool is_interface = end - begin == 2 && sides[begin].tag != sides[begin + 1].tag;
    if (end - begin > 1 && !is_interface) continue;
    for (std::size_t n = begin; n < end; ++n) surface_of.at(sides[n].tag).add(sides[n].outward);
    if (is_interface) interfaces.add(sides[begin].outward);
  }
  std::vector<Surface> surfaces;
  for (auto& [tag, surface] : surface_of) surfaces.push_back(surface.take());
  return std::make_shared<const Solids>(std::move(surfaces), std::vector<int>(tags.begin(), tags.end()),
                                        interfaces.take());
}

}  // namespace calor
