#include "conduction/linear_algebra.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"

namespace calor {

Symmetric3 pseudo_inverse(const Symmetric3& M) {
  // Where M is well conditioned and positive, its cofactors are a tenth of the work of its eigenvectors.
  const double xx = M.yy * M.zz - M.yz * M.yz, xy = M.xz * M.yz - M.xy * M.zz, xz = M.xy * M.yz - M.xz * M.yy;
  const double determinant = M.xx * xx + M.xy * xy + M.xz * xz;
  const double mean = (M.xx + M.yy + M.zz) / 3;
  if (mean > 0 && determinant > 1e-3 * mean * mean * mean)
    return {.xx = xx / determinant,
            .yy = (M.xx * M.zz - M.xz * M.xz) / determinant,
            .zz = (M.xx * M.yy - M.xy * M.xy) / determinant,
            .xy = xy / determinant,
            .xz = xz / determinant,
            .yz = (M.xy * M.xz - M.xx * M.yz) / determinant};
  Eigen::Matrix3d A;
  A << M.xx, M.xy, M.xz, M.xy, M.yy, M.yz, M.xz, M.yz, M.zz;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A);
  const double smallest = 1e-10 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  Symmetric3 inverse;
  for (int n = 0; n < 3; ++n) {
    const double value = eigen.eigenvalues()[n];
    const auto v = eigen.eigenvectors().col(n);
    if (std::abs(value) > smallest) inverse.add(1 / value, {v[0], v[1], v[2]});
  }
  return inverse;
}

CgResult conjugate_gradients(MPI_Comm comm, const LinearMap& A, const LinearMap& preconditioner, std::span<double> r,
                             std::span<double> x, const CgLimits& limits) {
  const std::size_t n = r.size();
  std::vector<double> z(n), p(n);
  std::vector<double>& Ap = z;  // z is no longer wanted when Ap is
  CgResult result{.residual = std::sqrt(dot(comm, r, r))};
  const double goal = std::max(limits.relative * result.residual, limits.absolute);
  result.converged = result.residual <= goal;
  double rz_before = 1;
  while (!result.converged && result.iterations < limits.iterations) {
    preconditioner(r, z);
    const double rz = dot(comm, r, z), beta = result.iterations == 0 ? 0 : rz / rz_before;
    rz_before = rz;
    for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + beta * p[i];
    A(p, Ap);
    const double pAp = dot(comm, p, Ap);
    if (!(pAp > 0)) break;  // nothing left but the null space
    const double alpha = rz / pAp;
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * Ap[i];
    }
    result.residual = std::sqrt(dot(comm, r, r));
    result.converged = result.residual <= goal;
    ++result.iterations;
  }
  return result;
}

void ChebyshevSteps::advance() {
  const double middle = 0.5 * (limits.largest + limits.least), half = 0.5 * (limits.largest - limits.least);
  beta = (step == 0 ? 0 : step == 1 ? 0.5 : 0.25) * half * half * alpha * alpha;
  alpha = step == 0 ? 1 / middle : 1 / (middle - beta / alpha);
  ++step;
}

}  // namespace calor
