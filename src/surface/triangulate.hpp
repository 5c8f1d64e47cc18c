#pragma once
// Polygons with holes, cut into triangles.
#include <array>
#include <vector>

#include "surface/outline.hpp"

namespace calor {

/// Counter-clockwise triangles that fill the outline. Their vertices are its corners, counted through the contours in
/// order, and all of them: an edge of the outline is an edge of one triangle, any other edge one of two, which run
/// against each other. By ears, after bridges have made the contours one (Eberly, "Triangulation by ear clipping",
/// Geometric Tools, 2002).
std::vector<std::array<int, 3>> triangulate(const Outline& outline);

}  // namespace calor
