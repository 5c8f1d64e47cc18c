#include "base/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <numeric>
#include <optional>
#include <string_view>
#include <thread>

#include "base/error.hpp"
#include "base/simd.hpp"

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
  const auto load = [x](std::size_t i, Lanes& lanes)
                        CALOR_ALWAYS_INLINE { std::memcpy(&lanes, x + i * lane_count, sizeof(Lanes)); };
  Lanes largest{};
  Flags regular = ~Flags{};
  run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
    for (std::size_t i = 0; i < n; ++i) {
      Lanes a;
      load(i, a);
      a = a < 0 ? -a : a;
      largest = a > largest ? a : largest;
      regular &= a < limit;  // false for NaN
    }
  });
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
  std::array<Lanes, levels> parts{};
  run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
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
    parts = {s0, s1, s2};
  });
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
std::vector<double> reproducible_sums(MPI_Comm comm, std::size_t n, int columns, const Fill& fill, CallSite at) {
  check_collective(comm, at);
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
T reduced(MPI_Comm comm, T value, MPI_Datatype type, MPI_Op op, CallSite at) {
  check_collective(comm, at);
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, type, op, comm);
  return value;
}

template <class T>
void reduce_all(MPI_Comm comm, std::span<T> values, MPI_Datatype type, MPI_Op op, CallSite at) {
  check_collective(comm, at);
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), type, op, comm);
}

/// A contiguous MPI datatype of so many bytes.
class RecordType {
 public:
  explicit RecordType(std::size_t size) {
    MPI_Type_contiguous(static_cast<int>(size), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
  }
  ~RecordType() { MPI_Type_free(&type_); }
  RecordType(const RecordType&) = delete;
  RecordType& operator=(const RecordType&) = delete;
  operator MPI_Datatype() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

/// Where every rank's records begin, and where the last ones end.
std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> start(counts.size() + 1, 0);
  std::partial_sum(counts.begin(), counts.end(), start.begin() + 1);
  return start;
}

std::string text_of(const CallSite& at) {
  const std::string_view file = at.file;
  return fmt::format("{}:{} ({})", file.substr(file.rfind('/') + 1), at.line, at.function);
}

[[noreturn]] void refuse_mismatch(MPI_Comm comm, const CallSite& at) {
  constexpr std::size_t longest = 160;
  const int ranks = size_of(comm);
  std::string mine = text_of(at);
  mine.resize(longest, '\0');
  std::string all(longest * ranks, '\0');
  MPI_Allgather(mine.data(), longest, MPI_CHAR, all.data(), longest, MPI_CHAR, comm);
  std::string text = "not all ranks call the same collective function:";
  for (int r = 0; r < ranks; ++r) text += fmt::format("\n  rank {}: {}", r, all.substr(r * longest, longest).c_str());
  throw CollectiveMismatch(text);
}

void broadcast(MPI_Comm comm, int root, std::string& text) {
  auto length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, root, comm);
  text.resize(length);
  MPI_Bcast(text.data(), length, MPI_CHAR, root, comm);
}

}  // namespace

void check_collective(MPI_Comm comm, CallSite at) {
  static const bool is_asked_for = std::getenv("CALOR_CHECK_COLLECTIVES") != nullptr;
  if (!is_asked_for || size_of(comm) == 1) return;
  std::int64_t place = at.line;
  for (const char* c = at.file; *c; ++c) place = (place * 131 + *c) % 1'000'000'007;
  std::array<std::int64_t, 2> range{place, -place};
  MPI_Allreduce(MPI_IN_PLACE, range.data(), 2, MPI_INT64_T, MPI_MIN, comm);
  if (range[0] != -range[1]) refuse_mismatch(comm, at);
}

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

double sum(MPI_Comm comm, std::span<const double> values, CallSite at) { return sums(comm, values, 1, at)[0]; }

std::vector<double> sums(MPI_Comm comm, std::span<const double> values, int columns, CallSite at) {
  if (columns == 0) return {};
  const auto fill = [&](int column, std::size_t begin, std::size_t count, double* out) {
    const double* in = values.data() + begin * columns + column;
    for (std::size_t i = 0; i < count; ++i) out[i] = in[i * columns];
  };
  return reproducible_sums(comm, values.size() / columns, columns, fill, at);
}

double dot(MPI_Comm comm, std::span<const double> a, std::span<const double> b, CallSite at) {
  const auto fill = [&](int, std::size_t begin, std::size_t count, double* out) {
    for (std::size_t i = 0; i < count; ++i) out[i] = a[begin + i] * b[begin + i];
  };
  return reproducible_sums(comm, a.size(), 1, fill, at)[0];
}

