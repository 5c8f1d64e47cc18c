// The Jacobian of the heat system and the bounds of its spectrum.
#include <petscksp.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "solve/heat_system_parts.hpp"

namespace calor {
namespace {

/// Adds factor * values to a matrix. Rows of other kinds than `wanted` are left out, and columns of prescribed points
/// where their unknowns are known.
class ScaledEntries final : public JacobianEntries {
 public:
  ScaledEntries(const Cloud& cloud, const std::vector<Role>& role, Role wanted, bool prescribed_is_known, double factor,
                Mat matrix)
      : role_(role), wanted_(wanted), factor_(factor), matrix_(matrix), number_(cloud.local()) {
    for (int i = 0; i < cloud.local(); ++i) {
      const bool skip = prescribed_is_known && role[i] == Role::prescribed;
      number_[i] = skip ? -1 : static_cast<PetscInt>(cloud.global[i]);  // PETSc skips -1
    }
  }

  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    if (role_[row] != wanted_) return;
    numbers_.clear(), scaled_.clear();
    for (std::int32_t j : columns) numbers_.push_back(number_[j]);
    for (double value : values) scaled_.push_back(factor_ * value);
    MatSetValues(matrix_, 1, &number_[row], static_cast<PetscInt>(columns.size()), numbers_.data(), scaled_.data(),
                 ADD_VALUES);
  }

 private:
  const std::vector<Role>& role_;
  Role wanted_;
  double factor_;
  Mat matrix_;
  std::vector<PetscInt> number_, numbers_;
  std::vector<double> scaled_;
};

}  // namespace

Mat HeatSystem::create_jacobian() const {
  const Parts& parts = *parts_;
  const Cloud& cloud = parts.cloud;
  const bool prescribed_is_known = !parts.point_values;
  std::vector<PetscInt> diagonal(cloud.owned, 1), off_diagonal(cloud.owned, 0);
  const auto count = [&](int i, std::span<const std::int32_t> columns) {
    for (std::int32_t j : columns) {
      if (j == i || (prescribed_is_known && parts.role[j] == Role::prescribed)) continue;
      ++(j < cloud.owned ? diagonal : off_diagonal)[i];
    }
  };
  for (int i = 0; i < cloud.owned; ++i)
    if (parts.role[i] == Role::free || !prescribed_is_known) count(i, parts.sites->coupled(i));
  if (parts.walls) {
    const WallRows& rows = parts.walls->rows();
    for (std::size_t n = 0; n < rows.point.size(); ++n)
      if (parts.role[rows.point[n]] == Role::wall)
        count(rows.point[n], std::span(rows.column).subspan(rows.row[n], rows.row[n + 1] - rows.row[n]));
  }
  Mat J = nullptr;
  MatCreate(cloud.comm, &J);
  MatSetSizes(J, cloud.owned, cloud.owned, static_cast<PetscInt>(cloud.count), static_cast<PetscInt>(cloud.count));
  MatSetType(J, MATAIJ);
  MatSeqAIJSetPreallocation(J, 0, diagonal.data());
  MatMPIAIJSetPreallocation(J, 0, diagonal.data(), 0, off_diagonal.data());
  if (jacobian_is_symmetric()) {
    MatSetOption(J, MAT_SYMMETRIC, PETSC_TRUE);
    MatSetOption(J, MAT_SYMMETRY_ETERNAL, PETSC_TRUE);
  }
  return J;
}

void HeatSystem::jacobian(double t, std::span<double> T, double capacity_factor, double rate_factor, Mat J) const {
  assemble(t, T, capacity_factor, rate_factor, true, J);
}

void HeatSystem::assemble(double t, std::span<double> T, double capacity_factor, double rate_factor, bool exact,
                          Mat J) const {
  Parts& parts = *parts_;
  const Cloud& cloud = parts.cloud;
  cloud.halo.update(T);
  std::vector<double> C(cloud.owned), exchange(cloud.owned);
  const bool prescribed_is_known = !parts.point_values;
  if (capacity_factor != 0 && parts.is_nodal) capacity(T, C);
  collective_try(cloud.comm, [&] {
    MatZeroEntries(J);
    const Conductivity k = parts.conductivity(t, T, exact ? Parts::For::jacobian : Parts::For::bound);
    ScaledEntries free_rows(cloud, parts.role, Role::free, prescribed_is_known, -rate_factor, J);
    parts.sites->add_jacobian(k, T, free_rows);
    if (parts.images) parts.images->add_jacobian(t, k, T, free_rows);
    if (parts.penalty) parts.penalty->add_jacobian(t, T, parts.values(T), free_rows);
    parts.add_exchange_derivative(t, T, exchange);
    if (parts.walls) {
      ScaledEntries wall_rows(cloud, parts.role, Role::wall, prescribed_is_known, -rate_factor, J);
      parts.walls->add_jacobian(k, T, parts.wall_exchange(t, T, true), wall_rows);
    }
    if (!parts.is_nodal) {
      parts.add_rows(T, capacity_factor, exchange, rate_factor, J);
      return;
    }
    for (int i = 0; i < cloud.owned; ++i) {
      const auto row = static_cast<PetscInt>(cloud.global[i]);
      if (parts.role[i] == Role::prescribed)
        MatSetValue(J, row, row, 1, ADD_VALUES);
      else if (parts.role[i] == Role::free)
        MatSetValue(J, row, row, capacity_factor * C[i] - rate_factor * exchange[i], ADD_VALUES);
    }
  });
  MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY);
}

