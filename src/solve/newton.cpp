#include "solve/newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.hpp"

namespace calor {
namespace {

void copy(std::span<const double> from, Vec to) {
  double* values = nullptr;
  VecGetArray(to, &values);
  std::ranges::copy(from, values);
  VecRestoreArray(to, &values);
}

void copy(Vec from, std::span<double> to) {
  const double* values = nullptr;
  VecGetArrayRead(from, &values);
  std::copy_n(values, to.size(), to.begin());
  VecRestoreArrayRead(from, &values);
}

}  // namespace

Newton::Newton(HeatSystem& system, Equations equations, bool steady)
    : system_(system), equations_(std::move(equations)), T_(system.cloud().local()), J_(system.create_jacobian()) {
  MatCreateVecs(J_, &x_, &R_);
  VecDuplicate(x_, &b_);
  SNESCreate(system.cloud().comm, &snes_);
  SNESSetOptionsPrefix(snes_, "heat_");
  SNESSetType(snes_, SNESNEWTONLS);
  SNESSetFunction(snes_, R_, residual, this);
  SNESSetJacobian(snes_, J_, J_, jacobian, this);
  SNESSetConvergenceTest(snes_, converged, this, nullptr);
  SNESLineSearch search;
  SNESGetLineSearch(snes_, &search);
  SNESLineSearchSetType(search, SNESLINESEARCHBT);
  if (equations_.bend) {
    // A bent step need not make the residual smaller at once.
    SNESLineSearchSetType(search, SNESLINESEARCHBASIC);
    SNESLineSearchSetPreCheck(search, bend, this);
  }
  choose_linear_solver(steady);
  SNESSetFromOptions(snes_);
}

Newton::~Newton() {
  SNESDestroy(&snes_);
  VecDestroy(&b_);
  VecDestroy(&R_);
  VecDestroy(&x_);
  MatDestroy(&J_);
}

void Newton::choose_linear_solver(bool steady) {
  const Cloud& cloud = system_.cloud();
  const bool symmetric = system_.jacobian_is_symmetric(), alone = size_of(cloud.comm) == 1;
  // Stencils that are not symmetric (MLPG) are wide: factors fill in soon, and coarse levels are no help.
  // In the plane a steady state still is worth a factorisation; the stages of a time step are well conditioned.
  const bool wide =
      !system_.frozen_jacobian_is_symmetric() && (cloud.dimension == 3 || (cloud.dimension == 2 && !steady));
  // A factorisation fills in little for lines and planes, and is the most robust; bodies soon outgrow it.
  const std::int64_t most_rows_for_direct = wide ? 2'000 : cloud.dimension < 3 && alone ? 100'000 : 20'000;
  KSP solver;
  PC preconditioner;
  SNESGetKSP(snes_, &solver);
  KSPGetPC(solver, &preconditioner);
  if (cloud.count <= most_rows_for_direct) {
    KSPSetType(solver, KSPPREONLY);
    PCSetType(preconditioner, symmetric ? PCCHOLESKY : PCLU);
    PCFactorSetMatSolverType(preconditioner, alone ? MATSOLVERPETSC : MATSOLVERMUMPS);
    return;
  }
  KSPSetType(solver, symmetric ? KSPCG : KSPBCGS);
  KSPSetTolerances(solver, 1e-9, 1e-300, PETSC_DEFAULT, 10'000);
  if (steady && !wide) {
    PCSetType(preconditioner, PCGAMG);
  } else {
    PCSetType(preconditioner, PCBJACOBI);  // with ICC or ILU inside, of the rows of each rank
    KSPSetInitialGuessNonzero(solver, PETSC_FALSE);
  }
}

Newton::Result Newton::solve(std::span<double> T, std::span<const double> tolerance, int most_iterations) {
  tolerance_ = tolerance;
  error_ = nullptr;
  starts_ = true, fails_at_start_ = false;
  last_residual_ = std::numeric_limits<double>::infinity();
  std::ranges::copy(T, T_.begin());
  copy(T.first(system_.cloud().owned), x_);
  SNESSetTolerances(snes_, 0, 0, 0, most_iterations, PETSC_MAX_INT);
  SNESSolve(snes_, nullptr, x_);

  Result result;
  PetscInt iterations = 0, linear_iterations = 0;
  SNESGetIterationNumber(snes_, &iterations);
  SNESGetLinearSolveIterations(snes_, &linear_iterations);
  result.iterations = static_cast<int>(iterations);
  result.linear_iterations = linear_iterations;
  if (fails_at_start_) std::rethrow_exception(error_);
  result.residual = weighted(R_);
  // At the end of the line search's digits the residual cannot fall further.
  result.converged = result.residual <= 1;
  if (!result.converged) result.reason = error_;
  copy(x_, T.first(system_.cloud().owned));
  return result;
}

void Newton::solve_linear(std::span<const double> b, std::span<double> x) {
  KSP solver;
  SNESGetKSP(snes_, &solver);
  copy(b, b_);
  KSPSolve(solver, b_, b_);
  copy(b_, x);
}

double Newton::weighted(Vec R) const {
  const double* values = nullptr;
  VecGetArrayRead(R, &values);
  double largest = 0;
  for (std::size_t i = 0; i < tolerance_.size(); ++i) {
    const double ratio = std::abs(values[i]) / tolerance_[i];
    if (!(ratio <= largest)) largest = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
  }
  VecRestoreArrayRead(R, &values);
  return max(system_.cloud().comm, largest);
}

// PETSc calls the following from C: no exception may pass.

PetscErrorCode Newton::residual(SNES, Vec T, Vec R, void* self) {
  auto& newton = *static_cast<Newton*>(self);
  const int owned = newton.system_.cloud().owned;
  copy(T, std::span(newton.T_).first(owned));
  double* values = nullptr;
  VecGetArray(R, &values);
  try {
    newton.equations_.residual(newton.T_, std::span<double>(values, owned));
  } catch (...) {
    newton.error_ = std::current_exception();
    newton.fails_at_start_ = newton.starts_;
    std::fill_n(values, owned, std::numeric_limits<double>::quiet_NaN());  // the line search then halves the step
  }
  newton.starts_ = false;
  VecRestoreArray(R, &values);
  return 0;
}

PetscErrorCode Newton::jacobian(SNES, Vec T, Mat J, Mat, void* self) {
  auto& newton = *static_cast<Newton*>(self);
  if (!newton.jacobian_is_old_) return 0;
  copy(T, std::span(newton.T_).first(newton.system_.cloud().owned));
  try {
    newton.equations_.jacobian(newton.T_, J);
  } catch (...) {
    newton.error_ = std::current_exception();
    return PETSC_ERR_USER;
  }
  newton.jacobian_is_old_ = newton.always_renew_;
  return 0;
}

PetscErrorCode Newton::bend(SNESLineSearch, Vec T, Vec step, PetscBool* changed, void* self) {
  auto& newton = *static_cast<Newton*>(self);
  const int owned = newton.system_.cloud().owned;
  copy(T, std::span(newton.T_).first(owned));
  double* values = nullptr;
  VecGetArray(step, &values);  // PETSc's new iterate is T - step
  std::span<double> dT(values, owned);
  for (double& v : dT) v = -v;
  try {
    newton.equations_.bend(newton.T_, dT);
  } catch (...) {
    newton.error_ = std::current_exception();
    std::ranges::fill(dT, std::numeric_limits<double>::quiet_NaN());  // the residual will say so
  }
  for (double& v : dT) v = -v;
  VecRestoreArray(step, &values);
  *changed = PETSC_TRUE;
  return 0;
}

PetscErrorCode Newton::converged(SNES snes, PetscInt iteration, PetscReal, PetscReal, PetscReal R_norm,
                                 SNESConvergedReason* reason, void* self) {
  auto& newton = *static_cast<Newton*>(self);
  Vec R;
  SNESGetFunction(snes, &R, nullptr, nullptr);
  const double residual = newton.weighted(R);
  PetscInt most_iterations;
  SNESGetTolerances(snes, nullptr, nullptr, nullptr, &most_iterations, nullptr);
  *reason = SNES_CONVERGED_ITERATING;
  if (residual <= 1)
    *reason = SNES_CONVERGED_FNORM_ABS;
  else if (!std::isfinite(R_norm))
    *reason = SNES_DIVERGED_FNORM_NAN;
  else if (iteration >= most_iterations)
    *reason = SNES_DIVERGED_MAX_IT;
  else if (residual > 0.1 * newton.last_residual_)
    newton.jacobian_is_old_ = true;  // a kept Jacobian has served its time
  newton.last_residual_ = residual;
  return 0;
}

}  // namespace calor
