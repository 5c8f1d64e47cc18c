#include "conduction/coarse_truss.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"
#include "base/simd.hpp"
#include "cloud/cells.hpp"

namespace calor {

namespace {

constexpr double least_width = 3;  // of a cell, in spacings
constexpr std::int32_t most_nodes = 1000;
/// Of the diagonal: holds the rigid motions, which the stiffness does not see, and keeps what rounding leaves of them
/// in the residual from growing.
constexpr double hold = 1e-3;

/// Adds numbers as integers, so that neither order nor ranks change a bit.
class ExactSums {
 public:
  /// Sums of no more than 2^22 numbers within `largest` each.
  ExactSums(std::size_t count, double largest)
      : scale_(largest > 0 ? std::ldexp(1, 40 - std::ilogb(largest)) : 0), sums_(count) {}
  void add(std::size_t n, double value) { sums_[n] += std::llrint(scale_ * value); }
  std::vector<double> total(MPI_Comm comm) {
    add_up(comm, sums_);
    std::vector<double> values;
    for (const std::int64_t s : sums_) values.push_back(s == 0 ? 0 : static_cast<double>(s) / scale_);
    return values;
  }

 private:
  double scale_;
  std::vector<std::int64_t> sums_;
};

/// c_i of the owned points.
std::vector<double> energies(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g) {
  std::vector<double> c(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    double fourth = 0;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 xi = quotient(neighbours.x_ji(cloud.x, i, n), cloud.metric[i]);
      fourth += g[n] * dot(xi, xi) * dot(xi, xi);
    }
    c[i] = fourth / (2 * cloud.dimension * (cloud.dimension + 2));
  }
  return c;
}

Vec3 mean_metric(const Cloud& cloud) {
  std::vector<double> numbers;
  for (int i = 0; i < cloud.owned; ++i)
    numbers.insert(numbers.end(), {cloud.metric[i].x, cloud.metric[i].y, cloud.metric[i].z});
  const auto s = sums(cloud.comm, numbers, 3);
  return (1 / static_cast<double>(cloud.count)) * Vec3{s[0], s[1], s[2]};
}

/// Numbers of the eight corners of a cell; corner k has the bits of its coordinates.
using Corners = Doubles<8>;

/// Values of the corners' functions at a place of the unit cell.
CALOR_ALWAYS_INLINE inline Corners tents(const Vec3& at) {
  const double x = at.x, y = at.y, z = at.z;
  const Corners along_x = {1 - x, x, 1 - x, x, 1 - x, x, 1 - x, x};
  const Corners along_y = {1 - y, 1 - y, y, y, 1 - y, 1 - y, y, y};
  const Corners along_z = {1 - z, 1 - z, 1 - z, 1 - z, z, z, z, z};
  return along_x * along_y * along_z;
}

/// The three components at the corners of a cell.
struct CellVectors {
  double v[3][8] = {};
  CALOR_ALWAYS_INLINE UnalignedDoubles<8>& operator[](int a) { return *reinterpret_cast<UnalignedDoubles<8>*>(v[a]); }
};

using Matrix3 = std::array<std::array<double, 3>, 3>;
using CellMatrix = std::array<std::array<Matrix3, 8>, 8>;

/// Mean over the unit cell of d_a N_k d_b N_l, d_a = scale_a d/dx_a, by two Gauss points along every axis.
CellMatrix products_of_slopes(const Vec3& scale) {
  CellMatrix M = {};
  const double gauss = 0.5 / std::sqrt(3.0);
  for (int q = 0; q < 8; ++q) {
    Vec3 at;
    for (int a = 0; a < 3; ++a) at[a] = 0.5 + (q >> a & 1 ? gauss : -gauss);
    std::array<Vec3, 8> slope;
    for (int k = 0; k < 8; ++k) {
      for (int a = 0; a < 3; ++a) {
        slope[k][a] = (k >> a & 1 ? 1 : -1) * scale[a];
        for (int b = 0; b < 3; ++b)
          if (b != a) slope[k][a] *= k >> b & 1 ? at[b] : 1 - at[b];
      }
    }
    for (int k = 0; k < 8; ++k)
      for (int l = 0; l < 8; ++l)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) M[k][l][a][b] += slope[k][a] * slope[l][b] / 8;
  }
  return M;
}

}  // namespace

struct CoarseTruss::Factor {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
};

CoarseTruss::~CoarseTruss() = default;

