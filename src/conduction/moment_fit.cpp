// The fit of second moments (M) and linear consistency (L) together: one least change of the weights towards both.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "conduction/correction.hpp"
#include "conduction/linear_algebra.hpp"
#include "conduction/pair_changes.hpp"

namespace calor {

namespace {

using Changes = PairChanges<true>;
constexpr int N = Changes::unknowns;
using MatrixN = Eigen::Matrix<double, N, N>;
using VectorN = Eigen::Matrix<double, N, 1>;

/// Steps of the fit, and the least eigenvalue that it damps. (M) and (L) together are over-determined, so the fit must
/// not be exact: what these steps leave, fields that change their sign from point to point, is neither in the errors
/// nor better known from volumes. On jittered squares eight steps down to 0.15 leave errors 5 % larger, on clouds of
/// meshes up to 9 % larger.
constexpr int steps_of_fit = 11;
constexpr double least_of_fit = 0.08;
/// Of the diagonal: keeps the blocks of points regular that see too few others; and (M) is no truer than the volumes:
/// sectors of rings are not the cells of their points, nor are cells of a body that is measured in other lengths since
/// it conducts differently by direction.
constexpr double softness_of_nearest = 1e-3, softness_of_others = 0.2;
constexpr double floor_of_fit = 0.02;

/// Symmetric matrix of a point.
MatrixN matrix(const Changes::Block& upper) {
  MatrixN M;
  std::size_t n = 0;
  for (int a = 0; a < N; ++a)
    for (int b = a; b < N; ++b) M(a, b) = M(b, a) = upper[n++];
  return M;
}

VectorN product(const Changes::Block& upper, const VectorN& x) {
  VectorN y = VectorN::Zero();
  std::size_t n = 0;
  for (int a = 0; a < N; ++a) {
    y[a] += upper[n++] * x[a];
    for (int b = a + 1; b < N; ++b, ++n) y[a] += upper[n] * x[b], y[b] += upper[n] * x[a];
  }
  return y;
}

/// (B + diagonal)^-1; components that neither has stay out.
Changes::Block inverse(MatrixN B, const VectorN& diagonal) {
  for (int a = 0; a < N; ++a)
    if ((B(a, a) += diagonal[a]) == 0) B(a, a) = 1;
  const MatrixN M = B.llt().solve(MatrixN::Identity());
  Changes::Block upper;
  std::size_t n = 0;
  for (int a = 0; a < N; ++a)
    for (int b = a; b < N; ++b) upper[n++] = 0.5 * (M(a, b) + M(b, a));
  return upper;
}

/// 2 V_i I of the owned points. Off the walls, a facet at the distance y carries 2 A y n (x) n of it: the heat of a
/// quadratic temperature that passes the wall.
std::vector<Six> wanted_moments(const Cloud& cloud, const Neighbours& neighbours) {
  std::vector<Six> wanted(cloud.owned, Six{});
  for (int i = 0; i < cloud.owned; ++i) {
    for (int c = 0; c < cloud.dimension; ++c) wanted[i][c] = 2 * cloud.volume[i];
    if (cloud.axisymmetric) wanted[i][0] += 2 * cloud.moment[i].x, wanted[i][3] += cloud.moment[i].y;
  }
  if (cloud.points_on_walls) return wanted;
  for (std::size_t p = 0; p < cloud.facets.size(); ++p) {
    if (!neighbours.mirrored.empty() && neighbours.mirrored[p]) continue;
    const Facet& facet = cloud.facets[p];
    const Six q = products(facet.normal);
    for (int c = 0; c < 6; ++c) wanted[facet.point][c] -= 2 * facet.area * wall_distance(cloud, facet) * q[c];
  }
  return wanted;
}

/// What softens the rows of (M), and keeps blocks of points regular whose neighbours lie in a plane or on a line: parts
/// of the diagonal. On isotropic clouds it is the diagonal that neighbours alike in all directions would give, so that
/// the fit turns with the body.
VectorN softness(const Cloud& cloud, const MatrixN& B) {
  const int D = cloud.dimension;
  const double second = B.block<3, 3>(0, 0).trace() / D, fourth = B.block<3, 3>(3, 3).sum() / (D * (D + 2));
  VectorN soft = B.diagonal();
  for (int c = 0; c < N && cloud.isotropic; ++c)
    if (soft[c] > 0) soft[c] = c < 3 ? second : (c < 6 ? 3.0 : 1.5) * fourth;
  soft.head<3>() *= softness_of_nearest;
  soft.tail<6>() *= cloud.nearest_volumes ? softness_of_nearest : softness_of_others;
  return soft;
}

}  // namespace

MomentFit fit_moments(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g) {
  // Normal equations of the least change of g, in the metric of g:
  //   (C g C^T + S) z = wanted - C g,  C_i: x_ji and x_ji (x) x_ji,  z_i: lambda_i and tau_i,  S: softness of (M).
  // In the metric of the points' own blocks B_i, plus S, no eigenvalue lies beyond 2:
  //   1/2 sum_ij g_ij (c_i + c_j)^2 <= 2 sum_i z_i.B_i z_i
  // with the parts c_i and c_j that the unknowns of both points have in c_ij; rows are multiplied by their inverses.
  Changes changes(cloud, neighbours);
  std::vector<Changes::Block> blocks = changes.blocks(g);
  std::vector<VectorN> soft(cloud.owned);
  std::vector<double> rhs(N * static_cast<std::size_t>(cloud.owned)), z(rhs.size());
  const auto of = [](auto&& numbers, int i) {
    return Eigen::Map<VectorN>(const_cast<double*>(numbers.data()) + N * static_cast<std::ptrdiff_t>(i));
  };
  const std::vector<Vec3> L = linear_residual(cloud, neighbours, g);
  const std::vector<Six> wanted = wanted_moments(cloud, neighbours);
  for (int i = 0; i < cloud.owned; ++i) {
    const MatrixN B = matrix(blocks[i]);
    VectorN off;
    const Six now = {B(0, 0), B(1, 1), B(2, 2), B(0, 1), B(0, 2), B(1, 2)};
    for (int c = 0; c < 6; ++c) off[3 + c] = wanted[i][c] - now[c];
    off.head<3>() << L[i].x, L[i].y, L[i].z;
    soft[i] = softness(cloud, B);
    blocks[i] = inverse(B, soft[i]);
    soft[i].head<3>().setZero();  // (L) is none the softer for it
    of(rhs, i) = product(blocks[i], off);
  }
  const LinearMap normal_matrix = [&](std::span<const double> p, std::span<double> y) {
    changes.set(p);
    changes.effects(g, y);
    for (int i = 0; i < cloud.owned; ++i) of(y, i) = product(blocks[i], of(y, i) + soft[i].cwiseProduct(of(p, i)));
  };
  chebyshev(normal_matrix, rhs, z, {.least = least_of_fit, .largest = 2, .steps = steps_of_fit});
  changes.set(z);
  std::vector<double> squares(2 * static_cast<std::size_t>(cloud.owned));
  changes.for_each_change([&](int i, std::int64_t n, double c) {
    squares[2 * i] += g[n] * c * c, squares[2 * i + 1] += g[n];
    g[n] *= std::max(1 + c, floor_of_fit);
  });
  const auto total = sums(cloud.comm, squares, 2);
  return {steps_of_fit, std::sqrt(total[0] / total[1])};
}

}  // namespace calor
