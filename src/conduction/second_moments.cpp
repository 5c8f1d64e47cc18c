// Sinkhorn scaling of the traces and soft fit of the whole second moments.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "conduction/correction.hpp"
#include "conduction/linear_algebra.hpp"

namespace calor {

namespace {

/// Every sweep halves, at least, what is off.
constexpr int sinkhorn_sweeps = 10;
/// Steps of the fit, and the least eigenvalue that it damps. (M) is over-determined, so the fit must not be exact: what
/// these steps leave, fields that change their sign from point to point, is neither in the errors nor better known from
/// volumes. Fits solved to the end give the same errors within 3 % on jittered squares and cubes, tubes and plates with
/// holes.
constexpr int steps_of_fit = 4;
constexpr double least_of_fit = 0.3;
/// Of the diagonal: keeps the blocks of points regular that see too few others for six unknowns; and (M) is no truer
/// than the volumes: sectors of rings are not the cells of their points.
constexpr double softness_of_nearest = 1e-3, softness_of_sectors = 0.2;
constexpr double softness_at_cracks = 1e-3;
constexpr double floor_of_fit = 0.02;

/// xx, yy, zz, xy, xz, yz of a (x) a, or of a symmetric tensor.
using Six = std::array<double, 6>;

Six products(const Vec3& a) { return {a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.x * a.z, a.y * a.z}; }

/// Six numbers per local point, as two fields that the halo can exchange.
struct TensorField {
  std::vector<Vec3> diagonal, mixed;

  explicit TensorField(const Cloud& cloud) : diagonal(cloud.local()), mixed(cloud.local()) {}
  void update(const Halo& halo) {
    halo.update(std::span<Vec3>(diagonal));
    halo.update(std::span<Vec3>(mixed));
  }
  /// q : (tau_i + tau_j) of entry n in row i, the same bits for (j, i). A reflected tensor changes the signs of its
  /// mixed components.
  template <bool has_images>
  double sum_at(const Six& q, const PairVectors<has_images>& pair, int i, std::int64_t n) const {
    const int j = pair.neighbours.column[n];
    Vec3 mixed_j = mixed[j];
    if constexpr (has_images) {
      const Vec3& s = pair.neighbours.mirrors[pair.neighbours.image[n]].sign;
      mixed_j = {s.x * s.y * mixed_j.x, s.x * s.z * mixed_j.y, s.y * s.z * mixed_j.z};
    }
    const Vec3 d = diagonal[i] + diagonal[j], m = mixed[i] + mixed_j;
    return q[0] * d.x + q[1] * d.y + q[2] * d.z + q[3] * m.x + q[4] * m.y + q[5] * m.z;
  }
  /// tau_i, its mixed components twice, of an owned point.
  void set(int i, double s, const Six& t) {
    diagonal[i] = {s * t[0], s * t[1], s * t[2]};
    mixed[i] = {s * t[3], s * t[4], s * t[5]};
  }
};

/// Calls use(i, sum_j g_ij [x_ji.(tau_i + tau_j) x_ji] x_ji (x) x_ji) for the owned points.
template <class Use>
void for_each_change(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g,
                     const TensorField& tau, const Use& use) {
  with_pair_vectors(neighbours, cloud.x, [&](const auto& pair) {
    for (int i = 0; i < cloud.owned; ++i) {
      Six sum = {};
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const Six q = products(pair.x_ji(i, n));
        const double s = g[n] * tau.sum_at(q, pair, i, n);
        for (int c = 0; c < 6; ++c) sum[c] += s * q[c];
      }
      use(i, sum);
    }
  });
}

/// g_ij <- g_ij [1 + x_ji.(tau_i + tau_j) x_ji], not below 0.02 g_ij.
void change(const Cloud& cloud, const Neighbours& neighbours, const TensorField& tau, std::span<double> g) {
  with_pair_vectors(neighbours, cloud.x, [&](const auto& pair) {
    for (int i = 0; i < cloud.owned; ++i)
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
        g[n] *= std::max(1 + tau.sum_at(products(pair.x_ji(i, n)), pair, i, n), floor_of_fit);
  });
}

/// Symmetric 6 x 6 matrix of a point; the upper triangle, row by row.
class Block {
 public:
  void add(double w, const Six& q) {
    std::size_t n = 0;
    for (int a = 0; a < 6; ++a)
      for (int b = a; b < 6; ++b) entries_[n++] += w * q[a] * q[b];
  }
  Six diagonal() const { return {entries_[0], entries_[6], entries_[11], entries_[15], entries_[18], entries_[20]}; }

