#include "surface/body.hpp"

#include <utility>

namespace calor {

Body::Body(Surface surface) : surface_(std::move(surface)), tree_(surface_), features_(features_of(surface_)) {}

Vec3 Body::moved_inside(const Vec3& x, double depth) const {
  Vec3 inside = x;
  // Away from one wall, then from those that meet it in an edge or corner.
  for (int wall = 0; wall < 3; ++wall) {
    const auto near = tree_.closest(inside, 0.99 * depth);
    if (!near) break;
    const Vec3& normal = features_.normal[near->facet];
    inside += (-depth - dot(inside - near->x, normal)) * normal;
  }
  return inside;
}

}  // namespace calor
