#include "solve/linear_solver.hpp"

#include "base/parallel.hpp"
#include "solve/aggregation_multigrid.hpp"

namespace calor {

using petsc::check;

namespace {

enum class Way { factors, multigrid, factors_of_blocks };

Way way_of(const HeatSystem& system, bool steady) {
  const Cloud& cloud = system.cloud();
  // Stencils that are not symmetric (MLPG) are wide: factors fill in soon, and coarse levels are no help.
  // In the plane a steady state still is worth a factorisation; the stages of a time step are well conditioned.
  const bool wide =
      !system.frozen_jacobian_is_symmetric() && (cloud.dimension == 3 || (cloud.dimension == 2 && !steady));
  // A factorisation fills in little for lines and planes, and is the most robust. In bodies it costs the square of the
  // rows, times what a point couples to: an iteration is ten times faster from 9000 rows on.
  const bool alone = size_of(cloud.comm) == 1;
  const std::int64_t most_rows_for_direct = wide && !steady        ? 500
                                            : cloud.dimension == 3 ? 2'000
                                            : alone                ? 100'000
                                                                   : 20'000;
  if (cloud.count <= most_rows_for_direct) return Way::factors;
  return steady && !wide ? Way::multigrid : Way::factors_of_blocks;
}

}  // namespace

void choose_linear_solver(KSP solver, const HeatSystem& system, bool steady, bool with_products) {
  const Cloud& cloud = system.cloud();
  const bool symmetric = system.jacobian_is_symmetric();
  const Way way = way_of(system, steady);
  if (way == Way::factors) return petsc::factorise(solver, cloud.count, symmetric);
  PC preconditioner = nullptr;
  check(KSPGetPC(solver, &preconditioner));
  const bool is_linear = system.jacobian_is_constant();
  check(KSPSetType(solver, symmetric ? KSPCG : steady && !is_linear ? KSPGMRES : KSPBCGS));
  check(KSPSetTolerances(solver, steady && !is_linear ? 1e-2 : 1e-9, 1e-300, PETSC_DEFAULT, 10'000));
  if (way == Way::multigrid) {
    use_aggregation_multigrid(preconditioner, cloud, with_products);
  } else {
    check(PCSetType(preconditioner, PCBJACOBI));  // with ICC or ILU inside, of the rows of each rank
    check(KSPSetInitialGuessNonzero(solver, PETSC_FALSE));
  }
}

bool multiplies_without_matrix(const HeatSystem& system, bool steady) {
  return way_of(system, steady) == Way::multigrid && system.discretisation().conduction->multiplies();
}

}  // namespace calor
