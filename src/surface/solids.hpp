#pragma once
// The solids that a body is made of: which of them holds a place.
#include <memory>
#include <span>
#include <vector>

#include "surface/surface.hpp"
#include "surface/surface_tree.hpp"

namespace calor {

class Solids {
 public:
  /// Closed surfaces, facets outward, that do not overlap, and the tag of each.
  Solids(std::vector<Surface> surfaces, std::vector<int> tags);

  /// Tag of the solid that holds the place; of those that meet there the first one. -1: it lies outside.
  int tag_at(const Vec3& x) const;
  /// The same for many places. Fast where each lies near the one before.
  void tags_at(std::span<const Vec3> x, std::span<int> tags) const;

 private:
  struct Solid {
    Surface surface;
    SurfaceTree tree;
    Vec3 low, high;  // of a box around it, a little larger
    double on;       // places nearer to the surface than this lie on it, m
    int tag;

    Solid(Surface s, int tag);
  };
  /// The solid, and whether the place surely lies inside, not on its surface.
  struct Found {
    int solid;
    bool is_inside;
  };
  Found find(const Vec3& x) const;

  std::vector<std::unique_ptr<const Solid>> solids_;
};

}  // namespace calor
