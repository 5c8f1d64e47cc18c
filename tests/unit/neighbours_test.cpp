#include "cloud/neighbours.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <nanoflann.hpp>
#include <random>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/points.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

Points random_points(MPI_Comm comm, std::int64_t count, int dimension, unsigned seed, double ratio = 1) {
  Points p;
  p.dimension = dimension;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 1);
  const Slice mine = slice(comm, count);
  const double d = std::pow(1.0 / static_cast<double>(count), 1.0 / dimension);
  for (std::int64_t id = 0; id < count; ++id) {
    Point q;
    q.id = id;
    q.volume = q.full_volume = 1;
    q.spacing = d * (1 + (ratio - 1) * u(random));
    for (int a = 0; a < dimension; ++a) q.x[a] = u(random);
    if (id >= mine.begin && id < mine.end) p.points.push_back(q);
  }
  return p;
}

double largest_spacing(const Points& p) {
  double d = 0;
  for (const Point& q : p.points) d = std::max(d, q.spacing);
  return d;
}

/// Ids of the neighbours of every point, by trying all pairs.
std::vector<std::vector<std::int64_t>> by_brute_force(const Points& p, double reach) {
  std::vector<std::vector<std::int64_t>> all(p.points.size());
  for (const Point& a : p.points) {
    for (const Point& b : p.points) {
      const double r = reach * (a.spacing + b.spacing) / 2 * (1 - 1e-9);
      if (a.id != b.id && norm(b.x - a.x) < r) all[a.id].push_back(b.id);
    }
  }
  return all;
}

std::vector<std::int64_t> ids_of(const Cloud& c, const Neighbours& n, int i) {
  std::vector<std::int64_t> ids;
  for (std::int32_t j : n.of(i)) ids.push_back(c.id[j]);
  return ids;
}

RC_GTEST_PROP(Neighbours, AreTheSameAsABruteForceSearchOnRandomGradedClouds, ()) {
  const int dimension = *rc::gen::inRange(1, 4);
  const int count = *rc::gen::inRange(1, 300);
  const double reach = *rc::gen::elementOf(std::vector<double>{1.0, 2.0, 2.4, 4.0});
  const double ratio = *rc::gen::elementOf(std::vector<double>{1.0, 4.0});
  const Points p = random_points(MPI_COMM_SELF, count, dimension, *rc::gen::inRange(0u, 1000u), ratio);
  const auto expected = by_brute_force(p, reach);
  const Cloud c = distribute(MPI_COMM_SELF, p, reach * largest_spacing(p));
  const Neighbours n = find_neighbours(c, reach);
  for (int i = 0; i < c.owned; ++i) RC_ASSERT(ids_of(c, n, i) == expected[c.id[i]]);
}

TEST(NeighboursParallel, AreTheSameOnAnyNumberOfRanks) {
  for (int dimension : {1, 2, 3}) {
    const Points all = random_points(MPI_COMM_SELF, 700, dimension, 5, 2);
    const double reach = 2.2;
    const auto expected = by_brute_force(all, reach);
    const Cloud c =
        distribute(MPI_COMM_WORLD, random_points(MPI_COMM_WORLD, 700, dimension, 5, 2), reach * largest_spacing(all));
    const Neighbours n = find_neighbours(c, reach);
    for (int i = 0; i < c.owned; ++i) EXPECT_EQ(ids_of(c, n, i), expected[c.id[i]]);
  }
}

