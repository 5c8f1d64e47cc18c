#include "solve/jacobian_operator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"

namespace calor {

using petsc::check;

/// Passes entries on and adds up their sizes.
class JacobianOperator::Sums : public JacobianEntries {
 public:
  explicit Sums(JacobianOperator& self) : self_(self) {}
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    for (const double value : values) self_.row_sums_[row] += std::abs(value);
    self_.near_.add(row, columns, values);
  }

 protected:
  JacobianOperator& self_;
};

/// Keeps them besides.
class JacobianOperator::Rest final : public Sums {
 public:
  using Sums::Sums;
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    Sums::add(row, columns, values);
    self_.row_.push_back(row);
    self_.rest_.column.insert(self_.rest_.column.end(), columns.begin(), columns.end());
    self_.rest_.value.insert(self_.rest_.value.end(), values.begin(), values.end());
    self_.rest_.close_row();
  }
};

JacobianOperator::JacobianOperator(HeatSystem& system, bool by_products)
    : system_(system), by_products_(by_products), near_(system.cloud()) {
  if (!by_products) {
    matrix_ = system.create_jacobian();
    return;
  }
  const Cloud& cloud = system.cloud();
  check(MatCreateShell(cloud.comm, cloud.owned, cloud.owned, PETSC_DETERMINE, PETSC_DETERMINE, this, products_.out()));
  using Multiply = PetscErrorCode (*)(Mat, Vec, Vec);
  const Multiply function = multiply;
  check(MatShellSetOperation(products_, MATOP_MULT, reinterpret_cast<void (*)()>(function)));
  x_.resize(cloud.local()), F_.resize(cloud.owned);
  for (std::int32_t i = 0; i < cloud.local(); ++i)
    if (system.is_known(i)) known_.push_back(i);
}

void JacobianOperator::evaluate(double t, std::span<double> u, double capacity_factor, double rate_factor) {
  if (!by_products_) {
    if (capacity_factor == 1 && system_.jacobian_is_constant()) return add_up(t, u, rate_factor);
    return system_.jacobian(t, u, capacity_factor, rate_factor, matrix_);
  }
  row_sums_.assign(system_.cloud().owned, 0);
  rest_ = {}, row_.clear();
  Sums conduction(*this);
  Rest rest(*this);
  system_.jacobian(t, u, capacity_factor, rate_factor, conduction, rest);
  near_.finish();
  rate_factor_ = rate_factor;
  u_.assign(u.begin(), u.end());
  at_.emplace(system_.evaluation());
  at_->begin(t, u_);
  petsc::assemble(products_);  // forgets how the last one was scaled
}

void JacobianOperator::add_up(double t, std::span<double> u, double rate_factor) {
  if (!capacity_) {  // both with all entries, so that they add up entry by entry
    const Cloud& cloud = system_.cloud();
    std::vector<PetscInt> constrained;
    for (int i = 0; i < cloud.owned; ++i)
      if (!system_.is_free(i)) constrained.push_back(static_cast<PetscInt>(cloud.global[i]));
    system_.jacobian(t, u, 1, 0, matrix_);
    check(MatDuplicate(matrix_, MAT_COPY_VALUES, capacity_.out()));
    system_.jacobian(t, u, 0, 1, matrix_);
    check(MatSetOption(matrix_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
    check_collective(cloud.comm, CallSite::current());
    check(MatZeroRows(matrix_, static_cast<PetscInt>(constrained.size()), constrained.data(), 0, nullptr, nullptr));
    check(MatDuplicate(matrix_, MAT_COPY_VALUES, rate_.out()));
  }
  check(MatCopy(capacity_, matrix_, SAME_NONZERO_PATTERN));
  check(MatAXPY(matrix_, rate_factor, rate_, SAME_NONZERO_PATTERN));
}

PetscErrorCode JacobianOperator::multiply(Mat matrix, Vec x, Vec y) {
  return petsc::callback([&] {
    JacobianOperator* self = nullptr;
    check(MatShellGetContext(matrix, &self));
    const petsc::View<const double> from(x);
    const petsc::View<double> to(y);
    self->multiply(from.values(), to.values());
  });
}

void JacobianOperator::multiply(std::span<const double> x, std::span<double> y) {
  const Cloud& cloud = system_.cloud();
  std::ranges::copy(x, x_.begin());
  cloud.halo.update(x_);
  std::ranges::fill(y, 0);
  for (std::size_t n = 0; n < row_.size(); ++n) y[row_[n]] += rest_.times(n, x_);
  for (const std::int32_t i : known_) x_[i] = 0;
  std::ranges::fill(F_, 0);
  collective_try(cloud.comm, [&] { system_.discretisation().conduction->add_product(*at_, x_, F_); });
  for (int i = 0; i < cloud.owned; ++i)
    if (system_.is_free(i)) y[i] -= rate_factor_ * F_[i];
}

std::vector<double> JacobianOperator::row_sums() const {
  if (by_products_) return row_sums_;
  std::vector<double> sums(system_.cloud().owned);
  PetscInt row = 0;
  check(MatGetOwnershipRange(matrix_, &row, nullptr));
  for (double& sum : sums) {
    PetscInt count = 0;
    const PetscScalar* values = nullptr;
    check(MatGetRow(matrix_, row, &count, nullptr, &values));
    for (PetscInt n = 0; n < count; ++n) sum += std::abs(values[n]);
    check(MatRestoreRow(matrix_, row++, &count, nullptr, &values));
  }
  return sums;
}

template <class Change>
void JacobianOperator::change(const Change& change) {
  change(matrix());
  if (by_products_) change(static_cast<Mat>(products_));
}

void JacobianOperator::scale(double factor) {
  change([&](Mat J) { check(MatScale(J, factor)); });
}

void JacobianOperator::scale(Vec rows, Vec columns) {
  change([&](Mat J) { check(MatDiagonalScale(J, rows, columns)); });
}

void JacobianOperator::add_to_diagonal(std::span<const double> values) {
  const petsc::Vector diagonal = petsc::create_vector(matrix());
  petsc::copy(values, diagonal);
  change([&](Mat J) { check(MatDiagonalSet(J, diagonal, ADD_VALUES)); });
}

}  // namespace calor