  /// Inverse of the matrix plus a diagonal; components that neither has stay out.
  Block inverse(const Six& diagonal) const {
    Eigen::Matrix<double, 6, 6> M;
    std::size_t n = 0;
    for (int a = 0; a < 6; ++a)
      for (int b = a; b < 6; ++b) M(a, b) = M(b, a) = entries_[n++];
    for (int a = 0; a < 6; ++a)
      if ((M(a, a) += diagonal[a]) == 0) M(a, a) = 1;
    M = M.llt().solve(Eigen::Matrix<double, 6, 6>::Identity()).eval();
    Block inverse;
    n = 0;
    for (int a = 0; a < 6; ++a)
      for (int b = a; b < 6; ++b) inverse.entries_[n++] = 0.5 * (M(a, b) + M(b, a));
    return inverse;
  }

  Six operator*(const Six& x) const {
    Six y = {};
    std::size_t n = 0;
    for (int a = 0; a < 6; ++a) {
      y[a] += entries_[n++] * x[a];
      for (int b = a + 1; b < 6; ++b, ++n) y[a] += entries_[n] * x[b], y[b] += entries_[n] * x[a];
    }
    return y;
  }

 private:
  std::array<double, 21> entries_ = {};
};

}  // namespace

namespace {

/// Factors of the local points with sum_j w_ij a_i a_j = 2 D volume_i.
std::vector<double> sinkhorn_factors(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume,
                                     std::span<const double> w) {
  std::vector<double> a(cloud.local(), 1.0), scaled(cloud.owned);
  for (int sweep = 0; sweep < sinkhorn_sweeps; ++sweep) {
    for (int i = 0; i < cloud.owned; ++i) {
      double sum = 0;
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) sum += w[n] * a[neighbours.column[n]];
      scaled[i] = std::sqrt(a[i] * (2 * cloud.dimension * volume[i] / sum));
    }
    std::copy(scaled.begin(), scaled.end(), a.begin());
    cloud.halo.update(std::span<double>(a));
  }
  return a;
}

void scale(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> a, std::span<double> w) {
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) w[n] *= a[i] * a[neighbours.column[n]];
}

}  // namespace

void scale_sums(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume, std::span<double> w) {
  scale(cloud, neighbours, sinkhorn_factors(cloud, neighbours, volume, w), w);
}

void scale_traces(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume,
                  std::span<double> g) {
  std::vector<double> trace(g.size());
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 r = neighbours.x_ji(cloud.x, i, n);
      trace[n] = g[n] * dot(r, r);
    }
  }
  scale(cloud, neighbours, sinkhorn_factors(cloud, neighbours, volume, trace), g);
}

