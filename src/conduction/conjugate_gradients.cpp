#include "conduction/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"

namespace calor {

CgResult conjugate_gradients(MPI_Comm comm, const LinearMap& A, const LinearMap& preconditioner,
                             std::span<const double> b, std::span<double> x, const CgLimits& limits) {
  const std::size_t n = b.size();
  std::vector<double> r(b.begin(), b.end()), z(n), p(n), Ap(n);
  std::fill(x.begin(), x.end(), 0.0);
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

}  // namespace calor
