#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/bisection.hpp"
#include "cloud/neighbours.hpp"
#include "cloud/points.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

const MPI_Comm world = MPI_COMM_WORLD;

/// `count` random points of one cloud in a box of 2 x 1 x 1, spread over the ranks without any order in space.
Points random_points(MPI_Comm comm, std::int64_t count, int dimension) {
  Points p;
  p.dimension = dimension;
  p.faces = {"a", "b"};
  p.tags = {"", "core"};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0, 1);
  const Slice mine = slice(comm, count);
  for (std::int64_t id = 0; id < count; ++id) {
    Point q;
    q.id = id;
    q.spacing = 0.05 + 0.05 * u(random);
    q.x = {2 * u(random), dimension > 1 ? u(random) : 0, dimension > 2 ? u(random) : 0};
    q.volume = 1 + u(random);
    q.full_volume = 2 * q.volume;
    q.tag = static_cast<int>(id % 2);
    if (id < mine.begin || id >= mine.end) continue;
    p.points.push_back(q);
    for (int n = 0; n < id % 3; ++n) p.add_patch(n, static_cast<double>(id + n), {0, n ? -1.0 : 1.0, 0});
  }
  return p;
}

TEST(DistributeParallel, GivesEveryPointToExactlyOneRankInEqualShares) {
  for (const std::int64_t count : {1, 3, 1000, 1001}) {
    const Cloud c = distribute(world, random_points(world, count, 3), 0.2);
    std::vector<std::int64_t> ids(c.id.begin(), c.id.begin() + c.owned);
    ids = gather(world, ids);
    std::ranges::sort(ids);
    ASSERT_EQ(static_cast<std::int64_t>(ids.size()), count);
    for (std::int64_t i = 0; i < count; ++i) EXPECT_EQ(ids[i], i);
    EXPECT_EQ(c.count, count);
    EXPECT_EQ(c.first, offset(world, c.owned));
    EXPECT_LE(std::abs(c.owned - static_cast<double>(count) / size_of(world)), 1);
  }
}

TEST(DistributeParallel, KeepsWhatBelongsToAPoint) {
  const Points all = random_points(MPI_COMM_SELF, 500, 3);
  std::vector<int> first_patch;
  int facets = 0;
  for (const Point& p : all.points) first_patch.push_back(facets), facets += p.facets;
  const Cloud c = distribute(world, random_points(world, 500, 3), 0.2);
  std::size_t next = 0;
  for (int i = 0; i < c.local(); ++i) {
    const Point& p = all.points[c.id[i]];
    EXPECT_EQ(c.x[i], p.x);
    EXPECT_EQ(c.volume[i], p.volume);
    EXPECT_EQ(c.full_volume[i], p.full_volume);
    EXPECT_EQ(c.spacing[i], p.spacing);
    EXPECT_EQ(c.area[i], p.area);
    EXPECT_EQ(c.on_faces[i], p.on_faces);
    EXPECT_EQ(c.tag[i], p.tag);
    for (int n = 0; i < c.owned && n < p.facets; ++n, ++next) {
      ASSERT_LT(next, c.facets.size());
      EXPECT_EQ(c.facets[next].point, i);
      EXPECT_EQ(c.facets[next].face, all.facets[first_patch[c.id[i]] + n].face);
      EXPECT_EQ(c.facets[next].area, all.facets[first_patch[c.id[i]] + n].area);
      EXPECT_EQ(c.facets[next].normal, all.facets[first_patch[c.id[i]] + n].normal);
    }
  }
  EXPECT_EQ(next, c.facets.size());
}

TEST(DistributeParallel, HasEveryPointWithinTheSupportOfABlockAsGhost) {
  for (int dimension : {1, 2, 3}) {
    const double support = 0.15;
    const Points all = random_points(MPI_COMM_SELF, 800, dimension);
    const Cloud c = distribute(world, random_points(world, 800, dimension), support);
    EXPECT_EQ(c.halo_width, support);
    const std::set<std::int64_t> local(c.id.begin(), c.id.end());
    EXPECT_EQ(static_cast<int>(local.size()), c.local());  // none twice
    for (const Point& p : all.points) {
      for (int i = 0; i < c.owned; ++i) {
        if (norm(p.x - c.x[i]) > support) continue;
        EXPECT_TRUE(local.contains(p.id));
        break;
      }
    }
    EXPECT_TRUE(std::is_sorted(c.global.begin() + c.owned, c.global.end()));
  }
}

