#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "cloud/lattice.hpp"
#include "conduction/peridynamics.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

struct Weighted {
  Cloud cloud;
  Weights w;
};

/// Peridynamics; `faces` have images in the lists.
Weights bonds(const Cloud& cloud, double horizon, std::uint32_t faces = 0) {
  Weights w;
  const Peridynamics options{.horizon = horizon};
  w.neighbours = find_neighbours(cloud, options.support(), faces);
  w.G = peridynamic_weights(cloud, w.neighbours, options, w.report);
  return w;
}

std::vector<Weighted> lattices() {
  std::vector<Weighted> all;
  for (const bool on_walls : {true, false}) {
    for (const auto& points : {std::vector<std::int64_t>{12}, {2}, {9, 12}, {7, 2}, {2, 3}, {8, 9, 10}, {4, 2, 7}}) {
      const Cloud cloud = box_cloud(points, 0.1, {.section = points.size() < 3 ? 0.3 : 1, .on_walls = on_walls});
      for (const double smoothing : {0.8, 1.2, 1.5}) all.push_back({cloud, sph_weights(cloud, smoothing)});
      for (const double horizon : {1.0, 2.0, 3.015}) all.push_back({cloud, bonds(cloud, horizon)});
    }
  }
  return all;
}

TEST(LatticeImages, GiveConsistentPositiveWeightsWithoutASolveForAnySupport) {
  for (const auto& [cloud, w] : lattices()) {
    SCOPED_TRACE(testing::Message() << cloud.count << " points, " << w.G.size() << " pairs");
    EXPECT_TRUE(w.report.lattice_shortcut);
    EXPECT_EQ(w.report.lambda_solves, 0);
    EXPECT_LE(w.report.residual, 1e-13);
    EXPECT_GE(*std::ranges::min_element(w.G), 0);
    std::map<std::pair<int, int>, double> G;
    for (int i = 0; i < cloud.owned; ++i)
      for (auto n = w.neighbours.row[i]; n < w.neighbours.row[i + 1]; ++n) G[{i, w.neighbours.column[n]}] = w.G[n];
    int different = 0;
    for (const auto& [pair, weight] : G) different += G.at({pair.second, pair.first}) != weight;
    EXPECT_EQ(different, 0);
  }
}

TEST(LatticeImages, LeaveNoStressAlongWalls) {
  // sum G x_a x_b = 2 V I at points that reach no wall across axis a, or across b, whatever other walls are near.
  for (const bool on_walls : {true, false}) {
    const Cloud cloud = box_cloud({9, 4, 9}, 0.1, {.on_walls = on_walls});
    const Weights w = bonds(cloud, 2);
    for (int i = 0; i < cloud.owned; ++i) {
      const LatticeIndex at = cloud.lattice->index(cloud.id[i]);
      const auto far = [&](int a) { return at[a] > 2 && at[a] < cloud.lattice->box().points[a] - 3; };
      for (int a = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b) {
          if (!far(a) && !far(b)) continue;
          double moment = 0;
          for (auto n = w.neighbours.row[i]; n < w.neighbours.row[i + 1]; ++n) {
            const Vec3 r = w.neighbours.x_ji(cloud.x, i, n);
            moment += w.G[n] * r[a] * r[b] / (2 * cloud.volume[i]);
          }
          EXPECT_NEAR(moment, a == b ? 1 : 0, 1e-12) << i << " " << a << b;
        }
      }
    }
  }
}

TEST(LatticeImages, ServeUnequalSpacings) {
  BoxLattice box{.dimension = 3, .size = {1, 1.4, 0.9}, .points = {7, 8, 10}};
  for (const bool on_walls : {true, false}) {
    box.on_walls = on_walls;
    const Cloud cloud = distribute(MPI_COMM_SELF, make_box(MPI_COMM_SELF, box), Support(2.4));
    const Weights w = sph_weights(cloud, 1.2);
    EXPECT_TRUE(w.report.lattice_shortcut);
    EXPECT_LE(w.report.residual, 1e-13);
    EXPECT_GE(*std::ranges::min_element(w.G), 0);
  }
}

