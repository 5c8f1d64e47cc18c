#include "solve/wall_rows.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace calor {
namespace {

/// For every facet of the term its part of the area that its point has on the same face.
std::vector<double> shares_of_faces(const Cloud& cloud, const SurfaceTerm& term) {
  std::vector<double> share(term.point.size(), term.is_plate ? 0 : 1);
  if (term.is_plate) return share;  // what goes through the cell of a wall point, which holds no heat, is left out
  std::vector<char> used(cloud.facets.size());
  for (std::size_t p = 0; p < term.point.size(); ++p) {
    const auto facets = std::ranges::equal_range(cloud.facets, term.point[p], {}, &Facet::point);
    const auto mine = std::ranges::find_if(
        facets, [&](const Facet& facet) { return facet.area == term.area[p] && !used[&facet - cloud.facets.data()]; });
    if (mine == facets.end()) continue;
    used[&*mine - cloud.facets.data()] = 1;
    double face_area = 0;
    for (const Facet& facet : facets)
      if (facet.face == mine->face) face_area += facet.area;
    share[p] = mine->area / face_area;
  }
  return share;
}

}  // namespace

AlgebraicWalls::AlgebraicWalls(const Cloud& cloud, const WallRows& rows, const std::vector<SurfaceTerm>& fluxes,
                               std::vector<char> active)
    : cloud_(cloud), rows_(rows), active_(std::move(active)), area_(rows.point.size()) {
  for (const Facet& facet : cloud.facets) {
    const auto row = std::ranges::lower_bound(rows.point, facet.point);
    if (row != rows.point.end() && *row == facet.point) area_[row - rows.point.begin()] += facet.area;
  }
  for (const SurfaceTerm& term : fluxes) share_.push_back(shares_of_faces(cloud, term));

  const auto count = static_cast<PetscInt>(std::ranges::count(active_, 1));
  std::vector<double> number(cloud.local(), -1);
  double next = static_cast<double>(offset(cloud.comm, count));
  for (std::size_t n = 0; n < active_.size(); ++n)
    if (active_[n]) number[rows.point[n]] = next++;
  cloud.halo.update(number);
  number_.assign(number.begin(), number.end());

  int widest = 1;
  for (std::size_t n = 0; n < active_.size(); ++n)
    widest = std::max(widest, static_cast<int>(rows.row[n + 1] - rows.row[n]) + 1);
  MatCreateAIJ(cloud.comm, count, count, PETSC_DETERMINE, PETSC_DETERMINE, widest, nullptr, widest, nullptr, &matrix_);
  MatCreateVecs(matrix_, &change_, &right_);
  KSPCreate(cloud.comm, &solver_);
  KSPSetOperators(solver_, matrix_, matrix_);
  KSPSetType(solver_, KSPPREONLY);
  PC preconditioner;
  KSPGetPC(solver_, &preconditioner);
  PCSetType(preconditioner, PCLU);
  if (size_of(cloud.comm) > 1) PCFactorSetMatSolverType(preconditioner, MATSOLVERMUMPS);
  KSPSetOptionsPrefix(solver_, "wall_");
  KSPSetFromOptions(solver_);
}

AlgebraicWalls::~AlgebraicWalls() {
  KSPDestroy(&solver_);
  VecDestroy(&change_);
  VecDestroy(&right_);
  MatDestroy(&matrix_);
}

void AlgebraicWalls::residual(std::span<const double> k, std::span<const double> T, std::span<const double> exchange,
                              std::span<double> R) const {
  for (std::size_t n = 0; n < rows_.point.size(); ++n) {
    if (!active_[n]) continue;
    const int i = rows_.point[n];
    R[i] = area_[n] * (exchange[i] - k[i] * difference(n, T));
  }
}

void AlgebraicWalls::add_jacobian(const Conductivity& k, std::span<const double> T,
                                  std::span<const double> exchange_derivative, JacobianEntries& J) const {
  std::vector<std::int32_t> columns;
  std::vector<double> values;
  for (std::size_t n = 0; n < rows_.point.size(); ++n) {
    if (!active_[n]) continue;
    const int i = rows_.point[n];
    columns.clear(), values.clear();
    double diagonal = exchange_derivative[i];
    if (!k.dk_dT.empty()) diagonal -= k.dk_dT[i] * difference(n, T);
    for (std::int64_t m = rows_.row[n]; m < rows_.row[n + 1]; ++m) {
      const double value = k.k[i] * rows_.weight[m];
      columns.push_back(rows_.column[m]);
      values.push_back(-area_[n] * value);
      diagonal += value;
    }
    columns.push_back(i);
    values.push_back(area_[n] * diagonal);
    J.add(i, columns, values);
  }
}

double AlgebraicWalls::newton_step(const Conductivity& k, std::span<double> T, std::span<const double> exchange,
                                   std::span<const double> exchange_derivative, bool k_is_fixed) {
  class Entries final : public JacobianEntries {
   public:
    Entries(Mat matrix, const std::vector<PetscInt>& number) : matrix_(matrix), number_(number) {}
    void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
      numbers_.clear();
      for (std::int32_t j : columns) numbers_.push_back(number_[j]);  // PETSc skips the -1 of other points
      MatSetValues(matrix_, 1, &number_[row], static_cast<PetscInt>(columns.size()), numbers_.data(), values.data(),
                   ADD_VALUES);
    }

   private:
    Mat matrix_;
    const std::vector<PetscInt>& number_;
    std::vector<PetscInt> numbers_;
  };

  const bool same_derivative = std::ranges::equal(assembled_with_, exchange_derivative);
  if (!is_assembled_ || !k_is_fixed || any(cloud_.comm, !same_derivative)) {
    MatZeroEntries(matrix_);
    Entries entries(matrix_, number_);
    add_jacobian(k, T, exchange_derivative, entries);
    MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY);
    MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY);
    assembled_with_.assign(exchange_derivative.begin(), exchange_derivative.end());
    is_assembled_ = true;
  }

  double* right = nullptr;
  VecGetArray(right_, &right);
  std::size_t m = 0;
  for (std::size_t n = 0; n < rows_.point.size(); ++n) {
    const int i = rows_.point[n];
    if (active_[n]) right[m++] = area_[n] * (k.k[i] * difference(n, T) - exchange[i]);
  }
  VecRestoreArray(right_, &right);
  KSPSolve(solver_, right_, change_);

  const double* change = nullptr;
  VecGetArrayRead(change_, &change);
  double largest = 0;
  m = 0;
  for (std::size_t n = 0; n < rows_.point.size(); ++n) {
    if (!active_[n]) continue;
    T[rows_.point[n]] += change[m];
    largest = std::max(largest, std::abs(change[m++]));
  }
  VecRestoreArrayRead(change_, &change);
  return max(cloud_.comm, largest);
}

double AlgebraicWalls::difference(std::size_t n, std::span<const double> T) const {
  double sum = 0;
  for (std::int64_t m = rows_.row[n]; m < rows_.row[n + 1]; ++m)
    sum += rows_.weight[m] * (T[rows_.column[m]] - T[rows_.point[n]]);
  return sum;
}

}  // namespace calor
