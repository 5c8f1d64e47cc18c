#pragma once
// Preconditioned conjugate gradients whose iterates have the same bits on any number of ranks (every scalar product is
// taken by calor::dot), which PETSc's solvers do not promise. Also for consistent semi-definite systems.
#include <mpi.h>

#include <functional>
#include <span>

namespace calor {

/// y = A x on the owned entries of distributed vectors; may communicate.
using LinearMap = std::function<void(std::span<const double> x, std::span<double> y)>;

/// Stops at |b - A x| <= max(relative |b|, absolute), in the 2-norm.
struct CgLimits {
  double relative = 0, absolute = 0;
  int iterations = 0;
};

struct CgResult {
  int iterations = 0;
  double residual = 0;  ///< |b - A x| as the recurrence has it
  bool converged = false;
};

/// Solves A x = b from x = 0. Collective.
CgResult conjugate_gradients(MPI_Comm comm, const LinearMap& A, const LinearMap& preconditioner,
                             std::span<const double> b, std::span<double> x, const CgLimits& limits);

}  // namespace calor
