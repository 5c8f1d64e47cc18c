#pragma once
// A body by its surface: what is inside, and what sees what through it.
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
  Body(const Body&) = delete;  // the tree looks at the surface
  Body& operator=(const Body&) = delete;

  const Surface& surface() const { return surface_; }
  const SurfaceTree& tree() const { return tree_; }
  const Features& features() const { return features_; }

  /// The place moved inwards until it is `depth` (m) away from the surface next to it; itself if it lies deeper.
  Vec3 moved_inside(const Vec3& x, double depth) const;
  /// Does the straight way between two places run through the body alone? Those on walls are to be moved inside
  /// before: a segment from wall to wall across a gap crosses nothing between its ends.
  bool sees(const Vec3& a, const Vec3& b) const { return !tree_.is_crossed(a, b); }

 private:
  Surface surface_;
  SurfaceTree tree_;
  Features features_;
};

}  // namespace calor
