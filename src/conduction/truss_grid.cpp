#include "conduction/truss_grid.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "conduction/linear_algebra.hpp"

namespace calor {

namespace {

/// Of the diagonal: holds the rigid motions, which the stiffness does not see, and keeps what rounding leaves of them
/// in the residual from growing.
constexpr double hold = 1e-3;
/// Steps of smoothing, and the part of the eigenvalues that it damps.
constexpr int smoothing_steps = 3;
constexpr double smoothed_part = 0.08;

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

struct TrussGrid::Factor {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
};

TrussGrid::~TrussGrid() = default;

TrussGrid::TrussGrid(const Bounds& body, const Vec3& spacing, int dimension, double width, std::int32_t most_nodes)
    : dimension_(dimension), low_(body.low), spacing_(spacing) {
  const Vec3 size = body.high - body.low;
  for (double spacings = width;; spacings *= 1.1) {
    for (int a = 0; a < dimension; ++a) {
      const double cells =
          std::clamp(std::floor(size[a] / (spacings * spacing[a])), 1.0, static_cast<double>(most_nodes));
      along_[a] = size[a] > 0 ? static_cast<std::int32_t>(cells) + 1 : 1;
    }
    if (std::int64_t{along_[0]} * along_[1] * along_[2] <= most_nodes) break;
  }
  std::int32_t stride = 1;
  for (int a = 0; a < 3; ++a) {
    width_[a] = along_[a] > 1 ? size[a] / (along_[a] - 1) : 0;
    over_width_[a] = along_[a] > 1 ? (along_[a] - 1) / size[a] : 0;
    for (int k = 0; k < 8 && along_[a] > 1; ++k) corner_[k] += (k >> a & 1) * stride;
    stride *= along_[a];
  }
}

Vec3 TrussGrid::node(std::int32_t n) const {
  Vec3 x = low_;
  for (int a = 0; a < 3; n /= along_[a++]) x[a] += n % along_[a] * width_[a];
  return x;
}

bool TrussGrid::is_held(std::int32_t node, int a) const {
  for (int b = 0; b < a; ++b) node /= along_[b];
  node %= along_[a];
  return held_[a] && (node == 0 || node == along_[a] - 1);
}

void TrussGrid::add_to_nodes(const CellVectors& cell, std::int32_t n, std::span<double> u) const {
  for (int k = 0; k < 8; ++k)
    if (const std::int32_t at = n + corner_[k]; at < nodes())
      for (int a = 0; a < 3; ++a) u[3 * at + a] += cell.v[a][k];
}

TrussGrid::CellVectors TrussGrid::corners(std::int32_t n, std::span<const double> u) const {
  CellVectors cell;
  for (int k = 0; k < 8; ++k)
    if (const std::int32_t at = n + corner_[k]; at < nodes())
      for (int a = 0; a < 3; ++a) cell.v[a][k] = u[3 * at + a];
  return cell;
}

TrussGrid::Matrix TrussGrid::cell_matrix(const Vec3& unit) const {
  // lambda^T K lambda = sum e [(tr E)^2 + 2 E : E] with 2 E_ab = s_a s_b (d_b lambda_a + d_a lambda_b).
  const CellMatrix products = products_of_slopes(product(spacing_, over_width_));
  const Vec3 scale = product(spacing_, unit);
  int corners = 0;  // bits of the axes along which there are cells; corners that coincide become one
  for (int a = 0; a < 3; ++a) corners |= (along_[a] > 1) << a;
  Matrix M = {};
  for (int k = 0; k < 8; ++k) {
    for (int l = 0; l < 8; ++l) {
      const Matrix3& m = products[k][l];
      const double trace = m[0][0] + m[1][1] + m[2][2];
      for (int a = 0; a < dimension_; ++a)
        for (int b = 0; b < dimension_; ++b)
          M[8 * a + (k & corners)][8 * b + (l & corners)] +=
              scale[a] * scale[b] * (m[a][b] + m[b][a] + (a == b ? trace : 0));
    }
  }
  return M;
}

void TrussGrid::set_energies(std::vector<double> energy, const Vec3& unit, const std::array<bool, 3>& held) {
  energy_ = std::move(energy), held_ = held;
  const Matrix M = cell_matrix(unit);
  diagonal_.assign(3 * static_cast<std::size_t>(nodes()), 0);
  for (std::int32_t n = 0; n < nodes(); ++n) {
    if (energy_[n] == 0) continue;
    for (int k = 0; k < 8; ++k)
      for (int a = 0; a < dimension_; ++a)
        if (const std::int32_t at = n + corner_[k]; M[8 * a + k][8 * a + k] > 0 && !is_held(at, a))
          diagonal_[3 * at + a] += energy_[n] * M[8 * a + k][8 * a + k];
  }
  column_.resize(72);
  for (int column = 0; column < 24; ++column)
    for (int a = 0; a < 3; ++a)
      for (int k = 0; k < 8; ++k) column_[3 * column + a][k] = M[8 * a + k][column];
  find_largest_eigenvalue(M);
}

void TrussGrid::find_largest_eigenvalue(const Matrix& M) {
  // No larger than that of a single cell, whose diagonal is its part of that of all.
  Eigen::Matrix<double, 24, 24> scaled;
  for (int m = 0; m < 24; ++m)
    for (int n = 0; n < 24; ++n) {
      const double square = M[m][m] * M[n][n];
      scaled(m, n) = square > 0 ? M[m][n] / std::sqrt(square) : 0;
    }
  largest_ = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 24, 24>>(scaled).eigenvalues().maxCoeff();
}

void TrussGrid::multiply(std::span<const double> p, std::span<double> y) const {
  std::ranges::fill(y, 0.0);
  run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
    for (std::int32_t n = 0; n < nodes(); ++n) {
      if (energy_[n] == 0) continue;
      double own[24];
      for (int k = 0; k < 8; ++k)
        for (int b = 0; b < 3; ++b) own[8 * b + k] = energy_[n] * p[3 * (n + corner_[k]) + b];
      Corners sum[3] = {};
      for (int column = 0; column < 24; ++column)
        for (int a = 0; a < 3; ++a)
          sum[a] += own[column] * *reinterpret_cast<const UnalignedDoubles<8>*>(column_[3 * column + a].data());
      for (int k = 0; k < 8; ++k)
        for (int a = 0; a < 3; ++a) y[3 * (n + corner_[k]) + a] += sum[a][k];
    }
  });
  for (std::size_t n = 0; n < y.size(); ++n)
    if (diagonal_[n] == 0) y[n] = 0;
}

