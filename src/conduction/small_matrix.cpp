#include "conduction/small_matrix.hpp"

#include <Eigen/Eigenvalues>

namespace calor {

Symmetric3 pseudo_inverse(const Symmetric3& M) {
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

}  // namespace calor
