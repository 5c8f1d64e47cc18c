#pragma once
// Volumes and boundary areas of the points of a body of any shape, as quadratures at the points that are exact for
// linear functions (LinearShares).
#include <vector>

#include "cloud/body_points.hpp"

namespace calor {

/// Volume of every point, m^dimension. The samples of boxes that the surface cuts are scaled such that the sum is the
/// volume of the body.
std::vector<double> body_volumes(const Body& body, const BodyPoints& points, const std::vector<Box>& boxes);

/// What a point has of a patch.
struct PatchShare {
  int point, patch;
  double area;  ///< scalar area, m^(dimension - 1)
  Vec3 vector;  ///< integral of the outward normal over it
};

/// Sorted by point, then by patch. The vectors add up to zero and so do their moments about any place, sum x cross A,
/// to round-off, on curved surfaces too: where facets share their area linearly in their own plane, what is left of
/// the place is normal to them.
std::vector<PatchShare> body_areas(const Body& body, const BodyPoints& points);

}  // namespace calor
