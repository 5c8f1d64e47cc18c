#pragma once
#include "base/petsc.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// Sets up a new solver for linear equations with the Jacobian of the system: of a `steady` state, or of the stages of
/// a time step. `with_products`: the matrix of the preconditioner is that of the nearest pairs. Collective.
void choose_linear_solver(KSP solver, const HeatSystem& system, bool steady, bool with_products = false);

/// Does it ask of the Jacobian of a steady state for no more than products and the nearest pairs?
bool multiplies_without_matrix(const HeatSystem& system, bool steady);

}  // namespace calor
