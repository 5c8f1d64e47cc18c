#pragma once
// Algebraic rows at wall points, as the paper of Rong & Kisu has them (eq. 5 with corrected signs).
#include <span>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/flux_sites.hpp"

namespace calor {

/// Rows of all owned points that lie on a face: weight_ij = sum over the faces of 2 V_j grad W_ij . n, the factor 2
/// ("zeta") for the half of the support that the wall cuts off. `G`: 2 V_i V_j F_ij / section with full volumes.
WallRows zeta_rows(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G);

}  // namespace calor
