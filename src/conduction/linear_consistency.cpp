// The hard condition sum_j G_ij x_ji = -A_i: a truss in equilibrium with the boundary areas.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "conduction/correction.hpp"
#include "conduction/line_stiffness.hpp"
#include "conduction/linear_algebra.hpp"

namespace calor {

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double));

std::span<const double> numbers(std::span<const Vec3> v) {
  return {reinterpret_cast<const double*>(v.data()), 3 * v.size()};
}
std::span<double> numbers(std::span<Vec3> v) { return {reinterpret_cast<double*>(v.data()), 3 * v.size()}; }

/// Axes across which images lie: no rigid motion leaves their walls in place.
std::array<bool, 3> held_axes(const Cloud& cloud, const Neighbours& neighbours) {
  std::uint32_t walls = 0;
  for (const std::uint8_t set : neighbours.image) walls |= set;
  walls = any_bit(cloud.comm, walls);
  return {(walls & 0b11) != 0, (walls & 0b1100) != 0, (walls & 0b110000) != 0};
}

/// Removes the resultant and the moment of R, which no truss can balance. They vanish for exact boundary areas; areas
/// read from a file carry the rounding of their digits. Along axes that images hold, and about those that turn them,
/// they are balanced.
void remove_rigid_part(const Cloud& cloud, const Neighbours& neighbours, std::span<Vec3> R) {
  const auto points = cloud.owned_points();
  const auto count = static_cast<double>(cloud.count);
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
  const auto held = held_axes(cloud, neighbours);
  const auto turns = [&](int axis) { return held[(axis + 1) % 3] || held[(axis + 2) % 3] ? 0.0 : 1.0; };
  const double u = turns(0), v = turns(1), w = turns(2);
  const Symmetric3 inertia{u * (s[1] + s[2]), v * (s[0] + s[2]), w * (s[0] + s[1]),
                           -u * v * s[3],     -u * w * s[4],     -v * w * s[5]};
  const Vec3 shift{held[0] ? 0 : s[6] / count, held[1] ? 0 : s[7] / count, held[2] ? 0 : s[8] / count};
  const Vec3 turn = pseudo_inverse(inertia) * Vec3{u * s[9], v * s[10], w * s[11]};
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
  collective_try(cloud.comm, [&] {
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
  std::vector<Vec3> R(cloud.area.begin(), cloud.area.begin() + cloud.owned);
  for (std::size_t p = 0; p < neighbours.mirrored.size(); ++p) {
    const Facet& facet = cloud.facets[p];
    if (neighbours.mirrored[p]) R[facet.point] -= facet.area * facet.normal;
  }
  for (int i = 0; i < cloud.owned; ++i) {
    Vec3 sum;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) sum += g[n] * neighbours.x_ji(cloud.x, i, n);
    R[i] = -(sum + R[i]);
  }
  return R;
}

LambdaSolve enforce_linear_consistency(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g,
                                       double tolerance) {
  // sum_j g_ij (x_ji (x) x_ji) (lambda_i - lambda_j) = R_i: the stiffness matrix of a truss, semi-definite with the
  // rigid motions as null space. Preconditioner: the D x D blocks of the diagonal. On a long line that takes as many
  // iterations as there are points: there it is the whole matrix, factorised, at the price of the last bits on other
  // numbers of ranks.
  constexpr std::int64_t long_line = 5000;
  const auto& x = cloud.x;
  std::vector<Vec3> R = linear_residual(cloud, neighbours, g);
  remove_rigid_part(cloud, neighbours, R);

  std::vector<Symmetric3> inverse(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    Symmetric3 block;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) block.add(g[n], neighbours.x_ji(x, i, n));
    inverse[i] = pseudo_inverse(block);
  }
  std::optional<LineStiffness> line;
  if (cloud.dimension == 1 && cloud.count > long_line)
    line.emplace(cloud, neighbours, g, held_axes(cloud, neighbours)[0]);
  const LinearMap preconditioner = [&](std::span<const double> r, std::span<double> z) {
    if (line) return line->solve(r, z);
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
    with_pair_vectors(neighbours, x, [&](const auto& pair) {
      for (int i = 0; i < cloud.owned; ++i) {
        Vec3 sum;
        for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
          const Vec3 r = pair.x_ji(i, n);
          sum += (g[n] * dot(lambda[i] - pair.reflected(lambda[neighbours.column[n]], n), r)) * r;
        }
        y[3 * i] = sum.x, y[3 * i + 1] = sum.y, y[3 * i + 2] = sum.z;
      }
    });
  };

  // The absolute stop keeps CG from wandering when R is already round-off.
  double spacing = cloud.owned > 0 ? *std::max_element(cloud.spacing.begin(), cloud.spacing.begin() + cloud.owned) : 0;
  spacing = max(cloud.comm, spacing);
  const double size = std::pow(spacing, cloud.dimension - 1) * cloud.cross_section;
  const double round_off = 1e-13 * size * std::sqrt(static_cast<double>(cloud.count));
  std::vector<double> solution(3 * static_cast<std::size_t>(cloud.owned));
  const auto solved =
      conjugate_gradients(cloud.comm, stiffness, preconditioner, numbers(std::span<const Vec3>(R)), solution,
                          {.relative = tolerance, .absolute = round_off, .iterations = 20000});
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
      const Vec3 lambda_j = neighbours.reflected(lambda[neighbours.column[n]], n);
      const double c = dot(lambda[i] - lambda_j, neighbours.x_ji(x, i, n));
      change = std::max(change, std::abs(c));
      g[n] *= 1 + c;
    }
  }
  return {solved.iterations, max(cloud.comm, change)};
}

}  // namespace calor
