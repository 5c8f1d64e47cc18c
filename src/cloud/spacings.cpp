// Spacings of clouds that somebody else made, from the distances between the points. Volumes do not tell them: a point
// in a corner has an eighth of a cell, and as many neighbours within a spacing as the corner of a lattice has.
#include "cloud/spacings.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "cloud/point_tree.hpp"
#include "cloud/points.hpp"

namespace calor {
namespace {

/// The nearest points of every one: their distances, ascending; fewer where the cloud has fewer.
class Nearest {
 public:
  Nearest(std::span<const Vec3> x, std::size_t count) : x_(x), tree_(x), index_(count + 1), square_(count + 1) {}

  /// Of point i, itself left out; valid until the next call.
  std::span<const double> distances(std::size_t i) {
    const std::size_t found = tree_.nearest(x_[i], index_, square_);
    for (std::size_t n = 0; n < found; ++n) square_[n] = std::sqrt(square_[n]);
    return std::span(square_).subspan(1, found - 1);
  }
  /// Index of the n-th nearest of the point asked for last.
  std::size_t operator[](std::size_t n) const { return index_[n + 1]; }

 private:
  std::span<const Vec3> x_;
  PointTree tree_;
  std::vector<std::uint32_t> index_;
  std::vector<double> square_;
};

/// The neighbours on a lattice of spacing 1, at a point on so many walls: those a step along an axis away, and those a
/// step along two.
struct LatticeStar {
  int along_axes, along_diagonals;
  int count() const { return along_axes + along_diagonals; }
  double mean_distance() const { return (along_axes + std::sqrt(2.0) * along_diagonals) / count(); }
};

LatticeStar lattice_star(int dimension, int walls) {
  LatticeStar star{0, 0};
  for (int a = 0; a < dimension; ++a) {
    const int ways = a < walls ? 1 : 2;
    star.along_diagonals += ways * star.along_axes;
    star.along_axes += ways;
  }
  return star;
}

/// On how many walls a point lies, by the normals of its pieces of surface: those of one curved wall count once, and
/// walls with neighbours beyond them, those of a re-entrant edge, do not count. `around`: from the point to its
/// neighbours.
int count_walls(int dimension, std::span<const Vec3> walls, std::span<const Vec3> around) {
  constexpr double same = 0.9, beyond = 0.75;  // cosines; beside a re-entrant edge others lie beyond at 0.71
  std::vector<Vec3> normals;
  for (const Vec3& wall : walls) {
    const bool is_new = std::ranges::none_of(normals, [&](const Vec3& n) { return dot(n, wall) > same; });
    const bool is_reentrant =
        std::ranges::any_of(around, [&](const Vec3& r) { return dot(r, wall) > beyond * norm(r); });
    if (is_new && !is_reentrant) normals.push_back(wall);
  }
  return std::min(dimension, static_cast<int>(normals.size()));
}

/// How far around a point all others are known, in spacings: half of what the ghosts reach.
constexpr double sure = 2;

/// Spacings of the owned points; 0 for those that have too few neighbours within `sure` spacings as estimated so far.
std::vector<double> spacings_by_neighbours(const Cloud& cloud) {
  std::vector<double> spacing(cloud.owned);
  const std::size_t most = lattice_star(cloud.dimension, 0).count();
  Nearest nearest(cloud.x, most);
  std::vector<Vec3> around, walls;
  auto next = cloud.facets.begin();
  for (int i = 0; i < cloud.owned; ++i) {
    walls.clear();
    for (; next != cloud.facets.end() && next->point == i; ++next) walls.push_back(next->normal);
    const std::span<const double> distance = nearest.distances(i);
    const double known = sure * cloud.spacing[i];
    // Of points that are equally far only some are among the nearest: leave all of them out.
    const double limit = distance.size() == most ? std::min(known, distance.back() * (1 - 1e-9)) : known;
    around.clear();
    for (std::size_t n = 0; n < distance.size() && distance[n] <= limit; ++n)
      around.push_back(cloud.x[nearest[n]] - cloud.x[i]);
    const LatticeStar star = lattice_star(cloud.dimension, count_walls(cloud.dimension, walls, around));
    const auto count = static_cast<std::size_t>(std::min<std::int64_t>(star.count(), cloud.count - 1));
    if (count == 0) spacing[i] = cloud.spacing[i];
    if (count == 0 || distance.size() < count || distance[count - 1] > known) continue;
    double sum = 0;
    for (const double r : distance.first(count)) sum += r;
    spacing[i] = sum / (static_cast<double>(count) * star.mean_distance());
  }
  return spacing;
}

void set_spacing(Cloud& cloud, int i, double d) {
  cloud.spacing[i] = d;
  cloud.metric[i] = {d, d, d};
}

/// Sets the spacings by the neighbours. Estimates of points that have too few of them are doubled, four times at most:
/// what is still alone then keeps the spacing of its volume. Collective.
void set_spacings(Cloud& cloud) {
  constexpr int most_doublings = 4;
  for (int pass = 0;; ++pass) {
    const std::vector<double> spacing = spacings_by_neighbours(cloud);
    const bool is_last = pass == most_doublings || !any(cloud.comm, std::ranges::count(spacing, 0.0) > 0);
    for (int i = 0; i < cloud.owned; ++i) {
      if (is_last)
        set_spacing(cloud, i, spacing[i] > 0 ? spacing[i] : std::ldexp(cloud.spacing[i], -pass));
      else if (spacing[i] == 0)
        set_spacing(cloud, i, 2 * cloud.spacing[i]);
    }
    if (is_last) return;
    cloud = distribute(cloud.comm, owned_points(cloud), Support(2 * sure));
  }
}

/// Full cells of the points at the surface; off the walls their cells are full.
void set_full_volumes(Cloud& cloud) {
  for (const Facet& facet : cloud.facets) {
    const int i = facet.point;
    cloud.full_volume[i] =
        cloud.points_on_walls ? cloud.cross_section * std::pow(cloud.spacing[i], cloud.dimension) : cloud.volume[i];
  }
}

}  // namespace

std::vector<double> distances_to_nearest(std::span<const Vec3> x) {
  std::vector<double> out;
  Nearest nearest(x, 1);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::span<const double> distance = nearest.distances(i);
    out.push_back(distance.empty() ? 0 : distance[0]);
  }
  return out;
}

std::vector<double> spacings_by_distances(int dimension, std::span<const Vec3> x,
                                          std::span<const std::vector<Vec3>> normals) {
  std::vector<double> spacing;
  Nearest nearest(x, lattice_star(dimension, 0).count());
  std::vector<Vec3> around;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::span<const double> distance = nearest.distances(i);
    around.clear();
    for (std::size_t n = 0; n < distance.size() && distance[n] < distance.back() * (1 - 1e-9); ++n)
      around.push_back(x[nearest[n]] - x[i]);
    const LatticeStar star = lattice_star(dimension, count_walls(dimension, normals[i], around));
    const auto count = std::min<std::size_t>(star.count(), distance.size());
    double sum = 0;
    for (const double r : distance.first(count)) sum += r;
    spacing.push_back(sum / (static_cast<double>(count) * star.mean_distance()));
  }
  return spacing;
}

Points settle_spacings(MPI_Comm comm, Points points) {
  const bool find_walls = !points.knows_walls && points.has_areas;
  Cloud cloud = distribute(comm, std::move(points), Support(2 * sure));
  if (find_walls) settle_walls(cloud);
  set_spacings(cloud);
  set_full_volumes(cloud);
  return owned_points(cloud);
}

}  // namespace calor
