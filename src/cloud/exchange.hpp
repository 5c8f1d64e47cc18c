#pragma once
// Records sent between ranks.
#include <mpi.h>

#include <cstddef>
#include <numeric>
#include <vector>

namespace calor {

/// Sends records, packed by destination with counts[r] of them to rank r; returns what arrived, in the order of the
/// senders. `Record` holds plain data. Collective.
template <class Record>
std::vector<Record> exchange(MPI_Comm comm, const std::vector<Record>& packed, const std::vector<int>& counts) {
  const std::size_t ranks = counts.size();
  std::vector<int> arriving(ranks), from(ranks + 1, 0), to(ranks + 1, 0);
  MPI_Alltoall(counts.data(), 1, MPI_INT, arriving.data(), 1, MPI_INT, comm);
  std::partial_sum(counts.begin(), counts.end(), from.begin() + 1);
  std::partial_sum(arriving.begin(), arriving.end(), to.begin() + 1);
  std::vector<Record> received(to.back());
  MPI_Datatype record = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(sizeof(Record), MPI_BYTE, &record);
  MPI_Type_commit(&record);
  MPI_Alltoallv(packed.data(), counts.data(), from.data(), record, received.data(), arriving.data(), to.data(), record,
                comm);
  MPI_Type_free(&record);
  return received;
}

}  // namespace calor
