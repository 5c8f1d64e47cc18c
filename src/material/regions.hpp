#pragma once
// Which points of the cloud are of which material: layers, regions by formula or tag, or one material for all.
#include <string>
#include <vector>

#include "case/case.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// Local points of one material.
struct BodyRegion {
  std::string material;
  Place place;                      ///< where the case names it
  bool whole = false;               ///< all local points, with weight 1; the lists are empty
  std::vector<int> point = {};      ///< ascending
  std::vector<double> weight = {};  ///< the point's share of this material
};

/// One entry per material of the body, the same on all ranks; the weights of a point add up to 1. Throws
/// Error(bad_case) for layers that do not cover the body, selections without points, points without material.
/// Collective.
std::vector<BodyRegion> body_regions(const Case& c, const Cloud& cloud, const std::string& only_material);

}  // namespace calor
