#pragma once
// A convex polyhedron that planes cut segments off: the part of the body that is nearer to one point than to others.
#include <array>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

class ConvexCell {
 public:
  /// The box between two corners around the origin. Bodies of one or two dimensions have a length of 1 along the
  /// others.
  void set(const Vec3& low, const Vec3& high, int dimension);
  /// Keeps what lies at n.x <= offset. Did it cut anything off?
  bool cut(const Vec3& n, double offset);
  /// Keeps what is nearer to the origin than to r.
  bool keep_nearer_than(const Vec3& r) { return cut(r, 0.5 * dot(r, r)); }
  /// Largest distance of a corner from the origin.
  double reach() const;

  /// Integrals of 1, x and the products xx, yy, zz, xy, xz, yz.
  struct Moments {
    double volume = 0;
    Vec3 first;
    std::array<double, 6> second = {};
  };
  Moments moments() const;
  double volume() const { return moments().volume; }

 private:
  /// Side of a face, counter-clockwise as seen from outside. The sides of a face follow each other in the list, in any
  /// order: neither its area nor a cut needs more.
  struct Side {
    Vec3 from, to;
    int face;
  };
  std::vector<Side> sides_, cut_, fresh_;
  int faces_ = 0, dimension_ = 3;
  double size_ = 0;
};

}  // namespace calor
