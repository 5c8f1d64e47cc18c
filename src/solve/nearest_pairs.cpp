#include "solve/nearest_pairs.hpp"

#include <algorithm>
#include <utility>

#include "base/parallel.hpp"

namespace calor {
namespace {

using petsc::check;

/// In spacings: the neighbours along the axes of a lattice, and about as many in other clouds.
constexpr double next = 1.3;
constexpr double thinner = 0.5;  ///< entries, over those of the whole matrix, that are worth it

}  // namespace

NearestPairs::NearestPairs(const Cloud& cloud) : cloud_(cloud), thin_(petsc::create_matrix(cloud.comm, cloud.owned)) {
  for (std::int32_t j = cloud.owned; j < cloud.local(); ++j) ghosts_.emplace_back(cloud.global[j], j);
  std::ranges::sort(ghosts_);
}

void NearestPairs::begin() {
  if (!rows_.empty()) return;
  rows_.resize(cloud_.owned);
  near_.reserve(2 * static_cast<std::size_t>(cloud_.dimension) * cloud_.owned);  // as on lattices
}

void NearestPairs::add(int row, std::span<const std::int32_t> columns, std::span<const double> values) {
  begin();
  Row& r = rows_[row];
  for (std::size_t n = 0; n < columns.size(); ++n) {
    r.sum += values[n];
    if (columns[n] == row) {
      r.diagonal += values[n];
      continue;
    }
    ++given_;
    const double distance = cloud_.square_in_spacings(row, columns[n]), moment = values[n] * distance;
    r.moment += moment;
    if (distance >= next * next) continue;
    r.near_moment += moment;
    near_.push_back({row, columns[n], values[n]});
  }
}

void NearestPairs::clear() {
  rows_ = std::vector<Row>(), near_ = std::vector<Entry>();  // {} would keep their memory
  given_ = 0;
}

void NearestPairs::set_pattern() {
  std::vector<PetscInt> own(cloud_.owned, 1), other(cloud_.owned, 0);
  for (const Entry& e : near_) ++(e.column < cloud_.owned ? own : other)[e.row];
  petsc::reserve(thin_, own, other);
}

void NearestPairs::finish() {
  begin();
  std::vector<double> moments;
  moments.reserve(2 * rows_.size());
  for (const Row& r : rows_) moments.push_back(r.moment), moments.push_back(r.near_moment);
  const auto sum = sums(cloud_.comm, moments, 2);
  const double factor = sum[1] != 0 ? sum[0] / sum[1] : 1;
  if (std::exchange(has_pattern_, true))
    check(MatZeroEntries(thin_));
  else
    set_pattern();
  const auto first = static_cast<PetscInt>(cloud_.first);
  std::vector<PetscInt> columns;
  std::vector<double> values;
  for (std::size_t n = 0; n < near_.size();) {  // PETSc takes the entries of a row together
    const std::int32_t i = near_[n].row;
    columns.clear(), values.clear();
    for (; n < near_.size() && near_[n].row == i; ++n) {
      columns.push_back(static_cast<PetscInt>(cloud_.global[near_[n].column]));
      values.push_back(rows_[i].is_alone() ? 0 : factor * near_[n].value);
      rows_[i].sum -= values.back();
    }
    const PetscInt row = first + i;
    check(
        MatSetValues(thin_, 1, &row, static_cast<PetscInt>(columns.size()), columns.data(), values.data(), ADD_VALUES));
  }
  for (int i = 0; i < cloud_.owned; ++i) {
    const double diagonal = rows_[i].is_alone() ? rows_[i].diagonal : rows_[i].sum;
    check(MatSetValue(thin_, first + i, first + i, diagonal, ADD_VALUES));
  }
  petsc::assemble(thin_);
  clear();
}

bool NearestPairs::set(Mat matrix) {
  const auto first = static_cast<PetscInt>(cloud_.first);
  std::vector<std::int32_t> local;
  begin();
  for (int i = 0; i < cloud_.owned; ++i) {
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(matrix, first + i, &count, &columns, &values));
    local.clear();
    for (const PetscInt column : std::span(columns, count)) {
      const auto j = static_cast<std::int32_t>(column - first);
      const bool is_own = j >= 0 && j < cloud_.owned;
      using Ghost = std::pair<std::int64_t, std::int32_t>;
      local.push_back(is_own ? j : std::ranges::lower_bound(ghosts_, column, {}, &Ghost::first)->second);
    }
    add(i, local, std::span(values, count));
    check(MatRestoreRow(matrix, first + i, &count, &columns, &values));
  }
  const auto kept = static_cast<double>(total(cloud_.comm, static_cast<std::int64_t>(near_.size()) + cloud_.owned));
  const auto all = static_cast<double>(total(cloud_.comm, given_ + cloud_.owned));
  const bool is_alone = std::ranges::any_of(rows_, &Row::is_alone);
  if (any(cloud_.comm, is_alone) || kept > thinner * all) {
    clear();
    return false;
  }
  finish();
  return true;
}

}  // namespace calor
