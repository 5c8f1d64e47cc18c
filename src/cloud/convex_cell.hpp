#pragma once
// A convex polyhedron that planes cut pieces off: the part of a box that is nearer to one point than to others.
#include <vector>

#include "base/vec3.hpp"

namespace calor {

class ConvexCell {
 public:
  /// The box between two corners; the origin lies in it.
  void set(const Vec3& low, const Vec3& high);
  /// Keeps what lies on the origin's side of the plane that halves the way from the origin to r. Did it cut?
  bool cut_half_way_to(const Vec3& r);
  double volume() const;
  /// Largest squared distance of a corner from the origin, of the first `dimension` coordinates.
  double square_reach(int dimension) const;

 private:
  /// Side of a face, counter-clockwise as seen from outside. The sides of a face follow each other in the list, in any
  /// order: neither its area nor a cut needs more.
  struct Side {
    Vec3 from, to;
    int face;
  };
  std::vector<Side> sides_, cut_, fresh_;
  int faces_ = 0;
};

}  // namespace calor