CoarseTruss::CoarseTruss(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g, const Vec3& unit,
                         const std::array<bool, 3>& held)
    : cloud_(cloud), factor_(std::make_unique<Factor>()) {
  const Vec3 metric = mean_metric(cloud);
  lay_grid(metric);

  const std::vector<double> c = energies(cloud, neighbours, g);
  double largest = 0;
  for (const double e : c) largest = std::max(largest, e);
  ExactSums sums(nodes(), max(cloud.comm, largest));
  for (int i = 0; i < cloud.owned; ++i) places_.push_back(place(cloud.x[i])), sums.add(places_[i].cell, c[i]);
  const std::vector<double> energy = sums.total(cloud.comm);  // of the cells, by their lowest corner

  // lambda^T K lambda = sum c [(tr E)^2 + 2 E : E] with 2 E_ab = s_a s_b (d_b lambda_a + d_a lambda_b).
  const int D = cloud.dimension;
  const CellMatrix M = products_of_slopes(product(metric, over_width_));
  const Vec3 scale = product(metric, unit);
  const auto is_held = [&](std::int32_t node, int a) {
    std::int32_t at = node;
    for (int b = 0; b < a; ++b) at /= along_[b];
    at %= along_[a];
    return held[a] && (at == 0 || at == along_[a] - 1);
  };
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> diagonal(static_cast<std::size_t>(D) * nodes());
  for (std::int32_t cell = 0; cell < nodes(); ++cell) {
    if (energy[cell] == 0) continue;
    for (int k = 0; k < 8; ++k) {
      for (int l = 0; l < 8; ++l) {
        const Matrix3& m = M[k][l];
        const double trace = m[0][0] + m[1][1] + m[2][2];
        for (int a = 0; a < D; ++a) {
          for (int b = 0; b < D; ++b) {
            const std::int32_t row = cell + corner_[k], column = cell + corner_[l];
            if (is_held(row, a) || is_held(column, b)) continue;
            const double entry = energy[cell] * scale[a] * scale[b] * (m[a][b] + m[b][a] + (a == b ? trace : 0));
            entries.emplace_back(D * row + a, D * column + b, entry);
            if (row == column && a == b) diagonal[D * row + a] += entry;
          }
        }
      }
    }
  }
  for (std::size_t n = 0; n < diagonal.size(); ++n) {
    const int k = static_cast<int>(n);
    entries.emplace_back(k, k, diagonal[n] > 0 ? hold * diagonal[n] : 1);
  }
  Eigen::SparseMatrix<double> K(D * nodes(), D * nodes());
  K.setFromTriplets(entries.begin(), entries.end());
  factor_->solver.compute(K);
}

void CoarseTruss::lay_grid(const Vec3& metric) {
  Bounds body = bounds_of(std::span(cloud_.x).first(cloud_.owned));
  Vec3 width;
  for (int a = 0; a < 3; ++a) {
    low_[a] = min(cloud_.comm, body.low[a]);
    width[a] = max(cloud_.comm, body.high[a]) - low_[a];
  }
  const Vec3 size = width;
  for (double spacings = least_width;; spacings *= 1.1) {
    for (int a = 0; a < cloud_.dimension; ++a) {
      const double cells = std::clamp(std::floor(size[a] / (spacings * metric[a])), 1.0, double{most_nodes});
      along_[a] = size[a] > 0 ? static_cast<std::int32_t>(cells) + 1 : 1;
    }
    if (std::int64_t{along_[0]} * along_[1] * along_[2] <= most_nodes) break;
  }
  std::int32_t stride = 1;
  for (int a = 0; a < 3; ++a) {
    over_width_[a] = along_[a] > 1 ? (along_[a] - 1) / size[a] : 0;
    for (int k = 0; k < 8 && along_[a] > 1; ++k) corner_[k] += (k >> a & 1) * stride;
    stride *= along_[a];
  }
}

CoarseTruss::Place CoarseTruss::place(const Vec3& x) const {
  std::int32_t node = 0, stride = 1;
  Vec3 at;
  for (int a = 0; a < 3; ++a) {
    const double along = (x[a] - low_[a]) * over_width_[a];
    const std::int32_t cell = std::clamp(static_cast<std::int32_t>(along), 0, std::max(along_[a] - 2, 0));
    at[a] = along - cell;
    node += stride * cell;
    stride *= along_[a];
  }
  return {node, at};
}

void CoarseTruss::add_solution(std::span<const double> r, std::span<double> z) const {
  // Sums over the points of a cell, of values rounded to 2^-30 of the largest; whole numbers below 2^53, for 2^22
  // points a cell, add up without error.
  const int D = cloud_.dimension;
  double largest = 0;
  for (const double v : r) largest = std::max(largest, std::abs(v));
  largest = max(cloud_.comm, largest);
  if (largest == 0) return;
  const double scale = std::ldexp(1, 30 - std::ilogb(largest));
  std::vector<CellVectors> cells(nodes());
  run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
    constexpr double whole = 0x1.8p52;  // rounds what is added to it
    for (int i = 0; i < cloud_.owned; ++i) {
      const Place& p = places_[i];
      const Corners value = scale * tents(p.at);
      for (int a = 0; a < D; ++a) cells[p.cell][a] += (value * r[3 * i + a] + whole) - whole;
    }
  });
  std::vector<std::int64_t> sums(static_cast<std::size_t>(D) * nodes());
  for (std::int32_t cell = 0; cell < nodes(); ++cell)
    for (int a = 0; a < D; ++a)
      for (int k = 0; k < 8; ++k)
        if (const double sum = cells[cell].v[a][k]; sum != 0)
          sums[D * (cell + corner_[k]) + a] += static_cast<std::int64_t>(sum);
  add_up(cloud_.comm, sums);

  Eigen::VectorXd coarse(static_cast<Eigen::Index>(sums.size()));
  for (std::size_t n = 0; n < sums.size(); ++n)
    coarse[static_cast<Eigen::Index>(n)] = static_cast<double>(sums[n]) / scale;
  coarse = factor_->solver.solve(coarse).eval();
  for (std::int32_t cell = 0; cell < nodes(); ++cell)
    for (int a = 0; a < D; ++a)
      for (int k = 0; k < 8; ++k)
        if (const std::int32_t node = cell + corner_[k]; node < nodes()) cells[cell].v[a][k] = coarse[D * node + a];
  run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
    for (int i = 0; i < cloud_.owned; ++i) {
      const Place& p = places_[i];
      const Corners value = tents(p.at);
      for (int a = 0; a < D; ++a) {
        const Corners v = value * cells[p.cell][a];
        z[3 * i + a] += ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
      }
    }
  });
}

}  // namespace calor