struct Coordinates {
  const std::vector<Vec3>& x;
  std::size_t kdtree_get_point_count() const { return x.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return x[i][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

TEST(Neighbours, AreTheSameAsNanoflannFindsOnALargerCloud) {
  const Points p = random_points(MPI_COMM_SELF, 20000, 3, 9);
  const double reach = 2.3, radius = reach * p.points[0].spacing * (1 - 1e-9);
  const Cloud c = distribute(MPI_COMM_SELF, p, radius);
  const Neighbours n = find_neighbours(c, reach);
  const Coordinates coordinates{c.x};
  using Distance = nanoflann::L2_Simple_Adaptor<double, Coordinates>;
  const nanoflann::KDTreeSingleIndexAdaptor<Distance, Coordinates, 3> tree(3, coordinates);
  for (int i = 0; i < c.owned; ++i) {
    std::vector<std::pair<std::uint32_t, double>> hits;
    tree.radiusSearch(&c.x[i].x, radius * radius, hits, {});
    std::vector<std::int64_t> expected;
    for (const auto& [j, square] : hits)
      if (static_cast<int>(j) != i) expected.push_back(c.id[j]);
    std::ranges::sort(expected);
    EXPECT_EQ(ids_of(c, n, i), expected);
  }
}

TEST(Neighbours, LeaveOutTheShellAtExactlyTheReachOfALattice) {
  // Closed-form counts of lattice vectors shorter than 2 and than 3: 1D 2, 4; 2D 8, 24; 3D 26, 92.
  const std::map<int, std::pair<int, int>> counts = {{1, {2, 4}}, {2, {8, 24}}, {3, {26, 92}}};
  for (const auto& [dimension, expected] : counts) {
    // 0.1 is no binary number: distances of 0.2 and 0.3 come out rounded either way.
    const BoxLattice box = {
        .dimension = dimension, .size = {1.2, 1.2, 1.2}, .points = {13, 13, 13}, .origin = {0.7, 0, 0}};
    const Cloud c = distribute(MPI_COMM_SELF, make_box(MPI_COMM_SELF, box), 0.3);
    for (const int reach : {2, 3}) {
      const Neighbours n = find_neighbours(c, reach);
      for (int i = 0; i < c.owned; ++i) {
        bool inner = true;
        for (int a = 0; a < dimension; ++a) inner = inner && std::abs(c.x[i][a] - box.origin[a] - 0.6) < 0.35;
        if (inner) {
          EXPECT_EQ(static_cast<int>(n.of(i).size()), reach == 2 ? expected.first : expected.second);
        }
      }
    }
  }
}

TEST(Neighbours, AreMutual) {
  const Points p = random_points(MPI_COMM_SELF, 500, 2, 1, 3);
  const Cloud c = distribute(MPI_COMM_SELF, p, 2 * largest_spacing(p));
  const Neighbours n = find_neighbours(c, 2);
  for (int i = 0; i < c.owned; ++i)
    for (std::int32_t j : n.of(i)) EXPECT_TRUE(std::ranges::count(n.of(j), i) == 1);
}

TEST(Neighbours, AreFoundWherePointsAreFarApartComparedToTheirSpacing) {
  // Two clusters a million spacings apart: the cells must not be counted by the distance.
  Points p = random_points(MPI_COMM_SELF, 40, 3, 2);
  for (Point& q : p.points)
    if (q.id % 2) q.x += Vec3{3e5, -2e5, 1e5};
  const auto expected = by_brute_force(p, 3);
  const Cloud c = distribute(MPI_COMM_SELF, p, 3 * p.points[0].spacing);
  const Neighbours n = find_neighbours(c, 3);
  for (int i = 0; i < c.owned; ++i) EXPECT_EQ(ids_of(c, n, i), expected[c.id[i]]);
}

TEST(NeighboursParallel, RefuseCoincidentPointsByName) {
  Points p = random_points(MPI_COMM_WORLD, 200, 3, 4);
  const Vec3 place = random_points(MPI_COMM_SELF, 200, 3, 4).points[17].x;
  for (Point& q : p.points)
    if (q.id == 150) q.x = place;
  const Cloud c = distribute(MPI_COMM_WORLD, std::move(p), 1);
  try {
    find_neighbours(c, 2);
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::bad_case);
    EXPECT_NE(e.problem().find("points 17 and 150"), std::string::npos) << e.what();
  }
}

TEST(NeighboursParallel, AreNotSearchedBeyondTheGhosts) {
  const Cloud c = distribute(MPI_COMM_WORLD, random_points(MPI_COMM_WORLD, 200, 3, 4), 0.1);
  if (size_of(MPI_COMM_WORLD) > 1) {
    EXPECT_THROW(find_neighbours(c, 2), Error);
  } else {
    EXPECT_NO_THROW(find_neighbours(c, 2));
  }
}

TEST(NeighboursParallel, MustNotBeFewerThanTheDimensions) {
  const auto require = [](int dimension, std::array<std::int64_t, 3> points, double reach) {
    const BoxLattice box = {.dimension = dimension, .size = {1, 1, 1}, .points = points};
    const Cloud c = distribute(MPI_COMM_WORLD, make_box(MPI_COMM_WORLD, box), 3);
    require_neighbours(c, find_neighbours(c, reach));
  };
  EXPECT_NO_THROW(require(1, {5, 1, 1}, 2));
  EXPECT_NO_THROW(require(2, {5, 5, 1}, 2));
  EXPECT_NO_THROW(require(3, {4, 4, 4}, 2));
  EXPECT_THROW(require(1, {5, 1, 1}, 0.9), Error);
  EXPECT_THROW(require(2, {5, 5, 1}, 0.9), Error);
}

}  // namespace
}  // namespace calor
