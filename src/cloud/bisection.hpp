#pragma once
// Blocks of points for the ranks.
#include <mpi.h>

#include <span>
#include <vector>

#include "cloud/points.hpp"

namespace calor {

/// The rank that every point of this rank belongs to. Recursive coordinate bisection (Berger & Bokhari, IEEE Trans.
/// Comput. C-36 (1987) 570): always across the longest side, equal shares to one point, ties by the other coordinates
/// and the id. The blocks do not depend on how the points were distributed before. Collective.
std::vector<int> bisect(MPI_Comm comm, std::span<const Point> points);

}  // namespace calor
