#pragma once
// Volumes of the points of a jittered lattice.
#include <vector>

#include "cloud/lattice.hpp"

namespace calor {

/// Volume nearest to each point id of `mine`, inside the box, in m^dimension; over all points they add up to the box.
/// Exact in 1D; in 2D and 3D counted on samples, one at a random place of each of 8^2 or 4^3 sub-cells per lattice cell
/// (placed at random because a regular sampling beats with the lattice and ruins the order of convergence).
std::vector<double> nearest_point_volumes(const Lattice& lattice, const Slice& mine);

}  // namespace calor
