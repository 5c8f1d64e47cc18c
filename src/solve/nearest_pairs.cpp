#include "solve/nearest_pairs.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "base/parallel.hpp"

namespace calor {
namespace {

using petsc::check;

/// In spacings: the neighbours along the axes of a lattice, and about as many in other clouds.
constexpr double next = 1.3;
constexpr double thinner = 0.5;  ///< entries, over those of the whole matrix, that are worth it

/// Calls visit(columns, values) for row i of this rank.
template <class Visit>
void with_row(Mat matrix, PetscInt row, const Visit& visit) {
  PetscInt count = 0;
  const PetscInt* columns = nullptr;
  const PetscScalar* values = nullptr;
  check(MatGetRow(matrix, row, &count, &columns, &values));
  visit(std::span(columns, count), std::span(values, count));
  check(MatRestoreRow(matrix, row, &count, &columns, &values));
}

}  // namespace

NearestPairs::NearestPairs(const Cloud& cloud) : cloud_(cloud) {
  for (std::int32_t j = cloud.owned; j < cloud.local(); ++j) ghosts_.emplace_back(cloud.global[j], j);
  std::ranges::sort(ghosts_);
}

double NearestPairs::square(int i, PetscInt column) const {
  auto j = static_cast<std::int32_t>(column - cloud_.first);
  if (j < 0 || j >= cloud_.owned)
    j = std::ranges::lower_bound(ghosts_, column, {}, &std::pair<std::int64_t, std::int32_t>::first)->second;
  const Vec3 r = quotient(cloud_.x[j] - cloud_.x[i], cloud_.mean_metric(i, j));
  return dot(r, r);
}

bool NearestPairs::set(Mat matrix) {
  const int owned = cloud_.owned;
  const auto first = static_cast<PetscInt>(cloud_.first);
  std::vector<PetscInt> own(owned, 1), other(owned, 0), start(owned + 1, 0), columns;  // of the entries that are kept
  std::vector<double> values, row_sum(owned), moments(2 * static_cast<std::size_t>(owned));
  const std::size_t as_on_lattices = 2 * static_cast<std::size_t>(cloud_.dimension) * owned;
  columns.reserve(as_on_lattices), values.reserve(as_on_lattices);
  std::int64_t all = 0;
  bool is_alone = false;
  for (int i = 0; i < owned; ++i) {
    with_row(matrix, first + i, [&](auto column, auto value) {
      for (std::size_t n = 0; n < column.size(); ++n) {
        row_sum[i] += value[n];
        if (column[n] == first + i) continue;
        const double r = square(i, column[n]);
        moments[2 * i] += value[n] * r;
        if (r >= next * next) continue;
        moments[2 * i + 1] += value[n] * r;
        columns.push_back(column[n]), values.push_back(value[n]);
        ++(column[n] >= first && column[n] < first + owned ? own : other)[i];
      }
      all += static_cast<std::int64_t>(column.size());
    });
    start[i + 1] = static_cast<PetscInt>(columns.size());
    is_alone = is_alone || (moments[2 * i] != 0 && moments[2 * i + 1] == 0);
  }
  const auto sum = sums(cloud_.comm, moments, 2);
  all = total(cloud_.comm, all);
  const std::int64_t kept = total(cloud_.comm, static_cast<std::int64_t>(columns.size()) + owned);
  if (any(cloud_.comm, is_alone) || static_cast<double>(kept) > thinner * static_cast<double>(all)) return false;
  const double factor = sum[1] != 0 ? sum[0] / sum[1] : 1;
  for (double& value : values) value *= factor;
  if (!static_cast<Mat>(thin_)) thin_ = petsc::create_matrix(cloud_.comm, own, other);
  for (int i = 0; i < owned; ++i) {
    const PetscInt row = first + i, count = start[i + 1] - start[i];
    const double* value = values.data() + start[i];
    const double diagonal = row_sum[i] - std::accumulate(value, value + count, 0.0);
    check(MatSetValues(thin_, 1, &row, count, columns.data() + start[i], value, INSERT_VALUES));
    check(MatSetValues(thin_, 1, &row, 1, &row, &diagonal, INSERT_VALUES));
  }
  petsc::assemble(thin_);
  return true;
}

}  // namespace calor
