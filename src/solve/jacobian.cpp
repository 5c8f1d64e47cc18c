// The Jacobian of the heat system as a matrix.
#include <algorithm>

#include "base/parallel.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// Passes factor * entries on: of points of one role, without columns of degrees of freedom that are known.
class HeatSystem::Entries final : public JacobianEntries {
 public:
  Entries(const HeatSystem& system, Role role, double factor, JacobianEntries& rows)
      : system_(system), role_(role), factor_(factor), rows_(rows) {}

  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    add_scaled(row, columns, values, factor_);
  }
  void add_nodal(int row, double by_T) override {
    if (system_.role_[row] != role_) return;
    if (!system_.discretisation_.dofs->are_temperatures()) {
      const SparseRows& phi = system_.discretisation_.dofs->phi();
      return add_scaled(row, phi.columns(row), phi.values(row), factor_ * by_T);
    }
    rows_.add_nodal(row, factor_ * by_T);
  }

 private:
  void add_scaled(int row, std::span<const std::int32_t> columns, std::span<const double> values, double factor) {
    if (system_.role_[row] != role_) return;
    columns_.resize(columns.size()), values_.resize(columns.size());
    std::size_t count = 0;  // no branch: an entry is kept by moving on
    for (std::size_t n = 0; n < columns.size(); ++n) {
      columns_[count] = columns[n], values_[count] = factor * values[n];
      count += !system_.is_known_[columns[n]];
    }
    rows_.add(row, std::span(columns_).first(count), std::span(values_).first(count));
  }

  const HeatSystem& system_;
  Role role_;
  double factor_;
  JacobianEntries& rows_;
  std::vector<std::int32_t> columns_;
  std::vector<double> values_;
};

namespace {

/// Adds entries to a matrix.
class MatrixRows final : public JacobianEntries {
 public:
  MatrixRows(const Cloud& cloud, Mat matrix)
      : number_(cloud.global.begin(), cloud.global.end()), rows_(matrix, number_) {}
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    rows_.add(number_[row], columns, values);
  }

 private:
  std::vector<PetscInt> number_;
  petsc::RowAdder rows_;
};

}  // namespace

petsc::Matrix HeatSystem::create_jacobian() const {
  std::vector<PetscInt> diagonal(cloud_.owned, 1), off_diagonal(cloud_.owned, 0);
  const auto count = [&](int i, std::span<const std::int32_t> columns) {
    for (std::int32_t j : columns)
      if (j != i && !is_known_[j]) ++(j < cloud_.owned ? diagonal : off_diagonal)[i];
  };
  std::vector<std::int32_t> buffer;
  for (int i = 0; i < cloud_.owned; ++i)
    if (role_[i] == Role::free) count(i, discretisation_.conduction->coupled(i, buffer));
  for (const auto& constraint : discretisation_.constraints)
    for (std::size_t n = 0; n < constraint->points().size(); ++n)
      count(constraint->points()[n], constraint->coupled(n));
  petsc::Matrix J = petsc::create_matrix(cloud_.comm, diagonal, off_diagonal);
  if (jacobian_is_symmetric()) {
    petsc::check(MatSetOption(J, MAT_SYMMETRIC, PETSC_TRUE));
    petsc::check(MatSetOption(J, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  }
  return J;
}

void HeatSystem::jacobian(double t, std::span<double> u, double capacity_factor, double rate_factor, Mat J) {
  assemble(t, u, capacity_factor, rate_factor, false, J);
}

void HeatSystem::assemble(double t, std::span<double> u, double capacity_factor, double rate_factor, bool frozen,
                          Mat J) {
  petsc::check(MatZeroEntries(J));
  MatrixRows rows(cloud_, J);
  give_jacobian(t, u, capacity_factor, rate_factor, frozen, rows, rows);
  petsc::assemble(J);
}

void HeatSystem::give_jacobian(double t, std::span<double> u, double capacity_factor, double rate_factor, bool frozen,
                               JacobianEntries& conduction, JacobianEntries& rest) {
  cloud_.halo.update(u);
  at_->begin(t, u, frozen);
  collective_try(cloud_.comm, [&] {
    Entries pairs(*this, Role::free, -rate_factor, conduction), rates(*this, Role::free, -rate_factor, rest);
    for (HeatTerm* term : terms_) term->add_jacobian(*at_, term == discretisation_.conduction.get() ? pairs : rates);
    if (capacity_factor != 0) {
      Entries capacities(*this, Role::free, capacity_factor, rest);
      discretisation_.capacity->add_jacobian(*at_, capacities);
    }
    for (const auto& constraint : discretisation_.constraints) {
      Entries rows(*this, constraint->is_massless() ? Role::massless : Role::prescribed, -1, rest);
      constraint->add_jacobian(*at_, rows);
    }
  });
}

bool HeatSystem::jacobian_is_constant() const {
  return !material().conductivity_depends_on_T() && !material().conductivity_depends_on_time() &&
         !material().capacity_depends_on_T() &&
         std::ranges::all_of(terms_, [](const HeatTerm* term) { return term->traits().is_constant; });
}

bool HeatSystem::frozen_jacobian_is_symmetric() const {
  return std::ranges::all_of(terms_, [](const HeatTerm* term) { return term->traits().is_symmetric; }) &&
         std::ranges::all_of(discretisation_.constraints, [](const auto& c) { return c->traits().is_symmetric; });
}

bool HeatSystem::jacobian_is_symmetric() const {
  return frozen_jacobian_is_symmetric() && !material().conductivity_depends_on_T();
}

}  // namespace calor
