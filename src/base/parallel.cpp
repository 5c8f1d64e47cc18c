#include "base/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "base/error.hpp"

namespace calor {
namespace {

// Reproducible sums. Every number x is cut along fixed powers of two: its part in bin j is a whole multiple of the
// bin's unit 2^(30 j - 1074), at most 2^29 units large. Parts of one bin add up without error (in doubles within a
// block of numbers, in 64-bit integers over blocks and ranks, up to 2^34 numbers), so their sum does not depend on
// order. Three bins from the one of the largest |x| downwards are kept: what is cut off is below 2^-60 max |x| for each
// number. The cut is the pre-rounding of Demmel & Nguyen (2013), q = (C + x) - C with C = 1.5 * 2^52 units.
constexpr int bin_width = 30;
constexpr int smallest_exponent = -1074;
constexpr int bins = 69;  // the C of bin 68 is the last one below the largest double
constexpr int levels = 3;
constexpr double limit = 0x1p995;  // larger numbers, infinities and NaN are summed plainly
constexpr std::size_t block = 1024;

constexpr int exponent(int bin) { return smallest_exponent + bin_width * bin; }

// GCC and Clang lower these eight lanes to what the processor has, at any level of optimisation.
constexpr std::size_t lane_count = 8;
using Lanes = double __attribute__((vector_size(lane_count * sizeof(double))));
using Flags = std::int64_t __attribute__((vector_size(lane_count * sizeof(double))));

/// What the numbers of one rank add up to; all entries are added over the ranks.
struct BinnedSum {
  std::array<std::int64_t, bins> units{};
  std::array<std::int64_t, bins> blocks{};  ///< how many blocks had their largest number here
  std::int64_t out_of_range = 0;            ///< blocks with numbers that are not finite or beyond the limit

  /// x has n * lane_count entries.
  void add(const double* x, std::size_t n);
  double total() const;
};
static_assert(sizeof(BinnedSum) == (2 * bins + 1) * sizeof(std::int64_t));

// Never inlined: where products are summed they must be rounded first, not fused into the sum (fma).
[[gnu::noinline]] void BinnedSum::add(const double* x, std::size_t n) {
  const auto load = [x](std::size_t i, Lanes& lanes) { std::memcpy(&lanes, x + i * lane_count, sizeof(Lanes)); };
  Lanes largest{};
  Flags regular = ~Flags{};
  for (std::size_t i = 0; i < n; ++i) {
    Lanes a;
    load(i, a);
    a = a < 0 ? -a : a;
    largest = a > largest ? a : largest;
    regular &= a < limit;  // false for NaN
  }
  double m = 0;
  std::int64_t all_regular = -1;
  for (std::size_t l = 0; l < lane_count; ++l) {
    m = std::max(m, largest[l]);
    all_regular &= regular[l];
  }
  if (!all_regular) {
    ++out_of_range;
    return;
  }
  if (m == 0) return;

  // The lowest bin whose half capacity exceeds m; one bin higher, every part would be rounded to zero.
  const int above = std::ilogb(m) + 1 - (bin_width - 1) - smallest_exponent;
  const int top = std::max(levels - 1, (above + bin_width - 1) / bin_width);
  ++blocks[top];
  const double C0 = std::ldexp(1.5, exponent(top) + 52);
  const double C1 = std::ldexp(1.5, exponent(top - 1) + 52);
  const double C2 = std::ldexp(1.5, exponent(top - 2) + 52);
  Lanes s0{}, s1{}, s2{};
  for (std::size_t i = 0; i < n; ++i) {
    Lanes r;
    load(i, r);
    const Lanes q0 = (r + C0) - C0;
    s0 += q0;
    r -= q0;
    const Lanes q1 = (r + C1) - C1;
    s1 += q1;
    r -= q1;
    s2 += (r + C2) - C2;
  }
  const std::array<Lanes, levels> parts{s0, s1, s2};
  for (int level = 0; level < levels; ++level) {
    double part = 0;
    for (std::size_t l = 0; l < lane_count; ++l) part += parts[level][l];
    units[top - level] += static_cast<std::int64_t>(std::ldexp(part, -exponent(top - level)));
  }
}

double BinnedSum::total() const {
  int top = bins - 1;
  while (top >= 0 && blocks[top] == 0) --top;
  if (top < 0) return 0;
  __int128 sum = 0;  // 64 + 60 bits
  for (int level = 0; level < levels; ++level) sum = (sum << bin_width) + units[top - level];
  return std::ldexp(static_cast<double>(sum), exponent(top - levels + 1));
}

/// Sums of `columns` sequences of n numbers; fill(column, begin, count, out) writes a stretch of one of them.
template <class Fill>
std::vector<double> reproducible_sums(MPI_Comm comm, std::size_t n, int columns, const Fill& fill) {
  std::vector<BinnedSum> binned(columns);
  alignas(Lanes) std::array<double, block> x;
  for (std::size_t begin = 0; begin < n; begin += block) {
    const std::size_t count = std::min(block, n - begin);
    const std::size_t used = (count + lane_count - 1) / lane_count;
    std::fill(x.begin() + count, x.begin() + used * lane_count, 0.0);
    for (int column = 0; column < columns; ++column) {
      fill(column, begin, count, x.data());
      binned[column].add(x.data(), used);
    }
  }
  constexpr int width = sizeof(BinnedSum) / sizeof(std::int64_t);
  MPI_Allreduce(MPI_IN_PLACE, binned.data(), columns * width, MPI_INT64_T, MPI_SUM, comm);

  std::vector<double> result(columns);
  for (int column = 0; column < columns; ++column) result[column] = binned[column].total();
  if (std::none_of(binned.begin(), binned.end(), [](const BinnedSum& b) { return b.out_of_range > 0; })) return result;

  std::vector<double> plain(columns);
  for (int column = 0; column < columns; ++column) {
    for (std::size_t begin = 0; begin < n; begin += block) {
      const std::size_t count = std::min(block, n - begin);
      fill(column, begin, count, x.data());
      for (std::size_t i = 0; i < count; ++i) plain[column] += x[i];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, plain.data(), columns, MPI_DOUBLE, MPI_SUM, comm);
  for (int column = 0; column < columns; ++column) {
    if (binned[column].out_of_range > 0) result[column] = plain[column];
  }
  return result;
}

template <class T>
T reduced(MPI_Comm comm, T value, MPI_Datatype type, MPI_Op op) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, type, op, comm);
  return value;
}

void broadcast(MPI_Comm comm, int root, std::string& text) {
  auto length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, root, comm);
  text.resize(length);
  MPI_Bcast(text.data(), length, MPI_CHAR, root, comm);
}

}  // namespace

