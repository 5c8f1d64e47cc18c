// The fit of second moments (M) and linear consistency (L) together: one least change of the weights towards both.
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
constexpr int diagonal(int a) { return a * N - a * (a - 1) / 2; }

/// Moments of second to fourth order, as numerous as a block has entries that differ.
constexpr int moments = 31;
/// Which of them an entry of the upper triangle is: products of the same powers of x, y and z are one moment.
constexpr auto moment_of = [] {
  constexpr int powers[N] = {100, 10, 1, 200, 20, 2, 110, 101, 11};
  std::array<int, N*(N + 1) / 2> moment = {}, known = {};
  int count = 0, n = 0;
  for (int a = 0; a < N; ++a) {
    for (int b = a; b < N; ++b, ++n) {
      int k = 0;
      while (k < count && known[k] != powers[a] + powers[b]) ++k;
      if (k == count) known[count++] = powers[a] + powers[b];
      moment[n] = k;
    }
  }
  return moment;
}();
/// Where xx yy zz xy xz yz stand in the upper triangle.
constexpr int square[6] = {diagonal(0), diagonal(1), diagonal(2), 1, 2, diagonal(1) + 1};
static_assert(*std::ranges::max_element(moment_of) == moments - 1);

/// M^-1 b of positive definite M, by elimination.
CALOR_ALWAYS_INLINE inline Unknowns solution(SymmetricMatrix M, Unknowns b) {
  using Lanes = SymmetricMatrix::Lanes;
  Lanes over_pivot[N];
#pragma GCC unroll 9
  for (int k = 0; k < N; ++k) {
    const int row = diagonal(k) - k;
    over_pivot[k] = 1 / M[row + k];
    for (int a = k + 1; a < N; ++a) {
      const Lanes factor = M[row + a] * over_pivot[k];
      for (int c = a; c < N; ++c) M[diagonal(a) - a + c] -= factor * M[row + c];
      b[a] -= factor * b[k];
    }
  }
#pragma GCC unroll 9
  for (int k = N - 1; k >= 0; --k) {
    for (int a = k + 1; a < N; ++a) b[k] -= M[diagonal(k) - k + a] * b[a];
    b[k] *= over_pivot[k];
  }
  return b;
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

/// Blocks of eight points, regular, and what softens their rows.
struct Blocks {
  SymmetricMatrix matrix;
  Unknowns soft;
};

/// What softens the rows of (M), and keeps blocks of points regular whose neighbours lie in a plane or on a line: parts
/// of the diagonal. On isotropic clouds it is the diagonal that neighbours alike in all directions would give, so that
/// the fit turns with the body.
CALOR_ALWAYS_INLINE inline Blocks soft_blocks(const Cloud& cloud, const Numbers<moments>& moment) {
  using Lanes = SymmetricMatrix::Lanes;
  Blocks B;
  for (std::size_t n = 0; n < moment_of.size(); ++n) B.matrix[n] = moment[moment_of[n]];
  const auto entry = [&](int a, int b) CALOR_ALWAYS_INLINE { return B.matrix[diagonal(a) - a + b]; };
  const int D = cloud.dimension;
  const Lanes second = (entry(0, 0) + entry(1, 1) + entry(2, 2)) / D,
              fourth = (entry(3, 3) + entry(4, 4) + entry(5, 5) + 2 * (entry(3, 4) + entry(3, 5) + entry(4, 5))) /
                       (D * (D + 2));
  const double softness = cloud.nearest_volumes ? softness_of_nearest : softness_of_others;
  for (int c = 0; c < N; ++c) {
    const Lanes own = entry(c, c), alike = c < 3 ? second : (c < 6 ? 3.0 : 1.5) * fourth;
    B.soft[c] = (c < 3 ? softness_of_nearest : softness) * (cloud.isotropic ? own > 0 ? alike : own : own);
    const Lanes sum = own + B.soft[c];
    B.matrix[diagonal(c)] = sum == 0 ? sum + 1 : sum;  // components that neither has stay out
  }
  return B;
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

  /// No change yet, moments, and p = r of the first step.
  void prepare(std::span<const double> g) {
    for (std::size_t k = 0; k < groups_.size(); ++k) {
      Group& group = groups_[k];
      Unknowns r = wanted(k);
      group.moment = {};
      for (int lane = 0; lane < owned_in(k); ++lane) {
        const int i = static_cast<int>(k) * lanes + lane;
        std::ranges::fill(changes_.at(i), 0);
        const Changes::Block own = changes_.block(g.data(), i);
        for (std::size_t n = 0; n < own.upper.size(); ++n) group.moment.v[moment_of[n]][lane] = own.upper[n];
        for (int a = 0; a < 3; ++a) r.v[a][lane] -= own.first[a];
        for (int c = 0; c < 6; ++c) r.v[3 + c][lane] -= own.upper[square[c]];
      }
      run_vectorised([&]<int>()
                         CALOR_ALWAYS_INLINE { group.p = solution(soft_blocks(cloud_, group.moment).matrix, r); });
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
        const Blocks B = soft_blocks(cloud_, group.moment);
        for (int a = 3; a < N; ++a) r[a] -= B.soft[a] * z[a];  // (L) is none the softer for it
        r = solution(B.matrix, r);
        for (int a = 0; a < N; ++a) group.p[a] = r[a] + beta * group.p[a];
      });
    }
  }

  /// What a point wants that lies at the surface, or in an axisymmetric body.
  struct Wanted {
    int point;
    std::array<double, N> sums;
  };
  /// Of eight points. The fit needs the most memory of all that makes a cloud: what follows from z and the moments,
  /// residuals and inverses, is not kept.
  struct Group {
    Numbers<moments> moment;
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
