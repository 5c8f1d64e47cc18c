#include "cloud/lattice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"

namespace calor {
namespace {

BoxLattice jittered(int dimension, double jitter = 0.3) {
  return {.dimension = dimension, .size = {1.1, 0.8, 0.5}, .points = {12, 9, 6}, .jitter = jitter, .seed = 7};
}

TEST(Jitter, MovesPointsByAtMostTheFraction) {
  for (int dimension : {1, 2, 3}) {
    const Lattice lattice(jittered(dimension)), regular(jittered(dimension, 0));
    double largest = 0;
    for (std::int64_t id = 0; id < lattice.count(); ++id) {
      const Vec3 move = lattice.position(lattice.index(id)) - regular.position(regular.index(id));
      for (int a = 0; a < 3; ++a) largest = std::max(largest, std::abs(move[a]));
    }
    EXPECT_LE(largest, 0.3 * 0.1 * (1 + 1e-12));
    EXPECT_GT(largest, 0.2 * 0.1);
  }
}

TEST(Jitter, KeepsWallPointsOnTheirWallsAndCornersInPlace) {
  const Lattice lattice(jittered(3)), regular(jittered(3, 0));
  for (std::int64_t id = 0; id < lattice.count(); ++id) {
    const LatticeIndex i = lattice.index(id);
    const Vec3 x = lattice.position(i), x0 = regular.position(i);
    for (int a = 0; a < 3; ++a) {
      if (lattice.lowest(i, a) || lattice.highest(i, a)) {
        EXPECT_EQ(x[a], x0[a]);
      } else {
        EXPECT_NE(x[a], x0[a]);
      }
    }
  }
}

TEST(Jitter, DependsOnTheSeed) {
  BoxLattice a = jittered(2), b = jittered(2);
  b.seed = 8;
  EXPECT_NE(Lattice(a).position({3, 3, 0}), Lattice(b).position({3, 3, 0}));
}

TEST(Jitter, IsUniformInEveryDirection) {
  constexpr int n = 100000;
  std::array<double, 3> mean{}, square{}, product{};
  for (int i = 0; i < n; ++i) {
    const Vec3 u = hashed_uniform(1, i) - Vec3{0.5, 0.5, 0.5};
    for (int a = 0; a < 3; ++a) {
      mean[a] += u[a] / n;
      square[a] += u[a] * u[a] / n;
      product[a] += u[a] * u[(a + 1) % 3] / n;
    }
  }
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(mean[a], 0, 5 * 0.289 / std::sqrt(n));  // five standard deviations
    EXPECT_NEAR(square[a], 1.0 / 12, 5 * 0.075 / std::sqrt(n));
    EXPECT_NEAR(product[a], 0, 5 * 0.0834 / std::sqrt(n));
  }
}

TEST(Jitter, GivesPointsOfALineTheHalvesOfTheirIntervals) {
  const Lattice lattice(jittered(1));
  const std::vector<double> length = nearest_point_volumes(lattice, {0, 12});
  const auto x = [&](std::int64_t i) { return lattice.position({i, 0, 0}).x; };
  EXPECT_NEAR(length[0], x(1) / 2, 1e-15);
  EXPECT_NEAR(length[5], (x(6) - x(4)) / 2, 1e-15);
  EXPECT_NEAR(length[11], (1.1 - x(10)) / 2, 1e-15);
}

TEST(Jitter, GivesPointsOfARegularLatticeTheCutCellsOfTheLattice) {
  for (int dimension : {2, 3}) {
    const Lattice lattice(jittered(dimension, 0));
    const std::vector<double> volume = nearest_point_volumes(lattice, {0, lattice.count()});
    for (std::int64_t id = 0; id < lattice.count(); ++id) {
      double exact = 1;
      for (int a = 0; a < dimension; ++a) exact *= lattice.width(a, lattice.index(id)[a]);
      EXPECT_NEAR(volume[id], exact, 1e-12 * exact);
    }
  }
}

TEST(Jitter, GivesVolumesThatFillTheBoxAndAreWhereNearestPlacesAre) {
  for (int dimension : {2, 3}) {
    for (const bool on_walls : {true, false}) {
      BoxLattice box = jittered(dimension, 0.49);
      box.on_walls = on_walls;
      const Lattice lattice(box);
      const std::vector<double> volume = nearest_point_volumes(lattice, {0, lattice.count()});
      std::vector<Vec3> x;
      for (std::int64_t id = 0; id < lattice.count(); ++id) x.push_back(lattice.position(lattice.index(id)));
      const double whole = dimension == 2 ? 1.1 * 0.8 : 1.1 * 0.8 * 0.5;
      EXPECT_NEAR(std::accumulate(volume.begin(), volume.end(), 0.0), whole, 1e-13);

      constexpr int n = 40000;  // places all over the box, and the points nearest to them
      std::vector<int> count(x.size(), 0);
      for (int s = 0; s < n; ++s) {
        const Vec3 u = hashed_uniform(99, s), p{1.1 * u.x, 0.8 * u.y, dimension == 2 ? 0 : 0.5 * u.z};
        const auto nearest = std::ranges::min_element(x, {}, [&](const Vec3& y) { return norm(y - p); });
        ++count[nearest - x.begin()];
      }
      for (std::size_t i = 0; i < x.size(); ++i) {
        const double expected = n * volume[i] / whole;
        EXPECT_NEAR(count[i], expected, 5 * std::sqrt(expected) + 1) << "five standard deviations";
      }
    }
  }
}

TEST(Jitter, GivesVolumesThatAreExactForLinearFunctionsHoweverManyPointsThereAre) {
  // 130 mm x 6 mm in spacings of 1 mm: the volume, and its moments 130^2 6/2 and 130 6^2/2.
  BoxLattice box{.dimension = 2, .size = {0.13, 0.006, 0}, .points = {131, 7, 1}, .jitter = 0.2, .seed = 3};
  const Lattice lattice(box);
  const std::vector<double> volumes = linearly_exact_volumes(lattice, {0, lattice.count()});
  double volume = 0;
  Vec3 moment;
  for (std::int64_t id = 0; id < lattice.count(); ++id) {
    volume += volumes[id];
    moment += volumes[id] * lattice.position(lattice.index(id));
  }
  EXPECT_NEAR(volume, 0.13 * 0.006, 1e-15);
  EXPECT_NEAR(moment.x, 0.13 * 0.13 * 0.006 / 2, 1e-16);
  EXPECT_NEAR(moment.y, 0.13 * 0.006 * 0.006 / 2, 1e-17);
}

TEST(JitterParallel, DoesNotDependOnTheRanks) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  for (int dimension : {1, 2, 3}) {
    for (const bool on_walls : {true, false}) {
      BoxLattice box = jittered(dimension);
      box.on_walls = on_walls;
      const Points all = make_box(MPI_COMM_SELF, box), mine = make_box(comm, box);
      const Slice s = slice(comm, static_cast<std::int64_t>(all.points.size()));
      ASSERT_EQ(static_cast<std::int64_t>(mine.points.size()), s.end - s.begin);
      for (std::size_t k = 0; k < mine.points.size(); ++k) {
        const Point &p = mine.points[k], &q = all.points[s.begin + k];
        EXPECT_EQ(p.id, q.id);
        EXPECT_EQ(p.x, q.x);
        EXPECT_EQ(p.volume, q.volume);
        EXPECT_EQ(p.area, q.area);
      }
    }
  }
}

}  // namespace
}  // namespace calor