void HeatSystem::Parts::add_rows(std::span<const double> T, double capacity_factor, std::span<const double> exchange,
                                 double rate_factor, Mat J) {
  const bool prescribed_is_known = !point_values;
  ScaledEntries free_rows(cloud, role, Role::free, prescribed_is_known, 1, J);
  ScaledEntries constraints(cloud, role, Role::prescribed, false, 1, J);
  std::vector<double> scaled;
  const auto add = [&](JacobianEntries& to, int i, const SparseRows& rows, std::size_t r, double factor) {
    scaled.assign(rows.value.begin() + rows.row[r], rows.value.begin() + rows.row[r + 1]);
    for (double& value : scaled) value *= factor;
    to.add(i, {rows.column.data() + rows.row[r], scaled.size()}, scaled);
  };
  const auto add_own = [&](JacobianEntries& to, std::int32_t i, double value) { to.add(i, {&i, 1}, {&value, 1}); };

  const CellQuadrature* places = sites->capacity_quadrature();
  std::vector<double> rho_c(places ? 0 : cloud.owned);
  if (capacity_factor != 0 && places) {
    T_capacity_.resize(places->x.size()), H_capacity_.resize(places->x.size());
    places->phi.apply(T, T_capacity_);
    fields.capacity->enthalpy(T_capacity_, {}, H_capacity_);
  } else if (capacity_factor != 0) {
    material.enthalpy(values(T), {}, rho_c);
  }
  std::size_t n = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    if (role[i] == Role::prescribed) {
      if (point_values)
        add(constraints, i, point_values->phi(), i, constraint_scale[n++]);
      else
        add_own(constraints, i, 1);
      continue;
    }
    if (capacity_factor != 0 && places)
      for (std::int64_t q = places->cell[i]; q < places->cell[i + 1]; ++q)
        add(free_rows, i, places->phi, q, capacity_factor * places->volume[q] * H_capacity_[q]);
    const double own = (places ? 0 : capacity_factor * cloud.volume[i] * rho_c[i]) - rate_factor * exchange[i];
    if (point_values)
      add(free_rows, i, point_values->phi(), i, own);
    else
      add_own(free_rows, i, own);
  }
}

bool HeatSystem::jacobian_is_constant() const {
  const Parts& parts = *parts_;
  const MaterialField& material = parts.material;
  return !material.conductivity_depends_on_T() && !material.conductivity_depends_on_time() &&
         !material.capacity_depends_on_T() && parts.sites->events().empty() &&
         std::ranges::all_of(parts.conditions.fluxes,
                             [](const SurfaceTerm& term) {
                               return !term.flux->depends_on_temperature() ||
                                      (term.flux->linear_in_temperature() && !term.flux->derivative_depends_on_time());
                             }) &&
         std::ranges::none_of(parts.sources, [](const auto& source) { return source->depends_on_temperature(); });
}

bool HeatSystem::jacobian_is_symmetric() const {
  const MaterialField& material = parts_->material;
  const bool depends_on_T = material.conductivity_depends_on_T();
  return !parts_->walls && parts_->sites->symmetric(material.mean(), depends_on_T) &&
         !(material.mean() == Mean::integral && depends_on_T);
}

double HeatSystem::rate_bound(double t, std::span<double> T) const {
  Parts& parts = *parts_;
  const Cloud& cloud = parts.cloud;
  cloud.halo.update(T);
  std::vector<double> bound(cloud.owned), exchange(cloud.owned), C(cloud.owned);
  capacity(T, C);
  collective_try(cloud.comm, [&] {
    const Conductivity k = parts.conductivity(t, T, Parts::For::bound);
    parts.sites->add_row_bound(k, bound);
    if (parts.images) parts.images->add_row_bound(k, bound);
    if (parts.penalty) parts.penalty->add_row_bound(t, parts.values(T), bound);
    parts.add_exchange_derivative(t, T, exchange);
  });
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i)
    if (parts.role[i] == Role::free) largest = std::max(largest, (bound[i] + std::abs(exchange[i])) / C[i]);
  return max(cloud.comm, largest);
}

double HeatSystem::explicit_rate_bound(double t, std::span<double> T) const {
  const double bound = rate_bound(t, T);
  if (is_nodal()) return bound;
  if (parts_->explicit_over_bound == 0) parts_->explicit_over_bound = parts_->rate_of_values_over_bound();
  return parts_->explicit_over_bound * bound;
}

