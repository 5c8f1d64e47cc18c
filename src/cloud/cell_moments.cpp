#include "cloud/cell_moments.hpp"

#include <algorithm>
#include <limits>
#include <span>

#include "base/parallel.hpp"
#include "cloud/convex_cell.hpp"
#include "cloud/lattice.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

namespace {

CellMoments moments_of_box(const Cloud& cloud, int i) {
  const LatticeIndex at = cloud.lattice->index(cloud.id[i]);
  CellMoments m;
  for (int a = 0; a < cloud.dimension; ++a) {
    const auto [low, high] = cloud.lattice->cell(a, at[a]);
    m.centroid[a] = 0.5 * (low + high);
    m.covariance(a, a) = (high - low) * (high - low) / 12;
  }
  return m;
}

/// The metric of the points where it is the same for all, in which their cells are those of jittered lattices.
Vec3 common_metric(const Cloud& cloud) {
  Vec3 s;
  for (int a = 0; a < 3; ++a) {
    double least = std::numeric_limits<double>::max(), most = 0;
    for (const Vec3& m : cloud.metric) least = std::min(least, m[a]), most = std::max(most, m[a]);
    least = min(cloud.comm, least), most = max(cloud.comm, most);
    s[a] = most;
    if (most - least > 1e-9 * most) return {1, 1, 1};
  }
  return s;
}

/// Moments of the part of a box of one spacing to all sides around point i that is its cell; what is nearest is told
/// in the given units.
CellMoments moments_of_nearest(const Cloud& cloud, const Neighbours& neighbours, int i, std::span<const Facet> facets,
                               const Vec3& unit, ConvexCell& cell) {
  const Vec3 spacing = quotient(cloud.metric[i], unit);
  const auto moments = [&](std::span<const Facet> walls) {
    cell.set(-spacing, spacing, cloud.dimension);
    for (const Facet& p : walls) cell.cut(product(p.normal, unit), 0);
    if (cloud.axisymmetric) cell.cut({-1, 0, 0}, cloud.x[i].x / unit.x);
    for (const int j : neighbours.of(i)) cell.keep_nearer_than(quotient(cloud.x[j] - cloud.x[i], unit));
    return cell.moments();
  };
  ConvexCell::Moments integral = moments(facets);
  // Walls that face each other, as at the end of a slot, leave nothing of a convex cell.
  constexpr double nothing = 1e-3;
  const double box = spacing.x * (cloud.dimension > 1 ? spacing.y : 1) * (cloud.dimension > 2 ? spacing.z : 1);
  if (!(integral.volume > nothing * box)) integral = moments({});
  const double per_volume = 1 / integral.volume;
  const Vec3 mean = per_volume * integral.first;
  const auto& [xx, yy, zz, xy, xz, yz] = integral.second;
  CellMoments m{.centroid = cloud.x[i] + product(unit, mean)};
  m.covariance << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  const Eigen::Vector3d c(mean.x, mean.y, mean.z);
  m.covariance = (per_volume * m.covariance - c * c.transpose()).eval();
  const Eigen::Vector3d u(unit.x, unit.y, unit.z);
  m.covariance = (u.asDiagonal() * m.covariance * u.asDiagonal()).eval();
  const int D = cloud.dimension;
  m.covariance.bottomRows(3 - D).setZero();
  m.covariance.rightCols(3 - D).setZero();
  return m;
}

}  // namespace

void for_each_cell(const Cloud& cloud, const std::function<void(int, const CellMoments&)>& use) {
  const Support& ghosts = cloud.halo_support;
  const double reach = ghosts.length == 0 ? std::min(2.0, ghosts.over_spacing * (1 - 1e-9)) : 2.0;
  const Neighbours neighbours = cloud.lattice ? Neighbours{} : find_neighbours(cloud, reach);
  const Vec3 unit = cloud.lattice ? Vec3{1, 1, 1} : common_metric(cloud);
  ConvexCell cell;
  auto facet = cloud.facets.begin();
  for (int i = 0; i < cloud.owned; ++i) {
    const auto first = facet;
    while (facet != cloud.facets.end() && facet->point == i) ++facet;
    use(i, cloud.lattice ? moments_of_box(cloud, i)
                         : moments_of_nearest(cloud, neighbours, i, std::span<const Facet>(first, facet), unit, cell));
  }
}

}  // namespace calor
