#pragma once
// A body by its surface: what is inside, and what sees what through it. Where it is made of solids that touch, their
// interfaces take points as walls do, but hide nothing.
#include "surface/combine.hpp"
#include "surface/features.hpp"
#include "surface/surface.hpp"
#include "surface/surface_tree.hpp"

namespace calor {

class Body {
 public:
  /// Points on walls look from this many spacings inside: from wall to wall across a gap a segment crosses nothing
  /// between its ends, and chords of walls that curve inwards leave the body by less.
  static constexpr double skin = 0.1;

  /// Of a closed surface, facets outward.
  explicit Body(Surface surface);
  explicit Body(Assembly assembly);
  Body(const Body&) = delete;  // the tree looks at the surface
  Body& operator=(const Body&) = delete;

  /// The walls.
  const Surface& surface() const { return surface_; }
  const SurfaceTree& tree() const { return tree_; }
  /// The walls, then the interfaces.
  const Surface& facets() const { return facets_; }
  const SurfaceTree& facet_tree() const { return facet_tree_; }
  const Features& features() const { return features_; }  ///< of facets()
  bool has_interfaces() const { return facets_.facets.size() > surface_.facets.size(); }
  bool is_wall(int patch) const { return patch < wall_patches_; }

  /// The place moved inwards until it is `depth` (m) away from the surface next to it; itself if it lies deeper.
  Vec3 moved_inside(const Vec3& x, double depth) const;
  /// Does the straight way between two places run through the body alone? Those on walls are to be moved inside
  /// before: a segment from wall to wall across a gap crosses nothing between its ends.
  bool sees(const Vec3& a, const Vec3& b) const { return !tree_.is_crossed(a, b); }

 private:
  Surface facets_, surface_;
  SurfaceTree facet_tree_, tree_;
  Features features_;
  int wall_patches_ = 0;  // they come first
};

}  // namespace calor
