// The hard condition sum_j G_ij x_ji = -A_i: a truss in equilibrium with the boundary areas.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "method/conjugate_gradients.hpp"
#include "method/correction_steps.hpp"
#include "method/small_matrix.hpp"

namespace calor {

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double));

std::span<const double> numbers(std::span<const Vec3> v) {
  return {reinterpret_cast<const double*>(v.data()), 3 * v.size()};
}
std::span<double> numbers(std::span<Vec3> v) { return {reinterpret_cast<double*>(v.data()), 3 * v.size()}; }

/// Removes the resultant and the moment of R, which no truss can balance. They vanish for exact boundary areas; areas
/// read from a file carry the rounding of their digits.
void remove_rigid_part(const Cloud& cloud, std::span<Vec3> R) {
  const auto points = cloud.owned_points();
  const double count = static_cast<double>(cloud.count);
  const auto total = sums(cloud.comm, numbers(points), 3);
  const Vec3 centre{total[0] / count, total[1] / count, total[2] / count};
  std::vector<double> columns;
  columns.reserve(12 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 x = points[i] - centre, moment = cross(x, R[i]);
    columns.insert(columns.end(), {x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.x * x.z, x.y * x.z});
    columns.insert(columns.end(), {R[i].x, R[i].y, R[i].z, moment.x, moment.y, moment.z});
  }
  const auto s = sums(cloud.comm, columns, 12);
  const Symmetric3 inertia{s[1] + s[2], s[0] + s[2], s[0] + s[1], -s[3], -s[4], -s[5]};
  const Vec3 shift{s[6] / count, s[7] / count, s[8] / count};
  const Vec3 turn = pseudo_inverse(inertia) * Vec3{s[9], s[10], s[11]};
  for (std::size_t i = 0; i < points.size(); ++i) R[i] -= shift + cross(turn, points[i] - centre);
}

/// Names the point where the residual R is largest.
[[noreturn]] void refuse(const Cloud& cloud, std::span<const Vec3> R, int iterations) {
  double largest = 0;
  int where = -1;
  for (int i = 0; i < cloud.owned; ++i) {
    if (const double r = norm(R[i]) / std::pow(cloud.spacing[i], cloud.dimension - 1); where < 0 || r > largest) {
      largest = r;
      where = i;
    }
  }
  const double everywhere = max(cloud.comm, largest);
  together(cloud.comm, [&] {
    if (where < 0 || largest < everywhere) return;
    const Vec3 x = cloud.x[where];
    throw Error(Fault::numbers,
                fmt::format("consistent weights: no solution after {} iterations; the worst point is number {} at "
                            "({:.6g}, {:.6g}, {:.6g}) m: its neighbours cannot balance its boundary area",
                            iterations, cloud.id[where], x.x, x.y, x.z),
                "points there have too few neighbours or hang on a line of them: use a larger smoothing (or horizon), "
                "or add points");
  });
  throw Error(Fault::numbers, "consistent weights: no solution", "use a larger smoothing");
}

}  // namespace

std::vector<Vec3> linear_residual(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g) {
  std::vector<Vec3> R(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    Vec3 sum;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      sum += g[n] * (cloud.x[neighbours.column[n]] - cloud.x[i]);
    }
    R[i] = -(sum + cloud.area[i]);
  }
  return R;
}

LambdaSolve enforce_linear_consistency(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g) {
  // sum_j g_ij (x_ji (x) x_ji) (lambda_i - lambda_j) = R_i: the stiffness matrix of a truss, semi-definite with the
  // rigid motions as null space. Preconditioner: the D x D blocks of the diagonal.
  const auto& x = cloud.x;
  std::vector<Vec3> R = linear_residual(cloud, neighbours, g);
  remove_rigid_part(cloud, R);

  std::vector<Symmetric3> inverse(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    Symmetric3 block;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) block.add(g[n], x[neighbours.column[n]] - x[i]);
    inverse[i] = pseudo_inverse(block);
  }
  const LinearMap preconditioner = [&](std::span<const double> r, std::span<double> z) {
    for (int i = 0; i < cloud.owned; ++i) {
      const Vec3 v = inverse[i] * Vec3{r[3 * i], r[3 * i + 1], r[3 * i + 2]};
      z[3 * i] = v.x, z[3 * i + 1] = v.y, z[3 * i + 2] = v.z;
    }
  };

  std::vector<Vec3> lambda(cloud.local());
  const auto set_lambda = [&](std::span<const double> p) {
    std::copy(p.begin(), p.end(), numbers(std::span<Vec3>(lambda)).begin());
    cloud.halo.update(std::span<Vec3>(lambda));
  };
  const LinearMap stiffness = [&](std::span<const double> p, std::span<double> y) {
    set_lambda(p);
    for (int i = 0; i < cloud.owned; ++i) {
      Vec3 sum;
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const int j = neighbours.column[n];
        const Vec3 r = x[j] - x[i];
        sum += (g[n] * dot(lambda[i] - lambda[j], r)) * r;
      }
      y[3 * i] = sum.x, y[3 * i + 1] = sum.y, y[3 * i + 2] = sum.z;
    }
  };

  // The absolute stop keeps CG from wandering when R is already round-off.
  double spacing = cloud.owned > 0 ? *std::max_element(cloud.spacing.begin(), cloud.spacing.begin() + cloud.owned) : 0;
  spacing = max(cloud.comm, spacing);
  const double size = std::pow(spacing, cloud.dimension - 1) * cloud.section;
  const double round_off = 1e-13 * size * std::sqrt(static_cast<double>(cloud.count));
  std::vector<double> solution(3 * static_cast<std::size_t>(cloud.owned));
  const auto solved = conjugate_gradients(cloud.comm, stiffness, preconditioner, numbers(std::span<const Vec3>(R)),
                                          solution, {.relative = 1e-12, .absolute = round_off, .iterations = 20000});
  set_lambda(solution);
  if (!solved.converged) {
    std::vector<double> Kl(solution.size());
    stiffness(solution, Kl);
    auto left = numbers(std::span<Vec3>(R));
    for (std::size_t k = 0; k < Kl.size(); ++k) left[k] -= Kl[k];
    refuse(cloud, R, solved.iterations);
  }

  double change = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      const double c = dot(lambda[i] - lambda[j], x[j] - x[i]);
      change = std::max(change, std::abs(c));
      g[n] *= 1 + c;
    }
  }
  return {solved.iterations, max(cloud.comm, change)};
}

}  // namespace calor
