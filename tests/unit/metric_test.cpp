// Points that are flatter or longer than cubes: lengths are measured in the spacings along the axes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "conduction/faces.hpp"
#include "conduction/mls.hpp"
#include "conduction/peridynamics.hpp"
#include "conduction/quadrature.hpp"
#include "method_clouds.hpp"
#include "shape_functions.hpp"

namespace calor {
namespace {

/// A lattice with the given intervals along its axes.
BoxLattice flat_box(std::vector<std::int64_t> points, std::vector<double> dx, double jitter = 0) {
  BoxLattice box;
  box.dimension = static_cast<int>(points.size());
  for (int a = 0; a < box.dimension; ++a) {
    box.points[a] = points[a];
    box.size[a] = dx[a] * static_cast<double>(points[a] - 1);
  }
  box.jitter = jitter;
  return box;
}

Cloud flat_cloud(const BoxLattice& box, MPI_Comm comm = MPI_COMM_SELF, const Support& support = 4) {
  return distribute(comm, make_box(comm, box), support);
}

const std::vector<std::vector<double>> stretches = {{1, 1, 1}, {4, 1, 2}, {40, 1, 7}, {1e-6, 4e-5, 1e-5}};

TEST(Metric, FlatPointsHaveTheNeighboursOfCubes) {
  const Neighbours cubes = find_neighbours(flat_cloud(flat_box({7, 6, 5}, {1, 1, 1})), 2.3);
  for (const auto& dx : stretches) {
    const Cloud cloud = flat_cloud(flat_box({7, 6, 5}, dx));
    const Neighbours flat = find_neighbours(cloud, 2.3);
    EXPECT_EQ(flat.row, cubes.row);
    EXPECT_EQ(flat.column, cubes.column);
  }
}

TEST(Metric, AHorizonInMetresIsASphere) {
  const Cloud cloud = flat_cloud(flat_box({21, 81}, {0.1, 0.025}), MPI_COMM_SELF, {0, 0.21});
  const Neighbours is = find_neighbours(cloud, {0, 0.21});
  for (int i = 0; i < cloud.owned; ++i) {
    std::vector<std::int32_t> all;
    for (int j = 0; j < cloud.owned; ++j)
      if (j != i && norm(cloud.x[j] - cloud.x[i]) < 0.21) all.push_back(j);
    std::ranges::sort(all, {}, [&](int j) { return cloud.id[j]; });
    ASSERT_TRUE(std::ranges::equal(is.of(i), all));
  }
}

TEST(MetricParallel, RanksFindTheSameNeighboursOfFlatPoints) {
  for (const double jitter : {0.0, 0.3}) {
    const BoxLattice box = flat_box({12, 20, 9}, {4, 0.1, 1}, jitter);
    const Cloud mine = flat_cloud(box, MPI_COMM_WORLD, 2.4), all = flat_cloud(box, MPI_COMM_SELF, 2.4);
    const Neighbours a = find_neighbours(mine, 2.4), b = find_neighbours(all, 2.4);
    std::map<std::int64_t, std::vector<std::int64_t>> ids;
    for (int i = 0; i < all.owned; ++i)
      for (const int j : b.of(i)) ids[all.id[i]].push_back(all.id[j]);
    for (int i = 0; i < mine.owned; ++i) {
      std::vector<std::int64_t> here;
      for (const int j : a.of(i)) here.push_back(mine.id[j]);
      EXPECT_EQ(here, ids[mine.id[i]]);
    }
  }
}

TEST(Metric, CellsOfJitteredFlatPointsAreThoseOfCubesStretched) {
  const Cloud cubes = flat_cloud(flat_box({7, 6, 5}, {1, 1, 1}, 0.3));
  for (const auto& dx : stretches) {
    const Cloud flat = flat_cloud(flat_box({7, 6, 5}, dx, 0.3));
    const CellQuadrature a = gauss_points(cubes), b = gauss_points(flat);
    for (int i = 0; i < flat.owned; ++i) EXPECT_NEAR(flat.volume[i] / (dx[0] * dx[1] * dx[2]), cubes.volume[i], 1e-11);
    ASSERT_EQ(a.x.size(), b.x.size());
    // The square root of a covariance is unique but for turns, so the sums of squares are compared.
    for (int i = 0; i < flat.owned; ++i) {
      Vec3 squares, stretched;
      for (auto q = a.cell[i]; q < a.cell[i + 1]; ++q) {
        const Vec3 u = a.x[q], v = quotient(b.x[q], {dx[0], dx[1], dx[2]});
        squares += product(u, u), stretched += product(v, v);
      }
      EXPECT_LE(norm(squares - stretched), 1e-9 * norm(squares) + 1e-9);
    }
  }
}

TEST(Metric, ShapeFunctionsStretchWithThePoints) {
  const MovingLeastSquares mls{3, 1};
  std::vector<Vec3> x, R;
  for (int k = 0; k < 27; ++k) {
    const Vec3 u = hashed_uniform(3, k);
    x.push_back({k % 3 - 1 + 0.2 * u.x, k / 3 % 3 - 1 + 0.2 * u.y, k / 9 - 1 + 0.2 * u.z}),
        R.push_back({2.5, 2.5, 2.5});
  }
  const Vec3 at{0.1, -0.2, 0.05};
  const ShapesAtPlace cubes = shape_functions(mls, at, x, R);
  ASSERT_TRUE(cubes.fitted);
  for (const auto& dx : stretches) {
    const Vec3 s{dx[0], dx[1], dx[2]};
    std::vector<Vec3> x_flat, R_flat;
    for (int k = 0; k < 27; ++k) x_flat.push_back(product(s, x[k])), R_flat.push_back(product(s, R[k]));
    const ShapesAtPlace flat = shape_functions(mls, product(s, at), x_flat, R_flat);
    ASSERT_TRUE(flat.fitted);
    for (int k = 0; k < 27; ++k) {
      EXPECT_NEAR(flat.phi[k], cubes.phi[k], 1e-12);
      EXPECT_LE(norm(product(s, flat.gradient[k]) - cubes.gradient[k]), 1e-11);
    }
  }
}

/// Weights by lines of points, with the neighbours they belong to.
Weights line_weights(const Cloud& cloud, const Peridynamics& options) {
  Weights w;
  w.neighbours = find_neighbours(cloud, options.support());
  w.G = peridynamic_weights(cloud, w.neighbours, options, w.report);
  return w;
}

TEST(Metric, LinesOfPointsKeepLinearTemperaturesWithPositiveWeights) {
  for (const double horizon : {2.0, 3.015}) {
    for (const int n : {0, 1, 2}) {
      for (const auto& dx : stretches) {
        if (dx[0] == dx[1]) continue;  // cubes have weights of another kind
        const Peridynamics options{.n = n, .horizon = horizon};
        const auto w = line_weights(flat_cloud(flat_box({9, 8, 7}, dx)), options);
        EXPECT_TRUE(w.report.lattice_shortcut);
        EXPECT_LE(w.report.residual, 1e-14);
        EXPECT_GE(*std::ranges::min_element(w.G), 0);
      }
    }
  }
}

TEST(Metric, AcrossEveryIntervalOfALineTheForcesAddUpToItsFace) {
  // A rod of unit section with intervals that jump: whatever the horizon, sum of G |x_ji| over the pairs across = 1.
  BoxLattice box;
  box.dimension = 1;
  box.coordinates[0] = {0, 0.1, 0.2, 1.2, 1.3, 3, 3.01, 3.5, 4, 4.5, 5};
  for (const bool on_walls : {true, false}) {
    box.on_walls = on_walls;
    const Cloud cloud = flat_cloud(box, MPI_COMM_SELF, 6);
    const std::vector<Support> horizons = {Support(1), Support(2), Support(3.015), Support(0, 2)};
    for (const Support& horizon : horizons) {
      for (const bool partial : {true, false}) {
        const auto w = line_weights(flat_cloud(box, MPI_COMM_SELF, horizon.length > 0 ? Support(1, 2.2) : Support(6)),
                                    {.n = 2, .horizon = horizon, .partial_volumes = partial});
        EXPECT_LE(w.report.residual, 1e-13);
        EXPECT_GE(*std::ranges::min_element(w.G), 0);
      }
    }
  }
}

TEST(Metric, AHorizonShorterThanTheDistanceOfThePointsIsRefusedWithBoth) {
  const Cloud cloud = flat_cloud(flat_box({5, 21}, {1, 0.05}), MPI_COMM_SELF, {0.5, 0.3});
  try {
    line_weights(cloud, {.horizon = {0, 0.2}, .partial_volumes = false});
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(e.problem().find("along x are 1 m apart"), std::string::npos) << e.problem();
  }
}

TEST(Metric, VirtualFacesOfFlatPointsAreThoseOfCubesStretched) {
  const Cloud cubes = flat_cloud(flat_box({9, 8}, {1, 1}, 0.2));
  FaceReport of_cubes;
  const Faces a = virtual_faces(cubes, of_cubes);
  for (const double ratio : {4.0, 40.0}) {
    const Cloud flat = flat_cloud(flat_box({9, 8}, {ratio, 1}, 0.2));
    FaceReport report;
    const Faces b = virtual_faces(flat, report);
    EXPECT_LE(report.residual, 1e-12);
    EXPECT_NEAR(report.moment_error, of_cubes.moment_error, 1e-4);
    ASSERT_EQ(a.size(), b.size());
    // The fit of the second moments ends after a number of iterations; what it leaves is at the mercy of rounding.
    for (std::size_t q = 0; q < a.size(); ++q) EXPECT_LE(norm(product(b.area[q], {1, 1 / ratio, 1}) - a.area[q]), 2e-3);
  }
}

TEST(Metric, JitteredFlatPointsAreRefusedByPairsWithTheNumberThatTells) {
  const auto cloud_of = [](double ratio) { return flat_cloud(flat_box({15, 15}, {ratio, 1}, 0.2)); };
  for (const double ratio : {1., 2.}) {
    const Cloud cloud = cloud_of(ratio);
    EXPECT_NO_THROW(require_sound(cloud, sph_weights(cloud, 1.2).report));
  }
  for (const double ratio : {5., 10.}) {
    const Cloud cloud = cloud_of(ratio);
    const CorrectionReport report = sph_weights(cloud, 1.2).report;
    EXPECT_GT(report.moment_error, 0.3);
    EXPECT_THROW(require_sound(cloud, report), Error);
  }
}

}  // namespace
}  // namespace calor
