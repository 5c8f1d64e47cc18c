#pragma once
// Which points of the cloud are of which material: layers, regions by formula or tag, or one material for all.
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// Where materials are wanted: at the local points of a cloud, or at places between them.
struct MaterialPoints {
  std::span<const Vec3> x;   ///< m
  std::span<const int> tag;  ///< index into Cloud::tags, one a place
};

/// Points of one material.
struct BodyRegion {
  std::string material;
  SourceLocation location;          ///< where the case names it
  bool whole = false;               ///< all places, with weight 1; the lists are empty
  std::vector<int> point = {};      ///< ascending
  std::vector<double> weight = {};  ///< the place's share of this material
};

/// One entry per material of the body, the same on all ranks; the weights of a place add up to 1. Throws
/// Error(bad_case) for layers that do not cover the body, selections without places, places without material.
/// Collective.
std::vector<BodyRegion> body_regions(const Case& c, const Cloud& cloud, const MaterialPoints& places,
                                     const std::string& only_material);

}  // namespace calor
