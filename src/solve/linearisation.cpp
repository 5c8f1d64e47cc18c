#include "solve/linearisation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "solve/linear_solver.hpp"

namespace calor {

using petsc::check;

Linearisation::Linearisation(HeatSystem& system, std::span<double> u, bool transposed)
    : system_(system), J_(system.create_jacobian()), b_(petsc::create_vector(J_)), is_transposed_(transposed) {
  system.jacobian(0, u, 0, 1, J_);
  scale_rows();
  if (transposed && !system.jacobian_is_symmetric()) {
    petsc::Matrix J_transposed;
    check(MatTranspose(J_, MAT_INITIAL_MATRIX, J_transposed.out()));
    J_ = std::move(J_transposed);
  }
  prepare(true);
}

Linearisation::Linearisation(HeatSystem& system, double t, std::span<double> u, double gamma_dt)
    : system_(system), J_(system.create_jacobian()), b_(petsc::create_vector(J_)) {
  system.jacobian(t, u, 1, gamma_dt, J_);
  scale_rows();
  prepare(false);
}

void Linearisation::prepare(bool steady) {
  check(KSPCreate(system_.cloud().comm, solver_.out()));
  choose_linear_solver(solver_, system_, steady);
  constexpr double tolerance = 1e-12;
  check(KSPSetTolerances(solver_, tolerance, 1e-300, PETSC_DEFAULT, 10'000));
  check(KSPSetOperators(solver_, J_, J_));
}

/// Rows of prescribed temperatures hold J, as those of the others hold W: in the middle of the others they would spoil
/// the pivots. Points within an insulator have empty rows: their temperatures stay.
void Linearisation::scale_rows() {
  petsc::Vector diagonal = petsc::create_vector(J_), rows = petsc::create_vector(J_);
  check(MatGetDiagonal(J_, diagonal));
  row_scale_.assign(system_.cloud().owned, 1);
  std::vector<double> d(row_scale_.size());
  petsc::copy(diagonal, d);
  for (const int i : system_.prescribed()) d[i] = 0;
  double size = 0;
  for (const double value : d) size = std::max(size, std::abs(value));
  size = max(system_.cloud().comm, size);
  if (!(size > 0)) size = 1;
  for (const int i : system_.prescribed()) row_scale_[i] = size, d[i] = 1;
  petsc::copy(row_scale_, rows);
  check(MatDiagonalScale(J_, rows, nullptr));
  PetscInt first = 0;
  check(MatGetOwnershipRange(J_, &first, nullptr));
  for (std::size_t i = 0; i < d.size(); ++i) {
    const PetscInt row = first + static_cast<PetscInt>(i);
    if (d[i] == 0) check(MatSetValue(J_, row, row, size, INSERT_VALUES));
  }
  petsc::assemble(J_);
  unit_ = petsc::unit_of(size);
  check(MatScale(J_, 1 / unit_));
}

void Linearisation::solve(std::span<const double> b, std::span<double> x) {
  std::vector<double> scaled(b.begin(), b.end());
  for (std::size_t i = 0; i < scaled.size() && !is_transposed_; ++i) scaled[i] *= row_scale_[i];
  petsc::copy(scaled, b_);
  check(VecScale(b_, 1 / unit_));
  if (!petsc::solve(solver_, b_, b_))
    throw Error(Fault::numbers, "the linear equations of the derivatives have no solution",
                "look for parts of the body that nothing holds at a temperature");
  petsc::copy(b_, x);
  for (std::size_t i = 0; i < x.size() && is_transposed_; ++i) x[i] *= row_scale_[i];
}

std::vector<double> Linearisation::sum_at_owners(std::span<const double> w) {
  check(VecSet(b_, 0));
  for (std::size_t j = 0; j < w.size(); ++j)
    if (w[j] != 0) check(VecSetValue(b_, static_cast<PetscInt>(system_.cloud().global[j]), w[j], ADD_VALUES));
  check_collective(system_.cloud().comm, CallSite::current());
  check(VecAssemblyBegin(b_));
  check(VecAssemblyEnd(b_));
  std::vector<double> sums(system_.cloud().owned);
  petsc::copy(b_, sums);
  return sums;
}

}  // namespace calor