double HeatSystem::Parts::rate_of_values_over_bound() {
  const std::vector<double> one(k_.size(), 1.0);
  const Conductivity k{.mean = Mean::arithmetic, .k = one, .dk_dT = {}, .theta = {}};
  std::vector<double> v(cloud.owned), bound(cloud.owned), F(cloud.owned), T(cloud.local());
  sites->add_row_bound(k, bound);
  double row_sum = 0, before = 0, now = 0;
  for (int i = 0; i < cloud.owned; ++i)
    if (role[i] == Role::free) row_sum = std::max(row_sum, bound[i] / cloud.volume[i]);
  row_sum = max(cloud.comm, row_sum);
  // Power iteration from values whose neighbours differ in sign or size.
  constexpr int steps = 100;
  constexpr double settled = 1e-3, margin = 1.05;
  for (int i = 0; i < cloud.owned; ++i)
    v[i] = role[i] == Role::free ? std::sin(1.0 + 12.9898 * static_cast<double>(cloud.id[i] % 100003)) : 0;
  for (int step = 0; step < steps; ++step) {
    const double length = std::sqrt(dot(cloud.comm, v, v));
    if (!(length > 0)) break;
    for (double& value : v) value /= length;
    std::ranges::fill(T, 0);
    point_values->add(v, T);
    cloud.halo.update(std::span<double>(T));
    std::ranges::fill(F, 0);
    sites->add_rate(k, T, F);
    for (int i = 0; i < cloud.owned; ++i) v[i] = role[i] == Role::free ? -F[i] / cloud.volume[i] : 0;
    before = std::exchange(now, std::sqrt(dot(cloud.comm, v, v)));
    if (std::abs(now - before) < settled * now / steps) break;
  }
  return row_sum > 0 ? margin * now / row_sum : 1;
}

double HeatSystem::largest_rate(double t, std::span<double> T) const {
  // Lanczos on S = D^-1 C^-1/2 (-dF/dT) C^-1/2 D, where D = k^-1/2 makes the integral mean's G_ij k_j symmetric, from a
  // start vector that excites free points alone: walls are frozen.
  const Parts& parts = *parts_;
  const Cloud& cloud = parts.cloud;
  constexpr int most_steps = 200;
  constexpr double tolerance = 1e-4;
  std::vector<double> C(cloud.owned), scale(cloud.owned, 1), v(cloud.owned), before(cloud.owned), w(cloud.owned);
  capacity(T, C);
  Mat J = create_jacobian();
  assemble(t, T, 0, 1, false, J);
  if (parts.material.mean() == Mean::integral) {
    collective_try(cloud.comm, [&] {
      const Conductivity k = parts_->conductivity(t, T, Parts::For::bound);
      for (int i = 0; i < cloud.owned; ++i) scale[i] = 1 / std::sqrt(k.k[i]);
    });
  }
  for (int i = 0; i < cloud.owned; ++i) {
    const bool is_free = parts.role[i] == Role::free;
    // Neighbours differ in sign or size, as in the fastest modes; the same on any number of ranks.
    v[i] = is_free ? std::sin(1.0 + 12.9898 * static_cast<double>(cloud.id[i] % 100003)) : 0;
  }
  Vec x = nullptr, y = nullptr;
  MatCreateVecs(J, &x, &y);
  const auto multiply = [&](const std::vector<double>& from, std::vector<double>& to) {
    double* in = nullptr;
    VecGetArray(x, &in);
    for (int i = 0; i < cloud.owned; ++i)
      in[i] = parts.role[i] == Role::free ? from[i] * scale[i] / std::sqrt(C[i]) : 0;
    VecRestoreArray(x, &in);
    MatMult(J, x, y);
    const double* out = nullptr;
    VecGetArrayRead(y, &out);
    for (int i = 0; i < cloud.owned; ++i)
      to[i] = parts.role[i] == Role::free ? out[i] / (scale[i] * std::sqrt(C[i])) : 0;
    VecRestoreArrayRead(y, &out);
  };

  std::vector<double> alpha, beta;
  double largest = 0;
  double length = std::sqrt(dot(cloud.comm, v, v));
  for (int step = 0; step < most_steps && length > 0; ++step) {
    for (double& value : v) value /= length;
    multiply(v, w);
    alpha.push_back(dot(cloud.comm, v, w));
    for (int i = 0; i < cloud.owned; ++i) {
      w[i] -= alpha.back() * v[i] + (beta.empty() ? 0 : beta.back()) * before[i];
      before[i] = v[i];
      v[i] = w[i];
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> tridiagonal;
    tridiagonal.computeFromTridiagonal(Eigen::Map<Eigen::VectorXd>(alpha.data(), alpha.size()),
                                       Eigen::Map<Eigen::VectorXd>(beta.data(), beta.size()), Eigen::EigenvaluesOnly);
    const double last = largest;
    largest = tridiagonal.eigenvalues().maxCoeff();
    length = std::sqrt(dot(cloud.comm, v, v));
    if (step > 20 && largest - last < tolerance * largest * 0.01) break;
    if (length < 1e-10 * largest) break;
    beta.push_back(length);
  }
  VecDestroy(&x);
  VecDestroy(&y);
  MatDestroy(&J);
  return largest;
}

}  // namespace calor
