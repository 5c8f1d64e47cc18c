#include "solve/aggregates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/parallel.hpp"

namespace calor {

using petsc::check;

namespace {

constexpr double weak = 0.25;  ///< coupling along an axis, over the strongest, that is no reason to coarsen

/// How strongly rows couple along every axis, over the strongest: sum |a_ij| (distance in bins)^2. Collective.
Vec3 coupling(const MatrixRows& rows, std::span<const Bin> bins) {
  std::array<double, 3> sum = {};
  for (std::int32_t i = 0; i < rows.count(); ++i)
    rows.for_each_entry(i, [&](std::int32_t j, double a) {
      if (j == i || j >= rows.count()) return;
      for (std::size_t d = 0; d < 3; ++d)
        if (bins[i].width[d] == bins[j].width[d]) {
          const auto distance = static_cast<double>(bins[j].place[d] - bins[i].place[d]);
          sum[d] += std::abs(a) * distance * distance;
        }
    });
  const std::vector<double> all = sums(rows.comm(), sum, 3);
  const double largest = std::max({all[0], all[1], all[2]});
  return largest > 0 ? 1 / largest * Vec3{all[0], all[1], all[2]} : Vec3{};
}

/// Row numbers ordered by their aggregate, and where those of each begin.
struct Members {
  std::vector<std::int32_t> first, row;

  Members(std::span<const std::int32_t> aggregate_of, std::int32_t aggregates) : first(aggregates + 1) {
    for (const std::int32_t aggregate : aggregate_of)
      if (aggregate >= 0) ++first[aggregate + 1];
    for (std::int32_t a = 0; a < aggregates; ++a) first[a + 1] += first[a];
    row.resize(first[aggregates]);
    std::vector<std::int32_t> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < aggregate_of.size(); ++i)
      if (aggregate_of[i] >= 0) row[next[aggregate_of[i]]++] = static_cast<std::int32_t>(i);
  }
};

}  // namespace

std::vector<Bin> bins_of(const Cloud& cloud) {
  std::vector<Bin> bins(cloud.owned);
  for (std::size_t d = 0; d < 3; ++d) {
    double low = std::numeric_limits<double>::infinity(), least = low;
    for (int i = 0; i < cloud.owned; ++i) {
      low = std::min(low, cloud.x[i][d]);
      least = std::min(least, cloud.metric[i][d]);
    }
    low = min(cloud.comm, low), least = min(cloud.comm, least);
    for (int i = 0; i < cloud.owned; ++i) {
      const int width = static_cast<int>(std::lround(std::log2(cloud.metric[i][d] / least)));
      bins[i].width[d] = width;
      // Lattices start at `low`: a quarter of a bin keeps their points clear of the limits of bins.
      bins[i].place[d] = static_cast<std::int64_t>(std::floor((cloud.x[i][d] - low) / std::ldexp(least, width) + 0.25));
    }
  }
  return bins;
}

MatrixRows::Block::Block(Mat matrix, std::int32_t first) : first_column(first) {
  PetscInt count = 0;
  PetscBool done = PETSC_FALSE;
  check(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &count, &row, &column, &done));
  check(MatSeqAIJGetArrayRead(matrix, &value));
}

MatrixRows::MatrixRows(Mat matrix) : comm_(PetscObjectComm(reinterpret_cast<PetscObject>(matrix))) {
  PetscInt rows = 0;
  check(MatGetLocalSize(matrix, &rows, nullptr));
  count_ = static_cast<std::int32_t>(rows);
  number_rows();
  if (size_of(comm_) == 1) {
    own_ = Block(matrix, 0);
    return;
  }
  Mat own = nullptr, other = nullptr;
  const PetscInt* numbers = nullptr;
  PetscInt count = 0;
  check(MatMPIAIJGetSeqAIJ(matrix, &own, &other, &numbers));
  check(MatGetSize(other, nullptr, &count));
  others_.assign(numbers, numbers + count);
  own_ = Block(own, 0), other_ = Block(other, count_);
  connect();
}

MatrixRows::MatrixRows(const MatrixRows& fine, std::span<const std::int32_t> aggregate_of, std::int32_t aggregates,
                       double factor)
    : comm_(fine.comm_), count_(aggregates) {
  number_rows();
  std::vector<PetscInt> number(fine.columns());  // of the aggregates of the columns
  for (std::int32_t i = 0; i < fine.count_; ++i)
    number[i] = aggregate_of[i] < 0 ? -1 : static_cast<PetscInt>(first_ + aggregate_of[i]);
  fine.update(MPIU_INT, number);
  for (const PetscInt other : std::span(number).subspan(fine.count_))
    if (other >= 0) others_.push_back(other);
  connect();
  std::vector<std::int32_t> column_of(number.size());
  for (std::size_t j = 0; j < number.size(); ++j) column_of[j] = number[j] < 0 ? -1 : local(number[j]);

  const Members members(aggregate_of, aggregates);
  std::vector<double> sum(columns());
  std::vector<PetscInt> seen_by(sum.size(), -1), columns;
  row_ = {0};
  row_.reserve(count_ + 1);
  for (std::int32_t a = 0; a < count_; ++a) {
    columns.clear();
    for (std::int32_t m = members.first[a]; m < members.first[a + 1]; ++m)
      fine.for_each_entry(members.row[m], [&](std::int32_t j, double value) {
        const std::int32_t column = column_of[j];
        if (column < 0) return;
        if (std::exchange(seen_by[column], a) != a) columns.push_back(column), sum[column] = 0;
        sum[column] += value;
      });
    std::ranges::sort(columns);
    for (const std::int32_t column : columns) column_.push_back(column), value_.push_back(factor * sum[column]);
    row_.push_back(static_cast<PetscInt>(column_.size()));
  }
  own_.row = row_.data(), own_.column = column_.data(), own_.value = value_.data();
}

