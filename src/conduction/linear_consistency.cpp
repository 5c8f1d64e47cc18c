// The hard condition sum_j G_ij x_ji = -A_i: a truss in equilibrium with the boundary areas.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/components.hpp"
#include "conduction/coarse_truss.hpp"
#include "conduction/correction.hpp"
#include "conduction/line_stiffness.hpp"
#include "conduction/linear_algebra.hpp"
#include "conduction/pair_changes.hpp"

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

/// Removes the resultant and the moment of R, one body of the cloud, which no truss can balance. They vanish for exact
/// boundary areas; areas read from a file carry the rounding of their digits. Along axes that images hold, and about
/// those that turn them, they are balanced.
void remove_rigid_part(const Cloud& cloud, const Neighbours& neighbours, std::span<const int> body, std::span<Vec3> R) {
  const double count = static_cast<double>(total(cloud.comm, static_cast<std::int64_t>(body.size())));
  std::vector<Vec3> points;
  for (const int i : body) points.push_back(cloud.x[i]);
  const auto sum = sums(cloud.comm, numbers(std::span<const Vec3>(points)), 3);
  const Vec3 centre{sum[0] / count, sum[1] / count, sum[2] / count};
  std::vector<double> columns;
  columns.reserve(12 * points.size());
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Vec3 &r = R[body[n]], x = points[n] - centre, moment = cross(x, r);
    columns.insert(columns.end(), {x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.x * x.z, x.y * x.z});
    columns.insert(columns.end(), {r.x, r.y, r.z, moment.x, moment.y, moment.z});
  }
  const auto s = sums(cloud.comm, columns, 12);
  const auto held = held_axes(cloud, neighbours);
  const auto turns = [&](int axis) { return held[(axis + 1) % 3] || held[(axis + 2) % 3] ? 0.0 : 1.0; };
  const double u = turns(0), v = turns(1), w = turns(2);
  const Symmetric3 inertia{u * (s[1] + s[2]), v * (s[0] + s[2]), w * (s[0] + s[1]),
                           -u * v * s[3],     -u * w * s[4],     -v * w * s[5]};
  const Vec3 shift{held[0] ? 0 : s[6] / count, held[1] ? 0 : s[7] / count, held[2] ? 0 : s[8] / count};
  const Vec3 turn = pseudo_inverse(inertia) * Vec3{u * s[9], v * s[10], w * s[11]};
  for (std::size_t n = 0; n < points.size(); ++n) R[body[n]] -= shift + cross(turn, points[n] - centre);
}

/// The same of every body: each moves by itself.
void remove_rigid_parts(const Cloud& cloud, const Neighbours& neighbours, std::span<Vec3> R) {
  std::vector<std::vector<int>> bodies(1);
  if (cloud.lattice) {
    bodies[0].resize(cloud.owned);
    std::iota(bodies[0].begin(), bodies[0].end(), 0);
  } else {
    const Components found = components(cloud, neighbours);
    bodies.resize(found.count);
    for (int i = 0; i < cloud.owned; ++i) bodies[found.of[i]].push_back(i);
  }
  for (const auto& body : bodies) remove_rigid_part(cloud, neighbours, body, R);
}

/// Least of the largest faces across the axes over that across each axis: 1 on clouds of one spacing.
Vec3 over_faces(const Cloud& cloud) {
  Vec3 face, unit{1, 1, 1};
  for (int i = 0; i < cloud.owned; ++i)
    for (int a = 0; a < 3; ++a) face[a] = std::max(face[a], face_size(cloud, i)[a]);
  for (int a = 0; a < 3; ++a) face[a] = max(cloud.comm, face[a]);
  double least = face.x;
  for (int a = 1; a < cloud.dimension; ++a) least = std::min(least, face[a]);
  for (int a = 0; a < cloud.dimension; ++a) unit[a] = least / face[a];
  return unit;
}

