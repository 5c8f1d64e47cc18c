// Sinkhorn scaling of the traces, and second moments of points beside cracks.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/parallel.hpp"
#include "conduction/correction.hpp"
#include "conduction/linear_algebra.hpp"
#include "conduction/pair_changes.hpp"

namespace calor {

namespace {

/// Every sweep halves, at least, what is off.
constexpr int sinkhorn_sweeps = 10;
constexpr double softness_at_cracks = 1e-3;
constexpr double floor_of_fit = 0.02;

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

}  // namespace

void scale_sums(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume, std::span<double> w) {
  const std::vector<double> a = sinkhorn_factors(cloud, neighbours, volume, w);
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) w[n] *= a[i] * a[neighbours.column[n]];
}

void scale_traces(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume,
                  std::span<double> g) {
  const auto square = [&](int i, std::int64_t n) {
    const Vec3 r = neighbours.x_ji(cloud.x, i, n);
    return dot(r, r);
  };
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) g[n] *= square(i, n);
  scale_sums(cloud, neighbours, volume, g);
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) g[n] /= square(i, n);
}

void restore_second_moments(const Cloud& cloud, const Neighbours& neighbours, std::span<const Symmetric3> P,
                            std::span<const double> wanted, std::span<double> g) {
  // As above, of every tensor only its multiple of P_i. With p such that x.P_i x = p . products(x):
  const auto p = [&](int i) {
    const Symmetric3& t = P[i];
    return Six{t.xx, t.yy, t.zz, 2 * t.xy, 2 * t.xz, 2 * t.yz};
  };
  const auto dot = [](const Six& a, const Six& b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); };
  std::vector<double> diagonal(cloud.owned), r(cloud.owned), z(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    double now = 0;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const double q = dot(p(i), products(neighbours.x_ji(cloud.x, i, n)));
      now += g[n] * q;
      diagonal[i] += g[n] * (q / cloud.spacing[i]) * (q / cloud.spacing[i]);
    }
    if (diagonal[i] > 0) r[i] = (wanted[i] - now) / cloud.spacing[i];
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
  conjugate_gradients(cloud.comm, normal_matrix, scaling, r, z, {.relative = 1e-11, .iterations = 1000});
  set_tau(z);
  change(cloud, neighbours, tau, g);
}

}  // namespace calor
