#include "conduction/line_stiffness.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace calor {

LineStiffness::LineStiffness(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g, bool held) {
  std::vector<PetscInt> number(cloud.global.begin(), cloud.global.end()), diagonal(cloud.owned), off_diagonal;
  for (int i = 0; i < cloud.owned; ++i)
    diagonal[i] = static_cast<PetscInt>(1 + neighbours.row[i + 1] - neighbours.row[i]);
  off_diagonal = diagonal;
  for (int i = 0; i < cloud.owned; ++i) diagonal[i] = std::min<PetscInt>(diagonal[i], cloud.owned);
  matrix_ = petsc::create_matrix(cloud.comm, diagonal, off_diagonal);
  petsc::check(MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE));
  if (!held)
    for (PetscInt& n : number)
      if (n == 0) n = -1;  // PETSc skips it

  petsc::RowAdder rows(matrix_, number);
  constexpr double lift = 1e-13;  // of the diagonal: where a crack cuts the line, one half of it hangs on nothing
  std::vector<std::int32_t> columns;
  std::vector<double> values;
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    columns.assign(1, i), values.assign(1, 0);
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const double x = neighbours.x_ji(cloud.x, i, n).x, stiffness = g[n] * x * x;
      values[0] += stiffness;
      columns.push_back(neighbours.column[n]);
      values.push_back(-stiffness * neighbours.reflected(Vec3{1, 0, 0}, n).x);
    }
    values[0] *= 1 + lift;
    largest = std::max(largest, values[0]);
    if (number[i] >= 0) {
      rows.add(number[i], columns, values);
    } else {
      petsc::check(MatSetValue(matrix_, 0, 0, values[0], ADD_VALUES));
    }
  }
  petsc::assemble(matrix_);
  petsc::check(MatScale(matrix_, 1 / petsc::unit_of(max(cloud.comm, largest))));  // a preconditioner has no unit
  work_ = petsc::create_vector(matrix_);
  petsc::check(KSPCreate(cloud.comm, solver_.out()));
  petsc::check(KSPSetOperators(solver_, matrix_, matrix_));
  petsc::factorise(solver_, cloud.count, true);
}

void LineStiffness::solve(std::span<const double> r, std::span<double> z) const {
  std::vector<double> x(z.size() / 3);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = r[3 * i];
  petsc::copy(x, work_);
  petsc::solve(solver_, work_, work_);
  petsc::copy(work_, x);
  for (std::size_t i = 0; i < x.size(); ++i) z[3 * i] = x[i], z[3 * i + 1] = z[3 * i + 2] = 0;
}

}  // namespace calor
