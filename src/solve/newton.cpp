#include "solve/newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/archive.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "solve/linear_solver.hpp"

namespace calor {

using petsc::check;

namespace {

constexpr const char* prefix = "heat_";

/// Has the user set it?
bool is_option(const char* name) {
  PetscBool is_set = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, prefix, name, &is_set));
  return is_set == PETSC_TRUE;
}

}  // namespace

Newton::Newton(HeatSystem& system, Equations equations, bool steady)
    : system_(system),
      equations_(std::move(equations)),
      is_steady_(steady),
      T_(system.cloud().local()),
      T_jacobian_(system.cloud().owned),
      tolerance_(system.cloud().owned),
      round_off_(system.cloud().owned),
      J_(system, multiplies_without_matrix(system, steady)),
      x_(petsc::create_vector(J_.products())),
      R_(petsc::create_vector(J_.products())),
      b_(petsc::create_vector(J_.products())) {
  check(SNESCreate(system.cloud().comm, snes_.out()));
  check(SNESSetOptionsPrefix(snes_, prefix));
  check(SNESSetType(snes_, SNESNEWTONLS));
  check(SNESSetFunction(snes_, R_, residual, this));
  check(SNESSetJacobian(snes_, J_.products(), J_.matrix(), jacobian, this));
  check(SNESSetCheckJacobianDomainError(snes_, PETSC_TRUE));
  check(SNESSetConvergenceTest(snes_, converged, this, nullptr));
  if (equations_.correct_step) check(SNESLineSearchSetPreCheck(line_search(), correct_step, this));
  go_carefully(false);
  choose_linear_solver(linear_solver(), system, steady, multiplies_without_matrix(system, steady));
  check(SNESSetFromOptions(snes_));
  knows_linear_tolerance_ = is_option("-ksp_rtol");
}

void Newton::take_as_symmetric(bool yes) {
  PetscBool may_be_either = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(linear_solver()), &may_be_either, KSPCG, KSPGMRES, ""));
  if (may_be_either && !is_option("-ksp_type")) check(KSPSetType(linear_solver(), yes ? KSPCG : KSPGMRES));
}

KSP Newton::linear_solver() const {
  KSP solver = nullptr;
  check(SNESGetKSP(snes_, &solver));
  return solver;
}

SNESLineSearch Newton::line_search() const {
  SNESLineSearch search = nullptr;
  check(SNESGetLineSearch(snes_, &search));
  return search;
}

void Newton::choose_linear_tolerance(double left, double residual) {
  constexpr double least = 1e-9, most = 1e-2;
  if (!is_steady_) return set_linear_tolerance(std::clamp(0.01 / residual, least, most));
  const double first = system_.jacobian_is_constant() ? least : most;
  set_linear_tolerance(left == 0 ? first : std::clamp(std::max(left * left, 0.1 / residual), least, most));
}

