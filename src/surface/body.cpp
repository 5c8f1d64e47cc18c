#include "surface/body.hpp"

#include <algorithm>
#include <utility>

namespace calor {

namespace {

Surface first_facets(Surface surface, int count) {
  surface.facets.resize(count);
  return surface;
}

}  // namespace

Body::Body(Surface surface) : Body(Assembly{surface, static_cast<int>(surface.facets.size())}) {}

Body::Body(Assembly assembly)
    : facets_(std::move(assembly.surface)),
      surface_(first_facets(facets_, assembly.walls)),
      facet_tree_(facets_),
      tree_(surface_),
      features_(features_of(facets_)) {
  for (int f = 0; f < assembly.walls; ++f) wall_patches_ = std::max(wall_patches_, features_.patch[f] + 1);
}

Vec3 Body::moved_inside(const Vec3& x, double depth) const {
  // Away from one wall, then from those that meet it in an edge or corner, again and again where these are sharp.
  constexpr int most_moves = 40;
  constexpr double enough = 0.3;  // of the depth: in the tip of a wedge walls are near on both sides
  constexpr double farthest = 4;  // places in the middle of a chord of a wall that curves inwards lie outside
  Vec3 inside = x;
  for (int move = 0; move < most_moves; ++move) {
    const auto near = tree_.closest(inside, farthest * depth);
    if (!near) break;
    const Vec3& normal = features_.normal[near->facet];
    const double outwards = dot(inside - near->x, normal);
    if (outwards <= -(move == 0 ? 1 : enough) * depth) break;
    inside += (-depth - outwards) * normal;
  }
  return inside;
}

}  // namespace calor