int fit_second_moments(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g) {
  // Normal equations of the least change of g, in the metric of g:
  //   (M g M^T + S) tau = rhs - M g,  M_i = x_ji (x) x_ji,  rhs_i = 2 V_i I,  S: softness times a diagonal.
  // Off the walls, a facet at the distance y carries 2 A y n (x) n of rhs: the heat of a quadratic temperature that
  // passes the wall. In the metric of the points' own blocks B_i = sum_j g_ij M_i (x) M_i, plus S, no eigenvalue lies
  // beyond 2: 1/2 sum_ij g_ij (M_i.tau_i + M_i.tau_j)^2 <= 2 sum_i tau_i.B_i tau_i; rows are multiplied by their
  // inverses.
  const auto& x = cloud.x;
  const double softness = cloud.nearest_volumes ? softness_of_nearest : softness_of_sectors;
  const std::size_t unknowns = 6 * static_cast<std::size_t>(cloud.owned);
  std::vector<double> rhs(unknowns), z(unknowns);
  std::vector<Block> inverse(cloud.owned);
  std::vector<Six> soft(cloud.owned);
  std::size_t facet = 0;  // they are sorted by point
  for (int i = 0; i < cloud.owned; ++i) {
    Six R = {};
    Block block;
    double fourth = 0;
    for (int c = 0; c < cloud.dimension; ++c) R[c] = 2 * cloud.volume[i];
    if (cloud.axisymmetric) R[0] += 2 * cloud.moment[i].x, R[3] += cloud.moment[i].y;
    for (; !cloud.points_on_walls && facet < cloud.facets.size() && cloud.facets[facet].point == i; ++facet) {
      if (!neighbours.mirrored.empty() && neighbours.mirrored[facet]) continue;
      const Facet& p = cloud.facets[facet];
      const Six q = products(p.normal);
      for (int c = 0; c < 6; ++c) R[c] -= 2 * p.area * wall_distance(cloud, p) * q[c];
    }
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 r = neighbours.x_ji(x, i, n);
      const Six q = products(r);
      for (int c = 0; c < 6; ++c) R[c] -= g[n] * q[c];
      block.add(g[n], q);
      fourth += g[n] * dot(r, r) * dot(r, r);
    }
    Six& diagonal = soft[i] = block.diagonal();
    if (cloud.isotropic) {
      // The diagonal that neighbours alike in all directions would give, so that the fit turns with the body.
      const int D = cloud.dimension;
      for (int c = 0; c < 6; ++c)
        if (diagonal[c] > 0) diagonal[c] = fourth * (c < 3 ? 3.0 : 1.5) / (D * (D + 2));
    }
    for (double& d : diagonal) d *= softness;
    inverse[i] = block.inverse(diagonal);
    std::ranges::copy(inverse[i] * R, rhs.begin() + 6 * static_cast<std::ptrdiff_t>(i));
  }

  TensorField tau(cloud);
  const auto set_tau = [&](std::span<const double> p) {
    for (int i = 0; i < cloud.owned; ++i) {
      Six t;
      std::copy_n(p.begin() + 6 * static_cast<std::ptrdiff_t>(i), 6, t.begin());
      tau.set(i, 1, t);
    }
    tau.update(cloud.halo);
  };
  const LinearMap normal_matrix = [&](std::span<const double> p, std::span<double> y) {
    set_tau(p);
    for_each_change(cloud, neighbours, g, tau, [&](int i, Six& sum) {
      for (int c = 0; c < 6; ++c) sum[c] += soft[i][c] * p[6 * i + c];
      std::ranges::copy(inverse[i] * sum, y.begin() + 6 * static_cast<std::ptrdiff_t>(i));
    });
  };
  chebyshev(normal_matrix, rhs, z, {.least = least_of_fit, .largest = 2, .steps = steps_of_fit});
  set_tau(z);
  change(cloud, neighbours, tau, g);
  return steps_of_fit;
}

void restore_second_moments(const Cloud& cloud, const Neighbours& neighbours, std::span<const Symmetric3> P,
                            std::span<const double> missing, std::span<double> g) {
  // As above, of every tensor only its multiple of P_i. With p such that x.P_i x = p . products(x):
  const auto p = [&](int i) {
    const Symmetric3& t = P[i];
    return Six{t.xx, t.yy, t.zz, 2 * t.xy, 2 * t.xz, 2 * t.yz};
  };
  const auto dot = [](const Six& a, const Six& b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); };
  std::vector<double> diagonal(cloud.owned), rhs(cloud.owned), z(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const double q = dot(p(i), products(neighbours.x_ji(cloud.x, i, n))) / cloud.spacing[i];
      diagonal[i] += g[n] * q * q;
    }
    if (diagonal[i] > 0) rhs[i] = missing[i] / cloud.spacing[i];
  }
  TensorField tau(cloud);
  const auto set_tau = [&](std::span<const double> z) {
    for (int i = 0; i < cloud.owned; ++i) tau.set(i, z[i] / cloud.spacing[i], p(i));
    tau.update(cloud.halo);
  };
  const LinearMap normal_matrix = [&](std::span<const double> z, std::span<double> y) {
    set_tau(z);
    for_each_change(cloud, neighbours, g, tau, [&](int i, const Six& sum) {
      y[i] = dot(p(i), sum) / cloud.spacing[i] + softness_at_cracks * diagonal[i] * z[i];
    });
  };
  const LinearMap scaling = [&](std::span<const double> r, std::span<double> y) {
    for (std::size_t i = 0; i < r.size(); ++i) y[i] = diagonal[i] > 0 ? r[i] / diagonal[i] : 0;
  };
  conjugate_gradients(cloud.comm, normal_matrix, scaling, rhs, z, {.relative = 1e-11, .iterations = 1000});
  set_tau(z);
  change(cloud, neighbours, tau, g);
}

}  // namespace calor
