#include "method/cell_points.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "cloud/lattice.hpp"
#include "cloud/neighbours.hpp"
#include "method/lattice_cells.hpp"

namespace calor {

namespace {

struct Moments {
  Vec3 centroid;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

Moments moments_of_box(const Cloud& cloud, int i) {
  Moments m;
  for (int a = 0; a < cloud.dimension; ++a) {
    const Extent e = extent(cloud, i, a);
    m.centroid[a] = 0.5 * (e.low + e.high);
    m.covariance(a, a) = (e.high - e.low) * (e.high - e.low) / 12;
  }
  return m;
}

/// Moments of the samples in a box of one spacing around point i that lie in its cell.
Moments moments_of_samples(const Cloud& cloud, const Neighbours& neighbours, int i, std::span<const Patch> patches) {
  const int D = cloud.dimension, along = D == 3 ? 10 : D == 2 ? 24 : 64;
  const int samples = D == 3 ? along * along * along : D == 2 ? along * along : along;
  const double d = cloud.spacing[i];
  const auto inside = [&](const Vec3& u) {
    for (const Patch& p : patches)
      if (dot(u, p.normal) > 0) return false;
    for (const int j : neighbours.of(i)) {
      const Vec3 r = cloud.x[j] - cloud.x[i];
      if (dot(u, r) > 0.5 * dot(r, r)) return false;
    }
    return true;
  };
  double count = 0;
  Vec3 sum;
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int s = 0; s < samples; ++s) {
    const Vec3 shake = hashed_uniform(0, static_cast<std::uint64_t>(cloud.id[i]) * samples + s);
    const std::array<int, 3> place = {s % along, s / along % along, s / (along * along)};
    Vec3 u;
    for (int a = 0; a < D; ++a) u[a] = d * (2 * (place[a] + shake[a]) / along - 1);
    if (!inside(u)) continue;
    count += 1;
    sum += u;
    const Eigen::Vector3d v(u.x, u.y, u.z);
    second += v * v.transpose();
  }
  if (count == 0) return {.centroid = cloud.x[i]};
  const Eigen::Vector3d mean = Eigen::Vector3d(sum.x, sum.y, sum.z) / count;
  return {.centroid = cloud.x[i] + (1 / count) * sum, .covariance = second / count - mean * mean.transpose()};
}

}  // namespace

CellPlaces one_point(const Cloud& cloud) {
  CellPlaces points;
  for (int i = 0; i < cloud.owned; ++i) {
    points.x.push_back(cloud.x[i]);
    points.tag.push_back(cloud.tag[i]);
    points.volume.push_back(cloud.volume[i]);
    points.cell.push_back(i + 1);
  }
  return points;
}

CellPlaces gauss_points(const Cloud& cloud) {
  const int D = cloud.dimension, corners = 1 << D;
  const Neighbours neighbours = cloud.box_lattice ? Neighbours{} : find_neighbours(cloud, 2);
  CellPlaces points;
  auto patch = cloud.patches.begin();
  for (int i = 0; i < cloud.owned; ++i) {
    const auto first = patch;
    while (patch != cloud.patches.end() && patch->point == i) ++patch;
    const Moments m = cloud.box_lattice
                          ? moments_of_box(cloud, i)
                          : moments_of_samples(cloud, neighbours, i, std::span<const Patch>(first, patch));
    const Eigen::Matrix3d root = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m.covariance).operatorSqrt();
    for (int q = 0; q < corners; ++q) {
      Vec3 x = m.centroid;
      for (int a = 0; a < D; ++a) {
        const double sign = q >> a & 1 ? 1 : -1;
        for (int b = 0; b < D; ++b) x[b] += sign * root(b, a);
      }
      points.x.push_back(x);
      points.tag.push_back(cloud.tag[i]);
      points.volume.push_back(cloud.volume[i] / corners);
    }
    points.cell.push_back(static_cast<std::int64_t>(points.x.size()));
  }
  return points;
}

}  // namespace calor