TEST(DistributeParallel, CopiesValuesOfOwnersToGhosts) {
  const Cloud c = distribute(world, random_points(world, 800, 3), 0.2);
  std::vector<double> values(c.local(), -1);
  std::vector<Vec3> vectors(c.local());
  for (int i = 0; i < c.owned; ++i) values[i] = 3.0 * c.id[i], vectors[i] = 2 * c.x[i];
  c.halo.update(values);
  c.halo.update(vectors);
  for (int i = 0; i < c.local(); ++i) {
    EXPECT_EQ(values[i], 3.0 * c.id[i]);
    EXPECT_EQ(vectors[i], 2 * c.x[i]);
  }
}

TEST(DistributeParallel, MakesTheSameBlocksWhereverThePointsStart) {
  Points shuffled = random_points(world, 300, 2);
  // Everything from the last rank, in reverse.
  shuffled.points = gather(world, shuffled.points);
  shuffled.facets = gather(world, shuffled.facets);
  if (rank_of(world) + 1 < size_of(world)) {
    shuffled.points.clear(), shuffled.facets.clear();
  } else {
    for (Point& p : shuffled.points) p.facets = 0;
    shuffled.facets.clear();
    std::ranges::reverse(shuffled.points);
  }
  const Cloud a = distribute(world, random_points(world, 300, 2), 0.2), b = distribute(world, std::move(shuffled), 0.2);
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.global, b.global);
}

TEST(DistributeParallel, CutsALatticeIntoSlabsAcrossItsLongestSide) {
  const Cloud c =
      distribute(world, make_box(world, {.dimension = 2, .size = {1.2, 0.3, 0}, .points = {12, 4, 1}}), 0.3);
  if (12 % size_of(world) != 0) return;
  std::set<double> columns;
  for (int i = 0; i < c.owned; ++i) columns.insert(c.x[i].x);
  EXPECT_EQ(static_cast<int>(columns.size()), 12 / size_of(world));
}

TEST(DistributeParallel, DoesNotNeedAPointOnEveryRank) {
  const Cloud c = distribute(world, make_box(world, {.dimension = 1, .size = {1, 0, 0}, .points = {2, 1, 1}}), 2);
  EXPECT_EQ(total(world, c.owned), 2);
  const Neighbours n = find_neighbours(c, 2);
  for (int i = 0; i < c.owned; ++i) EXPECT_EQ(n.of(i).size(), 1u);
  EXPECT_NEAR(check(c).volume, 1, 1e-15);
}

TEST(DistributeParallel, RefusesVolumesThatAreNotPositiveOnAllRanks) {
  for (const double volume : {0.0, -1.0, std::nan("")}) {
    Points p = random_points(world, 100, 3);
    for (Point& q : p.points)
      if (q.id == 42) q.volume = volume;
    try {
      distribute(world, std::move(p), 0.2);
      ADD_FAILURE() << "accepted";
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::bad_case);
      EXPECT_NE(e.problem().find("point 42 at ("), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(distribute(world, Points{}, 1), Error);
}

TEST(DistributeParallel, RefusesPlacesAndSpacingsThatAreNone) {
  Points nowhere = random_points(world, 100, 3), close = nowhere;
  for (Point& q : nowhere.points) q.x.y = q.id == 7 ? std::nan("") : q.x.y;
  for (Point& q : close.points) q.spacing = q.id == 7 ? 0 : q.spacing;
  EXPECT_THROW(distribute(world, std::move(nowhere), 0.2), Error);
  EXPECT_THROW(distribute(world, std::move(close), 0.2), Error);
}

TEST(Distribute, OrdersALatticeAlongXThenYThenZWhateverTheOrderOfIds) {
  Points p = make_box(MPI_COMM_SELF, {.dimension = 3, .size = {0.7, 0.4, 0.3}, .points = {8, 5, 4}});
  std::vector<std::int64_t> ids(p.points.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::int64_t>(i);
  std::ranges::shuffle(ids, std::mt19937(1));
  for (Point& q : p.points) q.id = ids[q.id];
  const Cloud c = distribute(MPI_COMM_SELF, std::move(p), 0.2);
  for (int i = 0; i < c.owned; ++i) {
    EXPECT_NEAR(c.x[i].x, 0.1 * (i % 8), 1e-15);
    EXPECT_NEAR(c.x[i].y, 0.1 * (i / 8 % 5), 1e-15);
    EXPECT_NEAR(c.x[i].z, 0.1 * (i / 40), 1e-15);
  }
}

}  // namespace
}  // namespace calor
