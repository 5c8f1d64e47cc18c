#pragma once
// What every distributed part needs of MPI. Sums come out with the same bits on any number of ranks, because they are
// taken over pre-rounded parts that add up without error (Demmel & Nguyen, Fast reproducible floating-point
// summation, ARITH 2013); so step counts, solver iterations and reports do not depend on the number of ranks.
//
// Collective functions know where they are called. With the environment variable CALOR_CHECK_COLLECTIVES set, ranks
// compare these places first: where they differ, all throw CollectiveMismatch, instead of waiting for ever.
#include <mpi.h>

#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace calor {

/// Where a collective function is called; std::source_location, which clang 14 does not have yet.
struct CallSite {
  const char *file, *function;
  int line;
  static constexpr CallSite current(const char* file = __builtin_FILE(), const char* function = __builtin_FUNCTION(),
                                    int line = __builtin_LINE()) {
    return {file, function, line};
  }
};

/// Ranks called different collective functions: an error of the program, that names the places.
class CollectiveMismatch : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Compares the places where ranks are, if asked to by the environment. Collective.
void check_collective(MPI_Comm comm, CallSite at);

int rank_of(MPI_Comm comm);
int size_of(MPI_Comm comm);

/// Sum of all entries on all ranks; the same bits however the entries are distributed. Collective.
double sum(MPI_Comm comm, std::span<const double> values, CallSite at = CallSite::current());
/// Several sums at once, one per column of `values` (row-major, `columns` wide). Collective.
std::vector<double> sums(MPI_Comm comm, std::span<const double> values, int columns, CallSite at = CallSite::current());
/// Scalar product with the same property. Collective.
double dot(MPI_Comm comm, std::span<const double> a, std::span<const double> b, CallSite at = CallSite::current());

// Collective, too.
double max(MPI_Comm comm, double value, CallSite at = CallSite::current());
double min(MPI_Comm comm, double value, CallSite at = CallSite::current());
std::int64_t total(MPI_Comm comm, std::int64_t value, CallSite at = CallSite::current());
/// Sum of the values of all lower ranks.
std::int64_t offset(MPI_Comm comm, std::int64_t value, CallSite at = CallSite::current());
bool any(MPI_Comm comm, bool value, CallSite at = CallSite::current());
/// The bits that any rank has set.
std::uint32_t any_bit(MPI_Comm comm, std::uint32_t bits, CallSite at = CallSite::current());
/// Entry by entry, in place: sums (of doubles: exact where at most one rank has more than 0), lowest values.
void add_up(MPI_Comm comm, std::span<std::int64_t> values, CallSite at = CallSite::current());
void add_up(MPI_Comm comm, std::span<double> values, CallSite at = CallSite::current());
void lowest(MPI_Comm comm, std::span<double> values, CallSite at = CallSite::current());

/// Runs work that may throw on some ranks only; where one rank throws, all throw the error of the lowest. Collective.
void collective_try(MPI_Comm comm, const std::function<void()>& work, CallSite at = CallSite::current());

/// Runs work rank after rank; it gets what the rank before returned, the first one `start`. Work must not throw.
/// Returns what this rank's work returned. Collective.
int in_turns(MPI_Comm comm, int start, const std::function<int(int)>& work, CallSite at = CallSite::current());

/// Waits until all ranks have come here, after at most so many seconds returns false. Collective.
bool all_arrive(MPI_Comm comm, double seconds, CallSite at = CallSite::current());

namespace detail {

/// Where records go that arrive: room for so many of them.
using Room = std::function<void*(std::size_t)>;
void gather(MPI_Comm comm, const void* mine, std::size_t count, std::size_t record_size, const Room& room, CallSite at);
void exchange(MPI_Comm comm, const void* packed, const std::vector<int>& counts, std::size_t record_size,
              const Room& room, CallSite at);

template <class Record>
Room room_in(std::vector<Record>& records) {
  return [&records](std::size_t count) -> void* {
    records.resize(count);
    return records.data();
  };
}

}  // namespace detail

// Records hold plain data.

/// The records of all ranks, in the order of the ranks, on every rank. Collective.
template <class Record>
std::vector<Record> gather(MPI_Comm comm, const std::vector<Record>& mine, CallSite at = CallSite::current()) {
  std::vector<Record> all;
  detail::gather(comm, mine.data(), mine.size(), sizeof(Record), detail::room_in(all), at);
  return all;
}

/// Sends records, packed by destination with counts[r] of them to rank r; returns what arrived, in the order of the
/// senders. Collective.
template <class Record>
std::vector<Record> exchange(MPI_Comm comm, const std::vector<Record>& packed, const std::vector<int>& counts,
                             CallSite at = CallSite::current()) {
  std::vector<Record> received;
  detail::exchange(comm, packed.data(), counts, sizeof(Record), detail::room_in(received), at);
  return received;
}

}  // namespace calor
