#pragma once
// Volumes of the points of a jittered lattice.
#include <vector>

#include "cloud/lattice.hpp"

namespace calor {

/// Volume of the part of the box that is nearer to point id of `mine` than to any other, in m^dimension; over all
/// points they add up to the box. Exact: sampled volumes would leave an error that does not fall with the spacing.
std::vector<double> nearest_point_volumes(const Lattice& lattice, const Slice& mine);

}  // namespace calor
