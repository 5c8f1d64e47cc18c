#pragma once
// Small matrices of points, and two iterations whose iterates have the same bits on any number of ranks.
#include <mpi.h>

#include <functional>
#include <span>

#include "base/symmetric3.hpp"

namespace calor {

/// Inverse on the directions that M sees, zero on the others (eigenvalues below 1e-10 of the largest).
Symmetric3 pseudo_inverse(const Symmetric3& M);

/// y = A x on the owned entries of distributed vectors; may communicate.
using LinearMap = std::function<void(std::span<const double> x, std::span<double> y)>;

/// Stops at |b - A x| <= max(relative |b - A x| at the start, absolute), in the 2-norm.
struct CgLimits {
  double relative = 0, absolute = 0;
  int iterations = 0;
};

struct CgResult {
  int iterations = 0;
  double residual = 0;  ///< |b - A x| as the recurrence has it
  bool converged = false;
};

/// Solves A x = b, by preconditioned conjugate gradients in which every scalar product is taken by calor::dot: PETSc's
/// solvers do not promise the same bits on any number of ranks. `r` is b - A x of the x that is given, and of the
/// solution afterwards. Also for consistent semi-definite systems. Collective.
CgResult conjugate_gradients(MPI_Comm comm, const LinearMap& A, const LinearMap& preconditioner, std::span<double> r,
                             std::span<double> x, const CgLimits& limits);

/// Eigenvalues that an iteration is to damp, and how often it looks at A x.
struct ChebyshevLimits {
  double least = 0, largest = 0;
};

/// The coefficients of Chebyshev's iteration for A x = b from x = 0 (Saad, Iterative Methods for Sparse Linear Systems,
/// 2nd ed., alg. 12.1): r = b, then in every step advance(), p = r + beta p, x += alpha p, r -= alpha A p. A is already
/// preconditioned; none of its eigenvalues may lie beyond `largest`, and components below `least` are left for the most
/// part. The result is linear in b and smooth in A, which conjugate gradients stopped halfway are not, and asks for no
/// sums over the points.
struct ChebyshevSteps {
  explicit ChebyshevSteps(const ChebyshevLimits& limits) : limits(limits) {}
  void advance();

  ChebyshevLimits limits;
  int step = 0;
  double alpha = 0, beta = 0;
};

}  // namespace calor