void TrussGrid::smooth(std::span<double> p, std::span<double> r) const {
  std::vector<double> direction(r.size()), Kd(r.size());
  ChebyshevSteps steps({.least = smoothed_part * largest_, .largest = largest_});
  for (int step = 0; step < smoothing_steps; ++step) {
    steps.advance();
    for (std::size_t n = 0; n < r.size(); ++n) {
      direction[n] = (diagonal_[n] > 0 ? r[n] / diagonal_[n] : 0) + steps.beta * direction[n];
      p[n] += steps.alpha * direction[n];
    }
    multiply(direction, Kd);
    for (std::size_t n = 0; n < r.size(); ++n) r[n] -= steps.alpha * Kd[n];
  }
}

void TrussGrid::factorise() {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::int32_t n = 0; n < nodes(); ++n) {
    if (energy_[n] == 0) continue;
    for (int column = 0; column < 24; ++column) {
      const std::int32_t to = 3 * (n + corner_[column % 8]) + column / 8;
      for (int a = 0; a < 3; ++a)
        for (int k = 0; k < 8; ++k) {
          const std::int32_t from = 3 * (n + corner_[k]) + a;
          const double entry = column_[3 * column + a][k];
          if (entry != 0 && diagonal_[from] > 0 && diagonal_[to] > 0)
            entries.emplace_back(from, to, energy_[n] * entry);
        }
    }
  }
  for (std::size_t n = 0; n < diagonal_.size(); ++n) {
    const int k = static_cast<int>(n);
    entries.emplace_back(k, k, diagonal_[n] > 0 ? hold * diagonal_[n] : 1);
  }
  const auto size = static_cast<Eigen::Index>(diagonal_.size());
  Eigen::SparseMatrix<double> K(size, size);
  K.setFromTriplets(entries.begin(), entries.end());
  factor_ = std::make_unique<Factor>();
  factor_->solver.compute(K);
}

std::vector<double> TrussGrid::solve(std::span<const double> r) {
  if (!factor_) factorise();
  const Eigen::VectorXd solution =
      factor_->solver.solve(Eigen::Map<const Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size())));
  std::vector<double> p(solution.begin(), solution.end());
  for (std::size_t n = 0; n < p.size(); ++n)
    if (diagonal_[n] == 0) p[n] = 0;
  return p;
}

}  // namespace calor