TEST(LatticeImages, KeepWallsWithImagesInTheListsAsTheyAre) {
  // Walls with images in the lists and walls without, at one body: the weights of two points that see no wall of the
  // second kind are those of the unbounded lattice, 2 V f / (3 |x|^2) scaled alike.
  const Cloud cloud = box_cloud({8, 7, 9}, 0.1, {.support = 3.6, .on_walls = false});
  const Weights all = bonds(cloud, 3.015, 0b111111), some = bonds(cloud, 3.015, 0b000110);
  for (const Weights* w : {&all, &some}) {
    EXPECT_TRUE(w->report.lattice_shortcut);
    EXPECT_LE(w->report.residual, 1e-13);
  }
  std::map<long, double> by_distance;
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = all.neighbours.row[i]; n < all.neighbours.row[i + 1]; ++n) {
      const Vec3 r = all.neighbours.x_ji(cloud.x, i, n);
      const auto [known, is_new] = by_distance.try_emplace(std::lround(100 * dot(r, r)), all.G[n]);
      EXPECT_NEAR(known->second, all.G[n], 1e-15);
    }
  }
  const int corner = 7;  // at xmax, ymin, zmin; xmin and zmax are out of reach
  ASSERT_EQ(cloud.lattice->index(cloud.id[corner]), (LatticeIndex{7, 0, 0}));
  for (auto n = some.neighbours.row[corner]; n < some.neighbours.row[corner + 1]; ++n) {
    const Vec3 r = some.neighbours.x_ji(cloud.x, corner, n);
    if (r.z > 0.25) {
      EXPECT_NEAR(by_distance.at(std::lround(100 * dot(r, r))), some.G[n], 1e-15);
    }
  }
}

TEST(LatticeImages, LeaveThinBodiesWithImagesOnOneSideToTheSolve) {
  const Cloud cloud = box_cloud({9, 2}, 0.1, {.support = 3.6, .on_walls = false});
  const Weights w = bonds(cloud, 3.015, 0b0100);
  EXPECT_FALSE(w.report.lattice_shortcut);
  EXPECT_LE(w.report.residual, 1e-12);
}

/// Decay rate of cos(pi x) cos(pi y) .. in the insulated unit cube, over D pi^2, less 1.
double decay_error(std::int64_t n, int dimension, double horizon, bool on_walls) {
  constexpr double pi = std::numbers::pi;
  const double d = 1.0 / static_cast<double>(on_walls ? n - 1 : n);
  const Cloud cloud =
      box_cloud(std::vector<std::int64_t>(dimension, n), d, {.support = horizon + 0.6, .on_walls = on_walls});
  const Weights w = bonds(cloud, horizon);
  std::vector<double> u(cloud.owned, 1);
  for (int i = 0; i < cloud.owned; ++i)
    for (int a = 0; a < dimension; ++a) u[i] *= std::cos(pi * cloud.x[i][a]);
  double power = 0, heat = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    heat += cloud.volume[i] * u[i] * u[i];
    for (auto n = w.neighbours.row[i]; n < w.neighbours.row[i + 1]; ++n)
      power += 0.5 * w.G[n] * std::pow(u[w.neighbours.column[n]] - u[i], 2);
  }
  return power / heat / (dimension * pi * pi) - 1;
}

TEST(LatticeImages, ConvergeWithSecondOrder) {
  for (const bool on_walls : {true, false}) {
    for (const int dimension : {1, 2, 3}) {
      for (const double horizon : {2.0, 3.015}) {
        const std::int64_t n = dimension == 3 ? 12 : 24, more = 2 * n - (on_walls ? 1 : 0);
        const double coarse = decay_error(n, dimension, horizon, on_walls);
        const double fine = decay_error(more, dimension, horizon, on_walls);
        EXPECT_GT(std::log2(coarse / fine), 1.85) << dimension << "D " << horizon << " " << coarse << " " << fine;
        EXPECT_LE(std::abs(fine), 0.03);
      }
    }
  }
}

}  // namespace
}  // namespace calor