/// Names the point where the residual R is largest.
[[noreturn]] void refuse(const Cloud& cloud, std::span<const Vec3> R, int iterations) {
  double largest = 0;
  int where = -1;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 face = face_size(cloud, i);
    double r = 0;
    for (int a = 0; a < cloud.dimension; ++a) r = std::max(r, std::abs(R[i][a]) / face[a]);
    if (where < 0 || r > largest) {
      largest = r;
      where = i;
    }
  }
  const double everywhere = max(cloud.comm, largest);
  const std::string cure =
      cloud.body
          ? "the body may be too thin there for its points: take a smaller spacing, or finer points there by "
            "[[cloud.near]]"
          : "points there have too few neighbours or hang on a line of them: add points, or let them see farther "
            "([sph] smoothing, [peridynamics] horizon)";
  collective_try(cloud.comm, [&] {
    if (where < 0 || largest < everywhere) return;
    const Vec3 x = cloud.x[where];
    throw Error(Fault::numbers,
                fmt::format("consistent weights: no solution after {} iterations; the worst point is number {} at "
                            "({:.6g}, {:.6g}, {:.6g}) m: its neighbours cannot balance its boundary area",
                            iterations, cloud.id[where], x.x, x.y, x.z),
                cure);
  });
  throw Error(Fault::numbers, "consistent weights: no solution", cure);
}

/// sum_j g_ij (x_ji (x) x_ji) (lambda_i - lambda_j): the stiffness matrix of a truss, semi-definite with the rigid
/// motions as null space. Rows and unknowns are scaled axis by axis with the faces there: lambda = unit p.
class Truss {
 public:
  Truss(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g, const Vec3& unit)
      : cloud_(cloud), g_(g), unit_(unit), inverse_(cloud.owned), changes_(cloud, neighbours) {
    for (int i = 0; i < cloud.owned; ++i) {
      Symmetric3 block;
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
        block.add(g[n], product(unit, neighbours.x_ji(cloud.x, i, n)));
      inverse_[i] = pseudo_inverse(block);
    }
  }

  void multiply(std::span<const double> p, std::span<double> y) {
    set_lambda(p);
    changes_.effects(g_.data(), 0, cloud_.owned, y.data());
    for (int i = 0; i < cloud_.owned; ++i)
      for (int a = 0; a < 3; ++a) y[3 * i + a] *= unit_[a];
  }

  /// z = inverse of the D x D blocks of the diagonal times r. With these no eigenvalue lies beyond 2, as none of those
  /// of the fit (second_moments.cpp).
  void divide_by_blocks(std::span<const double> r, std::span<double> z) const {
    for (int i = 0; i < cloud_.owned; ++i) {
      const Vec3 v = inverse_[i] * Vec3{r[3 * i], r[3 * i + 1], r[3 * i + 2]};
      z[3 * i] = v.x, z[3 * i + 1] = v.y, z[3 * i + 2] = v.z;
    }
  }

  /// Would any weight become negative? On any rank.
  bool makes_negative(std::span<const double> p) {
    set_lambda(p);
    bool negative = false;
    changes_.for_each_change([&](int /*i*/, std::int64_t n, double c)
                                 CALOR_ALWAYS_INLINE { negative = negative || g_[n] * (1 + c) < 0; });
    return any(cloud_.comm, negative);
  }

  /// g_ij <- g_ij [1 + (lambda_i - lambda_j).x_ji], see LambdaSolve. The last thing to do: the matrix is that of the
  /// weights before.
  void change_weights(std::span<const double> p, std::span<double> g, double floor, LambdaSolve& done) {
    done.negative = makes_negative(p);
    const bool lift = done.negative && floor > 0;
    changes_.for_each_change([&](int /*i*/, std::int64_t n, double c) CALOR_ALWAYS_INLINE {
      done.change = std::max(done.change, std::abs(c));
      const double changed = g[n] * (1 + c);
      g[n] = lift ? std::max(changed, floor * g[n]) : changed;
    });
    done.change = max(cloud_.comm, done.change);
  }

