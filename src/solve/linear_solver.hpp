#pragma once
#include "base/petsc.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// Sets up a new solver for linear equations with the Jacobian of the system: of a `steady` state, or of the stages of
/// a time step. Collective.
void choose_linear_solver(KSP solver, const HeatSystem& system, bool steady);

}  // namespace calor
