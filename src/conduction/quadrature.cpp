#include "conduction/quadrature.hpp"

#include <Eigen/Eigenvalues>

#include "cloud/cell_moments.hpp"

namespace calor {

CellQuadrature one_point(const Cloud& cloud) {
  CellQuadrature points;
  for (int i = 0; i < cloud.owned; ++i) {
    points.x.push_back(cloud.x[i]);
    points.tag.push_back(cloud.tag[i]);
    points.volume.push_back(cloud.volume[i]);
    points.cell.push_back(i + 1);
  }
  return points;
}

CellQuadrature gauss_points(const Cloud& cloud) {
  const int D = cloud.dimension, corners = 1 << D;
  CellQuadrature points;
  for_each_cell(cloud, [&](int i, const CellMoments& m) {
    const Eigen::Matrix3d root = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m.covariance).operatorSqrt();
    for (int q = 0; q < corners; ++q) {
      Vec3 x = m.centroid;
      for (int a = 0; a < D; ++a) {
        const double sign = q >> a & 1 ? 1 : -1;
        for (int b = 0; b < D; ++b) x[b] += sign * root(b, a);
      }
      // Cells are not convex at edges that point into the body.
      for (int halving = 0; halving < 10 && !cloud.is_seen_from(x, i); ++halving) x = 0.5 * (x + cloud.inside[i]);
      points.x.push_back(x);
      points.tag.push_back(cloud.tag[i]);
      // The thickness of an axisymmetric body is that of the place: over the cell it is linear.
      points.volume.push_back(cloud.volume[i] / corners * (cloud.axisymmetric ? x.x / m.centroid.x : 1));
    }
    points.cell.push_back(static_cast<std::int64_t>(points.x.size()));
  });
  return points;
}

}  // namespace calor
