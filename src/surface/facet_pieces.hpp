#pragma once
// Pieces into which facets are cut where other facets meet them.
#include <array>
#include <cstdint>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

/// A flat convex piece of a facet, corners as those of the facet; in the plane a segment.
struct FacetPiece {
  std::vector<Vec3> corner;
  std::int32_t face = 0;
};

Vec3 centroid(const FacetPiece& piece);
/// Area vector of a polygon, m^2.
Vec3 area(const std::vector<Vec3>& corner);

// Lengths up to the tolerance, m, are rounding.

/// Cuts a facet in space along others; one without area stays whole.
std::vector<FacetPiece> cut_facet(const FacetPiece& facet, const std::vector<std::array<Vec3, 3>>& others,
                                  double tolerance);
/// Cuts a segment of the plane where others cross or touch it.
std::vector<FacetPiece> cut_segment(const FacetPiece& facet, const std::vector<std::array<Vec3, 2>>& others,
                                    double tolerance);

}  // namespace calor
