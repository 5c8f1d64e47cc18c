#pragma once
// The features of a surface: its smooth patches, the lines along which it has an edge, and its corners. Points go on
// corners first, then along lines, then on patches; the area of a patch belongs to its points.
#include <vector>

#include "surface/surface.hpp"

namespace calor {

/// A patch is what is smooth and of one face: facets that meet at less than 30 degrees, no third one between them. In
/// the plane a patch is a curve without corners, and is itself a line.
struct Features {
  /// Edges between patches that follow each other, between two corners or around.
  struct Line {
    std::vector<int> vertices;  ///< the first again at the end of a closed one
    std::vector<int> facets;    ///< on both sides, and interfaces that end there; in the plane the line itself
  };
  struct Corner {
    int vertex;
    std::vector<int> facets;  ///< that meet there
  };

  int count = 0;
  std::vector<int> patch;    ///< of every facet
  std::vector<Vec3> normal;  ///< of every facet: see facet_normals
  std::vector<Line> lines;
  std::vector<Corner> corners;  ///< where lines end, and tips of cones
};

/// Of a closed surface, and of the interfaces in it, whose edges are edges of facets of others as a whole.
Features features_of(const Surface& surface);

}  // namespace calor
