#pragma once
// Questions about places and a closed surface: inside or not, the closest point, is the way blocked.
#include <memory>
#include <optional>
#include <vector>

#include "base/vec3.hpp"
#include "surface/surface.hpp"

namespace calor {

/// A hierarchy of boxes around the facets (split by the surface area heuristic), in doubles. The surface must outlive
/// it and stay as it is. All queries are const; those of places and segments allocate nothing.
class SurfaceTree {
 public:
  explicit SurfaceTree(const Surface& surface);
  ~SurfaceTree();

  /// Generalised winding number: 1 inside, 0 outside, between in holes of an open surface. Far boxes count as dipoles
  /// (Barill et al., ACM Trans. Graph. 37 (2018) 43).
  double winding_number(const Vec3& x) const;
  bool is_inside(const Vec3& x) const { return winding_number(x) > 0.5; }

  struct Closest {
    int facet;
    Vec3 x;           ///< on the facet, m
    double distance;  ///< m
  };
  /// The closest place of the surface, if it is nearer than `bound` (m).
  std::optional<Closest> closest(const Vec3& x, double bound) const;

  /// Does the segment from a to b cross a facet?
  bool is_crossed(const Vec3& a, const Vec3& b) const;
  /// The parts of the way at which it crosses facets, in any order; at an edge that two of them share maybe twice.
  std::vector<double> crossings(const Vec3& a, const Vec3& b) const;

  /// Does the box of any facet overlap this box?
  bool touches(const Vec3& low, const Vec3& high) const;
  /// The facets whose boxes overlap this box, in ascending order.
  std::vector<int> facets_in(const Vec3& low, const Vec3& high) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace calor
