// The fit of second moments (M) and linear consistency (L) together: one least change of the weights towards both.
#include <Eigen/Core>
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
/// Fits, each from weights that the one before left positive: few where the last of them changes little. On jittered
/// squares of 161 points an edge three leave errors of 4.0e-7 K (SPH), two 4.1e-7, one twice as much; on the sphere of
/// a mesh three leave 3 % less than two. Materials that conduct by direction, for which weights change by more than
/// themselves, take many.
constexpr int few_fits = 3, many_fits = 10;
constexpr double little = 0.1;
/// Many fits keep weights above this part of what few have made.
constexpr double floor_of_fits = 1e-3;
/// Of the diagonal: keeps the blocks of points regular that see too few others; and (M) is no truer than the volumes:
/// sectors of rings are not the cells of their points, nor are cells of a body that is measured in other lengths since
/// it conducts differently by direction.
constexpr double softness_of_nearest = 1e-3, softness_of_others = 0.2;
constexpr double floor_of_fit = 0.02;

/// Numbers of eight points, each in a lane, so that the small matrices of eight points are multiplied at once.
constexpr int lanes = 8;
template <int count>
struct Numbers {
  using Lanes __attribute__((vector_size(lanes * sizeof(double)), aligned(sizeof(double)), may_alias)) = double;

  double v[count][lanes] = {};
  CALOR_ALWAYS_INLINE Lanes& operator[](int n) { return *reinterpret_cast<Lanes*>(v[n]); }
  CALOR_ALWAYS_INLINE const Lanes& operator[](int n) const { return *reinterpret_cast<const Lanes*>(v[n]); }
};
using Unknowns = Numbers<N>;
using SymmetricMatrix = Numbers<N*(N + 1) / 2>;  // upper triangles, row by row

CALOR_ALWAYS_INLINE inline Unknowns product(const SymmetricMatrix& M, const Unknowns& x) {
  Unknowns y;
  int n = 0;
  for (int a = 0; a < N; ++a) {
    y[a] += M[n++] * x[a];
    for (int b = a + 1; b < N; ++b, ++n) y[a] += M[n] * x[b], y[b] += M[n] * x[a];
  }
  return y;
}

/// Replaces positive definite matrices by their inverses, by Gauss and Jordan; row by row, one pivot after another.
CALOR_ALWAYS_INLINE inline void invert(SymmetricMatrix& M) {
  using Lanes = SymmetricMatrix::Lanes;
  Lanes A[N][N];
  for (int a = 0, n = 0; a < N; ++a)
    for (int b = a; b < N; ++b) A[a][b] = A[b][a] = M[n++];
  for (int k = 0; k < N; ++k) {
    const Lanes pivot = 1 / A[k][k];
    Lanes row[N];
    for (int b = 0; b < N; ++b) row[b] = A[k][b] * pivot, A[k][b] = row[b];
    A[k][k] = row[k] = pivot;
    for (int a = 0; a < N; ++a) {
      if (a == k) continue;
      const Lanes factor = A[a][k];
      A[a][k] = Lanes{};
      for (int b = 0; b < N; ++b) A[a][b] -= factor * row[b];
    }
  }
  for (int a = 0, n = 0; a < N; ++a)
    for (int b = a; b < N; ++b) M[n++] = 0.5 * (A[a][b] + A[b][a]);
}

