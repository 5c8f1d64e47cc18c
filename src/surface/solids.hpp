#pragma once
// The solids that a body is made of: which of them holds a place.
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "surface/surface.hpp"
#include "surface/surface_tree.hpp"

namespace calor {

class Solids {
 public:
  /// Closed surfaces, facets outward, that do not overlap, the tag of each, and the facets where two of them meet.
  Solids(std::vector<Surface> surfaces, std::vector<int> tags, Surface interfaces);

  /// Tag of the solid that holds the place; of those that meet there the first one. -1: it lies outside.
  int tag_at(const Vec3& x) const;
  /// The same for many places. Fast where each lies near the one before.
  void tags_at(std::span<const Vec3> x, std::span<int> tags) const;
  /// A smooth piece of the interfaces between two solids, and its unit normal next to a place.
  struct Interface {
    int piece;
    Vec3 normal;
  };
  /// Next to the place, none where it is farther than `bound` (m).
  std::optional<Interface> interface_at(const Vec3& x, double bound) const;
  /// Areas of the pieces that are curved, 0 for the plane ones, m^(dimension - 1).
  std::span<const double> curved_areas() const { return curved_areas_; }

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
  void find_pieces();

  std::vector<std::unique_ptr<const Solid>> solids_;
  Surface interfaces_;
  SurfaceTree tree_;        // of the interfaces
  std::vector<int> piece_;  // of every one of their facets
  std::vector<double> curved_areas_;
};

}  // namespace calor
