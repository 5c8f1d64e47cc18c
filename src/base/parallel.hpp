#pragma once
// What every distributed part needs of MPI. Sums come out with the same bits on any number of ranks, because they are
// taken over pre-rounded parts that add up without error (Demmel & Nguyen, Fast reproducible floating-point
// summation, ARITH 2013); so step counts, solver iterations and reports do not depend on the number of ranks.
#include <mpi.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace calor {

int rank_of(MPI_Comm comm);
int size_of(MPI_Comm comm);

/// Sum of all entries on all ranks; the same bits however the entries are distributed. Collective.
double sum(MPI_Comm comm, std::span<const double> values);
/// Several sums at once, one per column of `values` (row-major, `columns` wide). Collective.
std::vector<double> sums(MPI_Comm comm, std::span<const double> values, int columns);
/// Scalar product with the same property. Collective.
double dot(MPI_Comm comm, std::span<const double> a, std::span<const double> b);

double max(MPI_Comm comm, double value);
double min(MPI_Comm comm, double value);
std::int64_t total(MPI_Comm comm, std::int64_t value);
/// Sum of the values of all lower ranks.
std::int64_t offset(MPI_Comm comm, std::int64_t value);
bool any(MPI_Comm comm, bool value);

/// Runs work that may throw on some ranks only; where one rank throws, all throw the error of the lowest. Collective.
void collective_try(MPI_Comm comm, const std::function<void()>& work);

}  // namespace calor
