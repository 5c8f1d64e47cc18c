// The Jacobian of the heat system as a matrix.
#include <algorithm>

#include "base/parallel.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// Adds factor * entries to a matrix: of points of one role, without columns of degrees of freedom that are known.
class HeatSystem::Entries final : public JacobianEntries {
 public:
  Entries(const HeatSystem& system, Role role, double factor, Mat matrix)
      : system_(system),
        role_(role),
        factor_(factor),
        matrix_(matrix),
        number_(system.cloud_.local()),
        rows_(matrix, number_) {
    for (std::size_t i = 0; i < number_.size(); ++i)  // PETSc skips -1
      number_[i] = system.is_known_[i] ? -1 : static_cast<PetscInt>(system.cloud_.global[i]);
  }

  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    add_scaled(row, columns, values, factor_);
  }
  void add_nodal(int row, double by_T) override {
    if (system_.role_[row] != role_) return;
    if (!system_.discretisation_.dofs->are_temperatures()) {
      const SparseRows& phi = system_.discretisation_.dofs->phi();
      return add_scaled(row, phi.columns(row), phi.values(row), factor_ * by_T);
    }
    const auto number = static_cast<PetscInt>(system_.cloud_.global[row]);
    petsc::check(MatSetValue(matrix_, number, number, factor_ * by_T, ADD_VALUES));
  }

 private:
  void add_scaled(int row, std::span<const std::int32_t> columns, std::span<const double> values, double factor) {
    if (system_.role_[row] == role_) rows_.add(system_.cloud_.global[row], columns, values, factor);
  }

  const HeatSystem& system_;
  Role role_;
  double factor_;
  Mat matrix_;
  std::vector<PetscInt> number_;
  petsc::RowAdder rows_;
};

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
  cloud_.halo.update(u);
  at_->begin(t, u, frozen);
  collective_try(cloud_.comm, [&] {
    petsc::check(MatZeroEntries(J));
    Entries rates(*this, Role::free, -rate_factor, J);
    for (HeatTerm* term : terms_) term->add_jacobian(*at_, rates);
    if (capacity_factor != 0) {
      Entries capacities(*this, Role::free, capacity_factor, J);
      discretisation_.capacity->add_jacobian(*at_, capacities);
    }
    for (const auto& constraint : discretisation_.constraints) {
      Entries rows(*this, constraint->is_massless() ? Role::massless : Role::prescribed, -1, J);
      constraint->add_jacobian(*at_, rows);
    }
  });
  petsc::assemble(J);
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
