#include "solve/point_values.hpp"

#include <algorithm>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace calor {

PointValues::PointValues(const Cloud& cloud, const SparseRows& phi) : cloud_(cloud), phi_(phi) {
  std::vector<PetscInt> diagonal(cloud.owned), off_diagonal(cloud.owned), numbers;
  for (int i = 0; i < cloud.owned; ++i)
    for (std::int64_t n = phi.row[i]; n < phi.row[i + 1]; ++n)
      ++(phi.column[n] < cloud.owned ? diagonal : off_diagonal)[i];
  MatCreate(cloud.comm, &matrix_);
  MatSetSizes(matrix_, cloud.owned, cloud.owned, PETSC_DETERMINE, PETSC_DETERMINE);
  MatSetType(matrix_, MATAIJ);
  MatSeqAIJSetPreallocation(matrix_, 0, diagonal.data());
  MatMPIAIJSetPreallocation(matrix_, 0, diagonal.data(), 0, off_diagonal.data());
  for (int i = 0; i < cloud.owned; ++i) {
    numbers.clear();
    for (std::int64_t n = phi.row[i]; n < phi.row[i + 1]; ++n)
      numbers.push_back(static_cast<PetscInt>(cloud.global[phi.column[n]]));
    const auto row = static_cast<PetscInt>(cloud.global[i]);
    MatSetValues(matrix_, 1, &row, static_cast<PetscInt>(numbers.size()), numbers.data(), phi.value.data() + phi.row[i],
                 INSERT_VALUES);
  }
  MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY);
  MatCreateVecs(matrix_, &solution_, &right_);
  KSPCreate(cloud.comm, &solver_);
  KSPSetOperators(solver_, matrix_, matrix_);
  KSPSetType(solver_, KSPGMRES);
  KSPGMRESSetRestart(solver_, 60);
  KSPSetTolerances(solver_, 1e-14, 1e-300, PETSC_DEFAULT, 2000);
  KSPSetOptionsPrefix(solver_, "values_");
  KSPSetFromOptions(solver_);
}

PointValues::~PointValues() {
  KSPDestroy(&solver_);
  VecDestroy(&right_);
  VecDestroy(&solution_);
  MatDestroy(&matrix_);
}

void PointValues::unknowns(std::span<const double> values, std::span<double> T) const {
  // The rows of Phi add up to 1, so the mean of the values needs no solution: uniform temperatures stay exact.
  const double mean = sum(cloud_.comm, values) / static_cast<double>(cloud_.count);
  std::vector<double> change(values.begin(), values.end());
  double largest = 0;
  for (double& value : change) {
    value -= mean;
    largest = std::max(largest, std::abs(value));
  }
  std::fill_n(T.begin(), cloud_.owned, mean);
  if (max(cloud_.comm, largest) > 1e-14 * std::abs(mean)) add(change, T);
}

void PointValues::add(std::span<const double> change, std::span<double> T) const {
  double* right = nullptr;
  VecGetArray(right_, &right);
  std::ranges::copy(change, right);
  VecRestoreArray(right_, &right);
  KSPSolve(solver_, right_, solution_);
  double residual = 0, size = 0;
  KSPGetResidualNorm(solver_, &residual);
  VecNorm(right_, NORM_2, &size);
  if (!(residual <= 1e-10 * size))
    throw Error(Fault::numbers, "the unknowns that give the temperatures of the points could not be found",
                "use a smaller support, or points that are more regular");
  const double* solution = nullptr;
  VecGetArrayRead(solution_, &solution);
  for (int i = 0; i < cloud_.owned; ++i) T[i] += solution[i];
  VecRestoreArrayRead(solution_, &solution);
}

}  // namespace calor
