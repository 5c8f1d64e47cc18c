#pragma once
// A preconditioner for steady conduction in many points: multigrid by aggregation. Notay, Electron. Trans. Numer. Anal.
// 37 (2010) 123 (aggregates); Braess, Computing 55 (1995) 379 (the factor of the coarse correction).
#include <petscksp.h>

#include "cloud/cloud.hpp"

namespace calor {

/// Makes `preconditioner` this multigrid, for matrices with a row for every owned point of the cloud, in its order. The
/// aggregates of a level are the points in bins twice as wide as those of the level before, along the axes along which
/// they are coupled strongly; the coarse matrix is that of temperatures equal within aggregates. A W-cycle with one
/// sweep of Gauss-Seidel forwards before and one backwards after the coarse correction, hence symmetric. Bins do not
/// reach from rank to rank; the coarsest level is solved directly, in double precision, the others in single precision
/// unless hardly anything holds the level of the temperatures. Matrices of many neighbours are thinned first (see
/// NearestPairs), unless they are thin already. The cloud must outlive the preconditioner.
void use_aggregation_multigrid(PC preconditioner, const Cloud& cloud, bool is_thin);

}  // namespace calor
