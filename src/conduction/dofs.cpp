#include "conduction/dofs.hpp"

#include <algorithm>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace calor {
namespace {

using petsc::check;

/// In the plane supports are wide and Phi is almost blind to some waves, but factors fill in little.
std::int64_t most_rows_for_direct(const Cloud& cloud) {
  if (cloud.dimension == 3) return 2'000;
  return size_of(cloud.comm) == 1 ? 100'000 : 20'000;
}

/// Incomplete factors of the rows of each rank.
void fill_in_blocks(PC preconditioner, int levels) {
  check(PCSetType(preconditioner, PCBJACOBI));
  check(PCSetUp(preconditioner));
  KSP* blocks = nullptr;
  PetscInt count = 0;
  check(PCBJacobiGetSubKSP(preconditioner, &count, nullptr, &blocks));
  for (PetscInt b = 0; b < count; ++b) {
    PC block = nullptr;
    check(KSPGetPC(blocks[b], &block));
    check(PCSetType(block, PCILU));
    check(PCFactorSetLevels(block, levels));
  }
}

}  // namespace

Dofs::Dofs(const Cloud& cloud) : cloud_(cloud) {}

Dofs::Dofs(const Cloud& cloud, const SparseRows& phi, ShapeFunctions shapes)
    : cloud_(cloud), phi_(&phi), shapes_(std::move(shapes)) {
  std::vector<PetscInt> diagonal(cloud.owned), off_diagonal(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i)
    for (std::int64_t n = phi.row[i]; n < phi.row[i + 1]; ++n)
      ++(phi.column[n] < cloud.owned ? diagonal : off_diagonal)[i];
  matrix_ = petsc::create_matrix(cloud.comm, diagonal, off_diagonal);
  const std::vector<PetscInt> numbers(cloud.global.begin(), cloud.global.end());
  petsc::RowAdder rows(matrix_, numbers);
  for (int i = 0; i < cloud.owned; ++i) rows.add(cloud.global[i], phi.columns(i), phi.values(i));
  petsc::assemble(matrix_);
  for (petsc::Vector* vector : {&solution_, &right_, &left_}) *vector = petsc::create_vector(matrix_);
  check(KSPCreate(cloud.comm, solver_.out()));
  check(KSPSetOperators(solver_, matrix_, matrix_));
  check(KSPSetOptionsPrefix(solver_, "values_"));
  if (cloud.count <= most_rows_for_direct(cloud)) {
    factorise();
  } else {
    PC preconditioner = nullptr;
    check(KSPGetPC(solver_, &preconditioner));
    check(KSPSetType(solver_, KSPGMRES));
    check(KSPGMRESSetRestart(solver_, 60));
    check(KSPSetTolerances(solver_, 1e-14, 1e-300, PETSC_DEFAULT, 2000));
    fill_in_blocks(preconditioner, cloud.dimension < 3 ? 2 : 0);
  }
  check(KSPSetFromOptions(solver_));
}

void Dofs::factorise() {
  is_direct_ = true;
  petsc::factorise(solver_, cloud_.count, false);
}

bool Dofs::solve_linear() {
  petsc::solve(solver_, right_, solution_);
  double left = 0, size = 0;
  check(MatResidual(matrix_, right_, solution_, left_));
  check(VecNorm(left_, NORM_2, &left));
  check(VecNorm(right_, NORM_2, &size));
  return left <= 1e-10 * size;
}

void Dofs::temperatures(std::span<const double> u, std::span<double> T) const {
  if (phi_)
    phi_->apply(u, T);
  else
    std::copy_n(u.begin(), T.size(), T.begin());
}

void Dofs::solve(std::span<const double> T, std::span<double> u) {
  if (!phi_) return void(std::ranges::copy(T, u.begin()));
  // The rows of Phi add up to 1, so the mean of the temperatures needs no solution: uniform ones stay exact.
  const double mean = sum(cloud_.comm, T) / static_cast<double>(cloud_.count);
  std::vector<double> dT(T.begin(), T.end());
  double largest = 0;
  for (double& value : dT) {
    value -= mean;
    largest = std::max(largest, std::abs(value));
  }
  std::fill_n(u.begin(), cloud_.owned, mean);
  if (max(cloud_.comm, largest) > 1e-14 * std::abs(mean)) add(dT, u);
}

void Dofs::add(std::span<const double> dT, std::span<double> u) {
  if (!phi_) {
    for (std::size_t i = 0; i < dT.size(); ++i) u[i] += dT[i];
    return;
  }
  petsc::copy(dT, right_);
  bool solved = solve_linear();
  if (!solved && !is_direct_) {
    // Large graded clouds in the plane defeat the iterations.
    factorise();
    solved = solve_linear();
  }
  if (!solved)
    throw Error(Fault::numbers, "the parameters that give the temperatures of the points could not be found",
                "use a smaller support, or points that are more regular");
  const petsc::View<const double> solution(solution_);
  for (int i = 0; i < cloud_.owned; ++i) u[i] += solution.values()[i];
}

std::optional<SparseRows> Dofs::interpolation(std::span<const Vec3> x) const {
  if (!phi_) return std::nullopt;
  std::vector<double> R = shapes_.R;
  return shape_rows(cloud_, shapes_.mls, shapes_.size, R, x, {}).phi;
}

}  // namespace calor
