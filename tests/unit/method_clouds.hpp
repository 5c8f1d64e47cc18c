#pragma once
// Clouds and small solvers that the tests of the pair methods share.
#include <gtest/gtest.h>

#include <Eigen/SparseLU>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "cloud/shapes.hpp"
#include "conduction/pair_conduction.hpp"
#include "conduction/sph.hpp"

namespace calor {

struct BoxOptions {
  double jitter = 0, section = 1, support = 3;
  bool on_walls = true;
  std::uint64_t seed = 1;
  MPI_Comm comm = MPI_COMM_SELF;
};

/// A box lattice of points[a] points along axis a, `d` apart.
inline Cloud box_cloud(std::vector<std::int64_t> points, double d, const BoxOptions& o = {}) {
  BoxLattice box;
  box.dimension = static_cast<int>(points.size());
  for (int a = 0; a < box.dimension; ++a) {
    box.points[a] = points[a];
    box.size[a] = d * static_cast<double>(points[a] - (o.on_walls ? 1 : 0));
  }
  box.on_walls = o.on_walls;
  box.jitter = o.jitter;
  box.seed = o.seed;
  box.section = o.section;
  return distribute(o.comm, make_box(o.comm, box), o.support * d);
}

/// Weights of directed pairs with all that the checks need.
struct Weights {
  Neighbours neighbours;
  std::vector<double> G;
  CorrectionReport report;
};

inline Weights sph_weights(const Cloud& cloud, double smoothing) {
  Weights w;
  w.neighbours = find_neighbours(cloud, sph_support(smoothing));
  w.G = sph_consistent_weights(cloud, w.neighbours, smoothing, w.report);
  return w;
}

/// Conduction by the consistent pairs of SPH.
inline PairConduction sph_pairs(const Cloud& cloud, double smoothing) {
  Weights w = sph_weights(cloud, smoothing);
  return {cloud, std::move(w.neighbours), std::move(w.G)};
}

/// The Jacobian as a sparse matrix; one rank.
class SparseJacobian final : public JacobianEntries {
 public:
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    for (std::size_t n = 0; n < columns.size(); ++n) entries_.emplace_back(row, columns[n], values[n]);
  }
  Eigen::SparseMatrix<double> matrix(int size) const {
    Eigen::SparseMatrix<double> A(size, size);
    A.setFromTriplets(entries_.begin(), entries_.end());
    return A;
  }

 private:
  std::vector<Eigen::Triplet<double>> entries_;
};

/// Solves A T = b where `fixed` holds T at the points with fixed[i] finite and no equation is wanted there.
inline std::vector<double> solve_with_fixed(const Eigen::SparseMatrix<double>& A, const std::vector<double>& b,
                                            const std::vector<double>& fixed) {
  const int n = static_cast<int>(b.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd rhs(n);
  for (int i = 0; i < n; ++i) {
    rhs[i] = std::isfinite(fixed[i]) ? fixed[i] : b[i];
    if (std::isfinite(fixed[i])) entries.emplace_back(i, i, 1.0);
  }
  for (int c = 0; c < A.outerSize(); ++c) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(A, c); it; ++it) {
      if (!std::isfinite(fixed[it.row()])) entries.emplace_back(it.row(), it.col(), it.value());
    }
  }
  Eigen::SparseMatrix<double> M(n, n);
  M.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(M);
  const Eigen::VectorXd T = lu.solve(rhs);
  return {T.data(), T.data() + n};
}

}  // namespace calor