int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

int size_of(MPI_Comm comm) {
  int size = 0;
  MPI_Comm_size(comm, &size);
  return size;
}

double sum(MPI_Comm comm, std::span<const double> values) { return sums(comm, values, 1)[0]; }

std::vector<double> sums(MPI_Comm comm, std::span<const double> values, int columns) {
  if (columns == 0) return {};
  return reproducible_sums(comm, values.size() / columns, columns,
                           [&](int column, std::size_t begin, std::size_t count, double* out) {
                             const double* in = values.data() + begin * columns + column;
                             for (std::size_t i = 0; i < count; ++i) out[i] = in[i * columns];
                           });
}

double dot(MPI_Comm comm, std::span<const double> a, std::span<const double> b) {
  return reproducible_sums(comm, a.size(), 1, [&](int, std::size_t begin, std::size_t count, double* out) {
    for (std::size_t i = 0; i < count; ++i) out[i] = a[begin + i] * b[begin + i];
  })[0];
}

double max(MPI_Comm comm, double value) { return reduced(comm, value, MPI_DOUBLE, MPI_MAX); }
double min(MPI_Comm comm, double value) { return reduced(comm, value, MPI_DOUBLE, MPI_MIN); }
std::int64_t total(MPI_Comm comm, std::int64_t value) { return reduced(comm, value, MPI_INT64_T, MPI_SUM); }
bool any(MPI_Comm comm, bool value) { return reduced(comm, static_cast<int>(value), MPI_INT, MPI_MAX) != 0; }

std::int64_t offset(MPI_Comm comm, std::int64_t value) {
  std::int64_t before = 0;
  MPI_Exscan(&value, &before, 1, MPI_INT64_T, MPI_SUM, comm);
  return rank_of(comm) == 0 ? 0 : before;  // MPI leaves it undefined on the first rank
}

void collective_try(MPI_Comm comm, const std::function<void()>& work) {
  std::optional<Error> error;
  try {
    work();
  } catch (const Error& e) {
    error = e;
  } catch (const std::exception& e) {
    error = Error(Fault::numbers, e.what(), "");
  }
  const int none = size_of(comm);
  const int root = reduced(comm, error ? rank_of(comm) : none, MPI_INT, MPI_MIN);
  if (root == none) return;

  std::array<int, 3> numbers{};
  std::array<std::string, 3> texts;
  if (rank_of(comm) == root) {
    numbers = {static_cast<int>(error->fault()), error->location().line, error->location().column};
    texts = {error->location().file, error->problem(), error->cure()};
  }
  MPI_Bcast(numbers.data(), 3, MPI_INT, root, comm);
  for (std::string& text : texts) broadcast(comm, root, text);
  throw Error(static_cast<Fault>(numbers[0]), SourceLocation{texts[0], numbers[1], numbers[2]}, texts[1], texts[2]);
}

}  // namespace calor