SymmetricMatrix identity() {
  SymmetricMatrix I;
  for (int a = 0, n = 0; a < N; n += N - a++)
    for (double& one : I.v[n]) one = 1;
  return I;
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

/// One fit.
class MomentFit {
 public:
  MomentFit(const Cloud& cloud, const Neighbours& neighbours)
      : cloud_(cloud), changes_(cloud, neighbours), groups_((cloud.owned + lanes - 1) / lanes) {
    const std::vector<Six> moments = wanted_moments(cloud, neighbours);
    const std::vector<Vec3> sums = wanted_sums(cloud, neighbours);
    for (int i = 0; i < cloud.owned; ++i) {
      std::array<double, N> wanted;
      for (int a = 0; a < 3; ++a) wanted[a] = sums[i][a];
      for (int c = 0; c < 6; ++c) wanted[3 + c] = moments[i][c];
      if (wanted != wanted_inside(i)) at_surface_.push_back({i, wanted});
    }
  }

  /// Normal equations of the least change of g, in the metric of g:
  ///   (C g C^T + S) z = wanted - C g,  C_i: x_ji and x_ji (x) x_ji,  z_i: lambda_i and tau_i,  S: softness of (M).
  /// In the metric of the points' own blocks B_i, plus S, no eigenvalue lies beyond 2:
  ///   1/2 sum_ij g_ij (c_i + c_j)^2 <= 2 sum_i z_i.B_i z_i
  /// with the parts c_i and c_j that the unknowns of both points have in c_ij; rows are multiplied by their inverses.
  /// Returns the root mean square of G/g - 1, in the metric of g. Collective.
  double change(std::span<double> g) {
    ChebyshevSteps steps({.least = least_of_fit, .largest = 2});
    prepare(g);
    for (int step = 0; step < steps_of_fit; ++step) {
      steps.advance();
      if (step > 0) search(g, steps.beta);
      for (int i = 0; i < cloud_.owned; ++i)
        for (int a = 0; a < N; ++a) changes_.at(i)[a] += steps.alpha * groups_[i / lanes].p.v[a][i % lanes];
      changes_.update_ghosts();
    }
    std::vector<double> squares(2 * static_cast<std::size_t>(cloud_.owned));
    changes_.for_each_change([&](int i, std::int64_t n, double c) CALOR_ALWAYS_INLINE {
      squares[2 * i] += g[n] * c * c, squares[2 * i + 1] += g[n];
      g[n] *= std::max(1 + c, floor_of_fit);
    });
    const auto total = sums(cloud_.comm, squares, 2);
    return std::sqrt(total[0] / total[1]);
  }

 private:
  int owned_in(std::size_t group) const { return std::min(lanes, cloud_.owned - static_cast<int>(group) * lanes); }

  /// Of (L) and (M), away from the surface.
  std::array<double, N> wanted_inside(int i) const {
    std::array<double, N> wanted = {};
    for (int c = 0; c < cloud_.dimension; ++c) wanted[3 + c] = 2 * cloud_.volume[i];
    return wanted;
  }
  Unknowns wanted(std::size_t group) const {
    Unknowns wanted;
    const int first = static_cast<int>(group) * lanes, count = owned_in(group);
    auto own = std::ranges::lower_bound(at_surface_, first, {}, &Wanted::point);
    for (int lane = 0; lane < count; ++lane) {
      const bool is_inside = own == at_surface_.end() || own->point != first + lane;
      const std::array<double, N> sums = is_inside ? wanted_inside(first + lane) : (own++)->sums;
      for (int a = 0; a < N; ++a) wanted.v[a][lane] = sums[a];
    }
    return wanted;
  }

  /// No change yet, blocks, and p = r of the first step.
  void prepare(std::span<const double> g) {
    for (std::size_t k = 0; k < groups_.size(); ++k) {
      Group& group = groups_[k];
      Unknowns r = wanted(k);
      group.soft = {}, group.inverse = identity();
      for (int lane = 0; lane < owned_in(k); ++lane) {
        const int i = static_cast<int>(k) * lanes + lane;
        std::ranges::fill(changes_.at(i), 0);
        const Changes::Block own = changes_.block(g.data(), i);
        MatrixN B;
        std::size_t n = 0;
        for (int a = 0; a < N; ++a)
          for (int b = a; b < N; ++b) B(a, b) = B(b, a) = own.upper[n++];
        const VectorN soft = softness(cloud_, B);
        n = 0;
        for (int a = 0; a < N; ++a) {
          const double diagonal = B(a, a) + soft[a];
          group.inverse.v[n++][lane] = diagonal == 0 ? 1 : diagonal;  // components that neither has stay out
          for (int b = a + 1; b < N; ++b) group.inverse.v[n++][lane] = B(a, b);
        }
        const std::array<double, N> now = {own.first[0], own.first[1], own.first[2], B(0, 0), B(1, 1),
                                           B(2, 2),      B(0, 1),      B(0, 2),      B(1, 2)};
        for (int a = 0; a < N; ++a) r.v[a][lane] -= now[a];
        for (int c = 0; c < 6; ++c) group.soft.v[c][lane] = soft[3 + c];  // (L) is none the softer for it
      }
      run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
        invert(group.inverse);
        group.p = product(group.inverse, r);
      });
    }
  }

  /// p = r + beta p of the unknowns z as they are, r: the blocks' inverses times wanted - C g - (C g C^T + S) z.
  void search(std::span<const double> g, double beta) {
    std::array<double, lanes * N> now;
    for (std::size_t k = 0; k < groups_.size(); ++k) {
      Group& group = groups_[k];
      const int first = static_cast<int>(k) * lanes, count = owned_in(k);
      changes_.changed_sums(g.data(), first, first + count, now.data());
      Unknowns r = wanted(k), z;
      for (int lane = 0; lane < count; ++lane)
        for (int a = 0; a < N; ++a) r.v[a][lane] -= now[lane * N + a], z.v[a][lane] = changes_.at(first + lane)[a];
      run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
        for (int c = 0; c < 6; ++c) r[3 + c] -= group.soft[c] * z[3 + c];
        r = product(group.inverse, r);
        for (int a = 0; a < N; ++a) group.p[a] = r[a] + beta * group.p[a];
      });
    }
  }

  /// What a point wants that lies at the surface, or in an axisymmetric body.
  struct Wanted {
    int point;
    std::array<double, N> sums;
  };
  /// Of eight points. On clouds of many neighbours the fit needs the most memory of all that makes them: residuals,
  /// which follow from z, are not kept.
  struct Group {
    SymmetricMatrix inverse;
    Numbers<6> soft;
    Unknowns p;
  };

  const Cloud& cloud_;
  Changes changes_;  // of z
  std::vector<Group> groups_;
  std::vector<Wanted> at_surface_;  // by their points
};

}  // namespace

int fit_moments(const Cloud& cloud, const Neighbours& neighbours, std::vector<double>& g) {
  std::vector<double> base;
  int fits = 0;
  MomentFit fit(cloud, neighbours);
  while (fits < many_fits) {
    const double change = fit.change(g);
    if (++fits == few_fits && change < little) break;
    if (fits == few_fits) base = g;
    for (std::size_t n = 0; n < base.size(); ++n) g[n] = std::max(g[n], floor_of_fits * base[n]);
  }
  return fits * steps_of_fit;
}

}  // namespace calor
