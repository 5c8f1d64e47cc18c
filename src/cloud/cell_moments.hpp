#pragma once
// Where the cells of the points lie and how far they reach.
#include <Eigen/Core>
#include <functional>

#include "base/vec3.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// Of a cell in the plane of the cloud, whatever its thickness.
struct CellMoments {
  Vec3 centroid;                                         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< mean of (x - centroid) (x) (x - centroid), m^2
};

/// Calls use(i, its cell) for the owned points, in their order: on lattices boxes, elsewhere what is nearest to the
/// point and on this side of the walls. The points of other clouds lie on their walls. Collective.
void for_each_cell(const Cloud& cloud, const std::function<void(int, const CellMoments&)>& use);

}  // namespace calor
