#pragma once
// Spacings of points that somebody else placed, from the distances between them; exactly that of a lattice.
#include <span>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

/// Distance of every point from the one next to it, m; 0 for a single point.
std::vector<double> distances_to_nearest(std::span<const Vec3> x);

/// The spacing of every point by its nearest neighbours, m. `normals`: of the walls on which it lies, beyond which it
/// has none.
std::vector<double> spacings_by_distances(int dimension, std::span<const Vec3> x,
                                          std::span<const std::vector<Vec3>> normals);

}  // namespace calor