void MatrixRows::number_rows() {
  check_collective(comm_, CallSite::current());
  check(PetscLayoutCreateFromSizes(comm_, count_, PETSC_DECIDE, 1, layout_.out()));
  PetscInt first = 0, count = 0;
  check(PetscLayoutGetRange(layout_, &first, nullptr));
  check(PetscLayoutGetSize(layout_, &count));
  first_ = first, global_count_ = count;
}

/// Sorts others_ and makes exchange_.
void MatrixRows::connect() {
  std::ranges::sort(others_);
  others_.erase(std::unique(others_.begin(), others_.end()), others_.end());
  if (size_of(comm_) == 1) return;
  const std::vector<PetscInt> numbers(others_.begin(), others_.end());
  check(PetscSFCreate(comm_, exchange_.out()));
  check(PetscSFSetGraphLayout(exchange_, layout_, static_cast<PetscInt>(numbers.size()), nullptr, PETSC_COPY_VALUES,
                              numbers.data()));
}

std::int32_t MatrixRows::local(std::int64_t column) const {
  if (column >= first_ && column < first_ + count_) return static_cast<std::int32_t>(column - first_);
  return count_ + static_cast<std::int32_t>(std::ranges::lower_bound(others_, column) - others_.begin());
}

std::vector<double> MatrixRows::diagonal() const {
  std::vector<double> diagonal(count_);
  for (std::int32_t i = 0; i < count_; ++i)
    for_each_entry(i, [&](std::int32_t j, double a) { diagonal[i] = j == i ? a : diagonal[i]; });
  return diagonal;
}

bool MatrixRows::is_coupled(std::int32_t i) const {
  for (const Block* block : {&own_, &other_})
    for (PetscInt n = block->begin(i); n < block->begin(i + 1); ++n)
      if (block->value[n] != 0 && block->first_column + block->column[n] != i) return true;
  return false;
}

void MatrixRows::drop_entries() {
  own_ = {}, other_ = {};
  row_ = std::vector<PetscInt>(), column_ = std::vector<PetscInt>(), value_ = std::vector<double>();
}

petsc::Matrix MatrixRows::assembled() const {
  std::vector<PetscInt> own(count_), other(count_);
  for (std::int32_t i = 0; i < count_; ++i)
    for_each_entry(i, [&](std::int32_t j, double) { ++(j < count_ ? own : other)[i]; });
  petsc::Matrix matrix = petsc::create_matrix(comm_, own, other);
  for (std::int32_t i = 0; i < count_; ++i)
    for_each_entry(i, [&](std::int32_t j, double value) {
      const std::int64_t column = j < count_ ? first_ + j : others_[j - count_];
      check(
          MatSetValue(matrix, static_cast<PetscInt>(first_ + i), static_cast<PetscInt>(column), value, INSERT_VALUES));
    });
  petsc::assemble(matrix);
  return matrix;
}

std::vector<std::int32_t> aggregate(const MatrixRows& rows, std::vector<Bin>& bins) {
  const Vec3 strength = coupling(rows, bins);
  // Aggregates as their rows come, then in the order of their bins.
  std::map<Bin, std::int32_t> known;
  std::vector<std::int32_t> aggregate_of(rows.count(), -1);
  for (std::int32_t i = 0, last = -1; i < rows.count(); ++i) {
    for (std::size_t d = 0; d < 3; ++d)
      if (strength[d] > weak) bins[i].place[d] >>= 1;
    if (!rows.is_coupled(i)) continue;
    aggregate_of[i] = last >= 0 && bins[i] == bins[last]
                          ? aggregate_of[last]
                          : known.try_emplace(bins[i], static_cast<std::int32_t>(known.size())).first->second;
    last = i;
  }
  std::vector<Bin> aggregates;
  std::vector<std::int32_t> place(known.size());
  for (const auto& [bin, aggregate] : known) {
    place[aggregate] = static_cast<std::int32_t>(aggregates.size());
    aggregates.push_back(bin);
  }
  for (std::int32_t& aggregate : aggregate_of)
    if (aggregate >= 0) aggregate = place[aggregate];
  bins = std::move(aggregates);
  return aggregate_of;
}

}  // namespace calor
