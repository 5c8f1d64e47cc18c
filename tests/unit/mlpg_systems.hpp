#pragma once
// MLPG as matrices, for tests on one rank: C dT/dt + K T = f, T^h = Phi T, with rho c = k = 1.
#include <Eigen/SparseLU>
#include <cmath>
#include <functional>
#include <vector>

#include "conduction/mlpg.hpp"
#include "method_clouds.hpp"

namespace calor {

using Field = std::function<double(const Vec3&)>;
using Sparse = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

inline Sparse matrix(const SparseRows& rows, int columns) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t q = 0; q < rows.count(); ++q)
    for (auto n = rows.row[q]; n < rows.row[q + 1]; ++n)
      entries.emplace_back(static_cast<int>(q), rows.column[n], rows.value[n]);
  Sparse A(static_cast<int>(rows.count()), columns);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// A conductivity of `k` wherever the scheme wants it.
inline std::vector<double> everywhere(const Cloud& cloud, const FaceConduction& faces, double k) {
  return std::vector<double>(faces.is_nodal() ? cloud.x.size() : faces.faces().size(), k);
}

struct MlpgSystem {
  MlpgSystem(const Cloud& cloud, const MlpgOptions& options)
      : cloud(cloud), scheme(mlpg_scheme(cloud, options, report)) {
    const FaceConduction& faces = *scheme.conduction;
    const int n = cloud.owned;
    const std::vector<double> one = everywhere(cloud, faces, 1), none;
    SparseJacobian J;
    faces.add_jacobian({.mean = Mean::arithmetic, .k = one, .dk_dT = none, .theta = none}, none, J);
    K = -J.matrix(n);
    Phi = Sparse(n, n), C = Sparse(n, n);
    Phi.setIdentity();
    if (!faces.is_nodal()) Phi = matrix(faces.rows().value, n);
    std::vector<Eigen::Triplet<double>> volumes;
    const CellQuadrature* cells = faces.rows().cells ? &*faces.rows().cells : nullptr;
    for (int i = 0; i < n; ++i) {
      if (!cells) volumes.emplace_back(i, i, cloud.volume[i]);
      for (auto q = cells ? cells->cell[i] : 0; cells && q < cells->cell[i + 1]; ++q)
        volumes.emplace_back(i, static_cast<int>(q), cells->volume[q]);
    }
    Sparse V(n, cells ? static_cast<int>(cells->x.size()) : n);
    V.setFromTriplets(volumes.begin(), volumes.end());
    C = V * (cells ? matrix(cells->phi, n) : Phi);
  }

  bool on_wall(int i) const { return cloud.on_faces[i] != 0; }

  /// Rows of A, but those of Phi at the points on the walls.
  Sparse with_walls(const Sparse& A) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (const bool wall : {false, true}) {
      const Sparse& M = wall ? Phi : A;
      for (int c = 0; c < M.outerSize(); ++c)
        for (Sparse::InnerIterator it(M, c); it; ++it)
          if (on_wall(static_cast<int>(it.row())) == wall) entries.emplace_back(it.row(), it.col(), it.value());
    }
    Sparse out(A.rows(), A.cols());
    out.setFromTriplets(entries.begin(), entries.end());
    return out;
  }

  Vector at_points(const Field& T) const {
    Vector v(cloud.owned);
    for (int i = 0; i < cloud.owned; ++i) v[i] = T(cloud.x[i]);
    return v;
  }

  /// Temperatures of the points for -div grad T = Q with T given on the walls.
  Vector steady(const Field& T_wall, const Field& Q) const {
    Vector b(cloud.owned);
    for (int i = 0; i < cloud.owned; ++i) b[i] = on_wall(i) ? T_wall(cloud.x[i]) : cloud.volume[i] * Q(cloud.x[i]);
    const Eigen::SparseLU<Sparse> lu(with_walls(K));
    return Phi * Vector(lu.solve(b));
  }

  /// Temperatures of the points at time t in an insulated body: Crank-Nicolson.
  Vector cooled(const Field& T_start, double t, int steps) const {
    Vector T = at_points(T_start);
    if (!scheme.conduction->is_nodal()) T = Eigen::SparseLU<Sparse>(Phi).solve(T).eval();
    const double dt = t / steps;
    const Eigen::SparseLU<Sparse> lu(Sparse(C / dt + 0.5 * K));
    for (int n = 0; n < steps; ++n) T = lu.solve(Vector(C * T / dt - 0.5 * (K * T))).eval();
    return Phi * T;
  }

  /// Weighted with the volumes, relative to the size of T.
  double error(const Vector& T, const Field& exact) const {
    double square = 0, size = 0;
    for (int i = 0; i < cloud.owned; ++i) {
      const double e = exact(cloud.x[i]);
      square += cloud.volume[i] * (T[i] - e) * (T[i] - e);
      size += cloud.volume[i] * e * e;
    }
    return std::sqrt(square / size);
  }

  const Cloud& cloud;
  MlpgReport report;
  MlpgScheme scheme;
  Sparse K, C, Phi;
};

}  // namespace calor
