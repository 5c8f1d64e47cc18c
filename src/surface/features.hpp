#pragma once
// The smooth pieces of a surface and the lines along which it has an edge. Points go on corners first, then along
// lines, then on patches; the area of a patch belongs to its points.
#include <vector>

#include "surface/surface.hpp"

namespace calor {

/// A patch is what hangs together of one face, across edges at which facets meet at less than 30 degrees. In the plane
/// a patch is a curve without corners, and is itself a line.
struct SmoothPatches {
  /// Edges between patches that follow each other, between two corners or around.
  struct Line {
    std::vector<int> vertices;  ///< the first again at the end of a closed one
    std::vector<int> facets;    ///< on both sides; in the plane the line itself
  };
  struct Corner {
    int vertex;
    std::vector<int> facets;  ///< that meet there
  };

  int count = 0;
  std::vector<int> patch;     ///< of every facet
  std::vector<Vec3> normal;   ///< unit, outward, of every facet; slivers have that of the facet across their longest edge
  std::vector<Line> lines;
  std::vector<Corner> corners;  ///< where lines end
};

/// Of a closed surface.
SmoothPatches smooth_patches(const Surface& surface);

}  // namespace calor