void Newton::set_linear_tolerance(double tolerance) {
  if (!knows_linear_tolerance_)
    check(KSPSetTolerances(linear_solver(), tolerance, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
}

void Newton::go_carefully(bool yes) {
  const bool may_grow = equations_.residual_may_grow && !yes;
  check(SNESLineSearchSetType(line_search(), may_grow ? SNESLINESEARCHBASIC : SNESLINESEARCHBT));
}

Newton::Result Newton::solve(std::span<double> T, int most_iterations, double size) {
  if (unit_ == 0) unit_ = petsc::unit_of(size);
  error_ = nullptr;
  starts_ = true, fails_at_start_ = false, step_failed_ = false, at_round_off_ = false;
  last_residual_ = last_norm_ = std::numeric_limits<double>::infinity();
  std::ranges::copy(T, T_.begin());
  petsc::copy(T.first(system_.cloud().owned), x_);
  check(SNESSetTolerances(snes_, 0, 0, 0, most_iterations, PETSC_MAX_INT));
  check_collective(system_.cloud().comm, CallSite::current());
  check(SNESSolve(snes_, nullptr, x_));

  Result result;
  PetscInt iterations = 0, linear_iterations = 0;
  check(SNESGetIterationNumber(snes_, &iterations));
  check(SNESGetLinearSolveIterations(snes_, &linear_iterations));
  result.iterations = static_cast<int>(iterations);
  result.linear_iterations = linear_iterations;
  if (fails_at_start_) std::rethrow_exception(error_);
  if (largest_in_units_of(tolerance_) > 1 && has_jacobian_) {  // which tells what is round-off, unlike the first guess
    petsc::copy(x_, std::span(T_).first(system_.cloud().owned));
    std::ranges::fill(tolerance_, 0), std::ranges::fill(round_off_, 0);
    equations_.tolerance(T_, tolerance_, round_off_);
  }
  result.residual = largest_in_units_of(tolerance_);
  // Where the line search finds nothing better, the digits may have come to their end.
  result.at_round_off = result.residual > 1 && (at_round_off_ || is_round_off());
  result.converged = result.residual <= 1 || result.at_round_off;
  if (!result.converged) result.reason = error_;
  petsc::copy(x_, T.first(system_.cloud().owned));
  return result;
}

void Newton::evaluate_jacobian() {
  std::copy_n(T_.begin(), T_jacobian_.size(), T_jacobian_.begin());
  equations_.jacobian(T_, J_);
  J_.scale(1 / unit_);
  has_jacobian_ = true;
}

void Newton::exchange(Archive& archive) {
  archive.value("unit of equations", unit_);
  archive.value("matrix is old", jacobian_is_old_);
  archive.value("has matrix", has_jacobian_);
  if (!has_jacobian_) return;
  archive.points("temperatures of matrix", T_jacobian_);
  if (!archive.reads()) return;
  std::ranges::copy(T_jacobian_, T_.begin());
  evaluate_jacobian();
  check(KSPSetOperators(linear_solver(), J_.products(), J_.matrix()));
}

void Newton::solve_linear(std::span<const double> b, std::span<double> x, double tolerance) {
  if (!has_jacobian_) {  // every first guess so far was a solution, as in a body at rest
    evaluate_jacobian();
    check(KSPSetOperators(linear_solver(), J_.products(), J_.matrix()));
  }
  set_linear_tolerance(tolerance);
  petsc::copy(b, b_);
  check(VecScale(b_, 1 / unit_));
  petsc::solve(linear_solver(), b_, b_);
  petsc::copy(b_, x);
}

double Newton::largest_in_units_of(const std::vector<double>& unit) const {
  double largest = 0;
  {
    const petsc::View<const double> R(R_);
    for (std::size_t i = 0; i < unit.size(); ++i) {
      if (R.values()[i] == 0) continue;
      const double ratio = std::abs(R.values()[i]) * unit_ / unit[i];
      if (!(ratio <= largest)) largest = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : ratio;
    }
  }
  return max(system_.cloud().comm, largest);
}

bool Newton::is_round_off() const {
  constexpr double few = 64;  // rounding of a whole row and of the linear solution
  return largest_in_units_of(round_off_) <= few;
}

PetscErrorCode Newton::residual(SNES, Vec T, Vec R, void* self) {
  return petsc::callback([&] {
    auto& newton = *static_cast<Newton*>(self);
    petsc::copy(T, std::span(newton.T_).first(newton.system_.cloud().owned));
    const petsc::View<double> values(R);
    if (std::exchange(newton.step_failed_, false)) {
      std::ranges::fill(values.values(), std::numeric_limits<double>::quiet_NaN());
      return;
    }
    try {
      newton.equations_.residual(newton.T_, values.values());
      for (double& R_i : values.values()) R_i /= newton.unit_;
    } catch (const Error&) {
      newton.error_ = std::current_exception();
      newton.fails_at_start_ = newton.starts_;
      std::ranges::fill(values.values(), std::numeric_limits<double>::quiet_NaN());  // the line search halves the step
    }
    newton.starts_ = false;
  });
}

PetscErrorCode Newton::jacobian(SNES snes, Vec T, Mat, Mat, void* self) {
  return petsc::callback([&] {
    auto& newton = *static_cast<Newton*>(self);
    if (!newton.jacobian_is_old_) return;
    petsc::copy(T, std::span(newton.T_).first(newton.system_.cloud().owned));
    try {
      newton.evaluate_jacobian();
      newton.jacobian_is_old_ = newton.always_renew_;
    } catch (const Error&) {
      newton.error_ = std::current_exception();
      check(SNESSetJacobianDomainError(snes));  // ends the iteration
    }
  });
}

PetscErrorCode Newton::correct_step(SNESLineSearch, Vec T, Vec step, PetscBool* changed, void* self) {
  return petsc::callback([&] {
    auto& newton = *static_cast<Newton*>(self);
    petsc::copy(T, std::span(newton.T_).first(newton.system_.cloud().owned));
    const petsc::View<double> view(step);  // PETSc's new iterate is T - step
    const std::span<double> dT = view.values();
    for (double& v : dT) v = -v;
    try {
      newton.equations_.correct_step(newton.T_, dT);
    } catch (const Error&) {
      newton.error_ = std::current_exception();
      newton.step_failed_ = true;  // the residual will say so
    }
    for (double& v : dT) v = -v;
    *changed = PETSC_TRUE;
  });
}

PetscErrorCode Newton::converged(SNES snes, PetscInt iteration, PetscReal, PetscReal, PetscReal R_norm,
                                 SNESConvergedReason* reason, void* self) {
  return petsc::callback([&] {
    auto& newton = *static_cast<Newton*>(self);
    *reason = SNES_DIVERGED_FNORM_NAN;
    if (!std::isfinite(R_norm)) return;
    Vec T = nullptr;
    check(SNESGetSolution(snes, &T));
    petsc::copy(T, std::span(newton.T_).first(newton.system_.cloud().owned));
    std::ranges::fill(newton.tolerance_, 0), std::ranges::fill(newton.round_off_, 0);
    newton.equations_.tolerance(newton.T_, newton.tolerance_, newton.round_off_);
    const double residual = newton.largest_in_units_of(newton.tolerance_);
    // What is a small imbalance of a steady state changes with the flows.
    const double left = newton.is_steady_ ? R_norm / newton.last_norm_ : residual / newton.last_residual_;
    const double slow = newton.is_steady_ ? 0.2 : 0.1;
    const bool falls_no_further = residual > 0.5 * newton.last_residual_;
    PetscInt most_iterations = 0;
    check(SNESGetTolerances(snes, nullptr, nullptr, nullptr, &most_iterations, nullptr));
    *reason = SNES_CONVERGED_ITERATING;
    if (residual <= 1)
      *reason = SNES_CONVERGED_FNORM_ABS;
    else if (falls_no_further && newton.is_round_off())
      *reason = SNES_CONVERGED_FNORM_ABS, newton.at_round_off_ = true;
    else if (iteration >= most_iterations)
      *reason = SNES_DIVERGED_MAX_IT;
    else if (left > slow)
      newton.jacobian_is_old_ = true;  // a kept Jacobian has served its time
    newton.last_residual_ = residual, newton.last_norm_ = R_norm;
    newton.choose_linear_tolerance(left, residual);
  });
}

}  // namespace calor
