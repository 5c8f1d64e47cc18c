#pragma once
// Small matrices of points, and conjugate gradients whose iterates have the same bits on any number of ranks.
#include <mpi.h>

#include <functional>
#include <span>

#include "base/vec3.hpp"

namespace calor {

/// Symmetric D x D matrix of a point, D <= 3; in bodies of one or two dimensions the rest stays zero.
struct Symmetric3 {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  /// Adds w a (x) a.
  void add(double w, const Vec3& a) {
    xx += w * a.x * a.x, yy += w * a.y * a.y, zz += w * a.z * a.z;
    xy += w * a.x * a.y, xz += w * a.x * a.z, yz += w * a.y * a.z;
  }
  Vec3 operator*(const Vec3& a) const {
    return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z, xz * a.x + yz * a.y + zz * a.z};
  }
};

/// Inverse on the directions that M sees, zero on the others (eigenvalues below 1e-10 of the largest).
Symmetric3 pseudo_inverse(const Symmetric3& M);

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

/// Solves A x = b from x = 0, by preconditioned conjugate gradients in which every scalar product is taken by
/// calor::dot: PETSc's solvers do not promise the same bits on any number of ranks. Also for consistent semi-definite
/// systems. Collective.
CgResult conjugate_gradients(MPI_Comm comm, const LinearMap& A, const LinearMap& preconditioner,
                             std::span<const double> b, std::span<double> x, const CgLimits& limits);

}  // namespace calor
