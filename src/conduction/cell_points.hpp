#pragma once
// Quadrature points inside the cells of the points, for the heat that they hold.
#include "cloud/cloud.hpp"
#include "conduction/quadrature.hpp"

namespace calor {

/// Every cell's own point. The rows phi are left empty.
CellQuadrature one_point(const Cloud& cloud);

/// 2^D points a cell that integrate quadratic functions: c + S^(1/2) (+-1, +-1, +-1), c the centroid and S the
/// covariance of the cell; for a box they are its 2^D Gauss points. The cell is the box of a box lattice, otherwise the
/// part of the body that is nearer to its point than to any other, behind the planes of the walls of its point. The
/// rows phi are left empty. Does not depend on the number of ranks. Collective.
CellQuadrature gauss_points(const Cloud& cloud);

}  // namespace calor