double max(MPI_Comm comm, double value, CallSite at) { return reduced(comm, value, MPI_DOUBLE, MPI_MAX, at); }
double min(MPI_Comm comm, double value, CallSite at) { return reduced(comm, value, MPI_DOUBLE, MPI_MIN, at); }
std::int64_t total(MPI_Comm comm, std::int64_t value, CallSite at) {
  return reduced(comm, value, MPI_INT64_T, MPI_SUM, at);
}
bool any(MPI_Comm comm, bool value, CallSite at) {
  return reduced(comm, static_cast<int>(value), MPI_INT, MPI_MAX, at) != 0;
}
std::uint32_t any_bit(MPI_Comm comm, std::uint32_t bits, CallSite at) {
  return reduced(comm, bits, MPI_UINT32_T, MPI_BOR, at);
}
void add_up(MPI_Comm comm, std::span<std::int64_t> values, CallSite at) {
  reduce_all(comm, values, MPI_INT64_T, MPI_SUM, at);
}
void add_up(MPI_Comm comm, std::span<double> values, CallSite at) { reduce_all(comm, values, MPI_DOUBLE, MPI_SUM, at); }
void lowest(MPI_Comm comm, std::span<double> values, CallSite at) { reduce_all(comm, values, MPI_DOUBLE, MPI_MIN, at); }

std::int64_t offset(MPI_Comm comm, std::int64_t value, CallSite at) {
  check_collective(comm, at);
  std::int64_t before = 0;
  MPI_Exscan(&value, &before, 1, MPI_INT64_T, MPI_SUM, comm);
  return rank_of(comm) == 0 ? 0 : before;  // MPI leaves it undefined on the first rank
}

void collective_try(MPI_Comm comm, const std::function<void()>& work, CallSite at) {
  std::optional<Error> error;
  bool has_memory = true;
  try {
    work();
  } catch (const CollectiveMismatch&) {
    throw;  // on all ranks
  } catch (const Error& e) {
    error = e;
  } catch (const std::bad_alloc&) {
    has_memory = false;
  } catch (const std::exception& e) {
    error = Error(Fault::numbers, e.what(), "");
  }
  const int none = size_of(comm);
  const int no_memory = -1;
  const int root = reduced(comm, !has_memory ? no_memory : error ? rank_of(comm) : none, MPI_INT, MPI_MIN, at);
  if (root == none) return;
  if (root == no_memory) throw std::bad_alloc();

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

int in_turns(MPI_Comm comm, int start, const std::function<int(int)>& work, CallSite at) {
  check_collective(comm, at);
  constexpr int tag = 1;
  const int rank = rank_of(comm), last = size_of(comm) - 1;
  int passed = start;
  if (rank > 0) MPI_Recv(&passed, 1, MPI_INT, rank - 1, tag, comm, MPI_STATUS_IGNORE);
  passed = work(passed);
  if (rank < last) MPI_Send(&passed, 1, MPI_INT, rank + 1, tag, comm);
  return passed;
}

bool all_arrive(MPI_Comm comm, double seconds, CallSite at) {
  using namespace std::chrono;
  check_collective(comm, at);
  const auto end = steady_clock::now() + duration<double>(seconds);
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(comm, &request);
  int is_done = 0;
  for (MPI_Test(&request, &is_done, MPI_STATUS_IGNORE); !is_done && steady_clock::now() < end;
       MPI_Test(&request, &is_done, MPI_STATUS_IGNORE))
    std::this_thread::sleep_for(milliseconds(1));
  return is_done != 0;
}

namespace detail {

void gather(MPI_Comm comm, const void* mine, std::size_t count, std::size_t record_size, const Room& room,
            CallSite at) {
  check_collective(comm, at);
  std::vector<int> counts(size_of(comm));
  const int my_count = static_cast<int>(count);
  MPI_Allgather(&my_count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  const std::vector<int> start = starts_of(counts);
  const RecordType record(record_size);
  MPI_Allgatherv(mine, my_count, record, room(start.back()), counts.data(), start.data(), record, comm);
}

void exchange(MPI_Comm comm, const void* packed, const std::vector<int>& counts, std::size_t record_size,
              const Room& room, CallSite at) {
  check_collective(comm, at);
  std::vector<int> arriving(counts.size());
  MPI_Alltoall(counts.data(), 1, MPI_INT, arriving.data(), 1, MPI_INT, comm);
  const std::vector<int> from = starts_of(counts), to = starts_of(arriving);
  const RecordType record(record_size);
  MPI_Alltoallv(packed, counts.data(), from.data(), record, room(to.back()), arriving.data(), to.data(), record, comm);
}

}  // namespace detail

}  // namespace calor