 private:
  void set_lambda(std::span<const double> p) {
    for (int i = 0; i < cloud_.owned; ++i)
      for (int a = 0; a < 3; ++a) changes_.at(i)[a] = unit_[a] * p[3 * i + a];
    changes_.update_ghosts();
  }

  const Cloud& cloud_;
  std::span<const double> g_;
  Vec3 unit_;
  std::vector<Symmetric3> inverse_;
  PairChanges<false> changes_;
};

}  // namespace

std::vector<Vec3> wanted_sums(const Cloud& cloud, const Neighbours& neighbours) {
  std::vector<Vec3> wanted(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) wanted[i] = -cloud.plane_area(i);
  for (std::size_t p = 0; p < neighbours.mirrored.size(); ++p) {
    const Facet& facet = cloud.facets[p];
    if (neighbours.mirrored[p]) wanted[facet.point] += facet.area * facet.normal;
  }
  return wanted;
}

std::vector<Vec3> linear_residual(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g) {
  std::vector<Vec3> R = wanted_sums(cloud, neighbours);
  for (int i = 0; i < cloud.owned; ++i) {
    Vec3 sum;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) sum += g[n] * neighbours.x_ji(cloud.x, i, n);
    R[i] -= sum;
  }
  return R;
}

LambdaSolve enforce_linear_consistency(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g,
                                       double tolerance, double floor) {
  // The blocks of the diagonal take care of what differs from point to point, the coarse grid of the rest. On a long
  // line that takes too many iterations: there the preconditioner is the whole matrix, factorised, at the price of the
  // last bits on other numbers of ranks.
  constexpr std::int64_t long_line = 5000;
  const Vec3 unit = over_faces(cloud);
  std::vector<Vec3> R = linear_residual(cloud, neighbours, g);
  remove_rigid_parts(cloud, neighbours, R);
  for (Vec3& r : R) r = product(unit, r);

  Truss truss(cloud, neighbours, g, unit);
  std::optional<LineStiffness> line;
  if (cloud.dimension == 1 && cloud.count > long_line)
    line.emplace(cloud, neighbours, g, held_axes(cloud, neighbours)[0]);
  const LinearMap stiffness = [&](auto p, auto y) { truss.multiply(p, y); };
  CoarseTruss coarse(cloud, neighbours, g, unit, held_axes(cloud, neighbours));
  const LinearMap preconditioner = [&](auto r, auto z) {
    if (line) return line->solve(r, z);
    truss.divide_by_blocks(r, z);
    coarse.add_solution(r, z);
  };

  // The absolute stop keeps CG from wandering when R is already round-off.
  double size = 0;
  for (int i = 0; i < cloud.owned; ++i)
    for (int a = 0; a < cloud.dimension; ++a) size = std::max(size, product(unit, face_size(cloud, i))[a]);
  const double round_off = 1e-13 * max(cloud.comm, size) * std::sqrt(static_cast<double>(cloud.count));
  // Weights that become negative show early, and the next solve starts from others; but the part that is solved stays
  // in them, and must not tell how the body lies in the coarse grid.
  constexpr double early = 1e-8;
  const auto r = numbers(std::span<Vec3>(R));
  const double start = std::sqrt(dot(cloud.comm, r, r));
  std::vector<double> p(3 * static_cast<std::size_t>(cloud.owned));
  LambdaSolve done = {};
  const auto solve_to = [&](double part) {
    const auto solved = conjugate_gradients(cloud.comm, stiffness, preconditioner, r, p,
                                            {.absolute = std::max(part * start, round_off), .iterations = 20000});
    done.iterations += solved.iterations;
    if (solved.converged) return;
    for (Vec3& left : R) left = quotient(left, unit);
    refuse(cloud, R, done.iterations);
  };
  if (floor > 0) solve_to(early);
  if (floor == 0 || !truss.makes_negative(p)) solve_to(tolerance);
  truss.change_weights(p, g, floor, done);
  return done;
}

}  // namespace calor
