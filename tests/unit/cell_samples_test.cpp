#include "cloud/cell_samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/parallel.hpp"
#include "case_models.hpp"
#include "cloud/shapes.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

/// Integral of f over the body by the samples.
template <class F>
double integral(const CellSamples& s, const F& f) {
  double sum = 0;
  for (std::size_t n = 0; n < s.x.size(); ++n) sum += s.weight[n] * f(s.x[n]);
  return sum;
}

TEST(CellSamples, WeighAsMuchAsTheVolumeOfTheirPoint) {
  for (const double jitter : {0.0, 0.3}) {
    for (const std::vector<std::int64_t>& points :
         {std::vector<std::int64_t>{9}, std::vector<std::int64_t>{9, 7}, std::vector<std::int64_t>{5, 6, 7}}) {
      const Cloud cloud = box_cloud(points, 0.1, {.jitter = jitter, .section = points.size() < 3 ? 0.02 : 1});
      const CellSamples s = CellSampler(cloud).all();
      ASSERT_EQ(s.row.size(), static_cast<std::size_t>(cloud.owned) + 1);
      for (int k = 0; k < cloud.owned; ++k) {
        EXPECT_EQ(s.point[k], k);
        double sum = 0;
        for (auto n = s.row[k]; n < s.row[k + 1]; ++n) sum += s.weight[n];
        EXPECT_NEAR(sum, cloud.volume[k], 1e-13 * cloud.volume[k]);
      }
    }
  }
}

TEST(CellSamples, FillTheBoxesOfALatticeExactly) {
  // The mean of x over the box of a point on a wall lies a quarter spacing inside; the samples have it to round-off.
  for (const bool on_walls : {true, false}) {
    const Cloud cloud = box_cloud({6, 5}, 0.1, {.on_walls = on_walls});
    const CellSamples s = CellSampler(cloud).all();
    for (int k = 0; k < cloud.owned; ++k) {
      Vec3 mean, expected = cloud.x[k];
      for (auto n = s.row[k]; n < s.row[k + 1]; ++n) mean += (s.weight[n] / cloud.volume[k]) * s.x[n];
      for (const Facet& p : cloud.facets)
        if (on_walls && p.point == k) expected -= 0.025 * p.normal;
      EXPECT_NEAR(norm(mean - expected), 0, 1e-14);
    }
  }
}

TEST(CellSamples, BelongToTheNearestPointAndLieInTheBody) {
  for (const std::vector<std::int64_t>& points :
       {std::vector<std::int64_t>{12, 11}, std::vector<std::int64_t>{6, 7, 5}}) {
    for (const bool on_walls : {true, false}) {
      const Cloud cloud = box_cloud(points, 0.1, {.jitter = 0.4, .on_walls = on_walls});
      const CellSamples s = CellSampler(cloud).all();
      for (int k = 0; k < cloud.owned; ++k) {
        for (auto n = s.row[k]; n < s.row[k + 1]; ++n) {
          const double r = norm(s.x[n] - cloud.x[k]);
          for (int j = 0; j < cloud.owned; ++j) EXPECT_GE(norm(s.x[n] - cloud.x[j]), r * (1 - 1e-12));
          for (std::size_t a = 0; a < points.size(); ++a) {
            EXPECT_GE(s.x[n][a], 0);
            EXPECT_LE(s.x[n][a], 0.1 * static_cast<double>(points[a] - (on_walls ? 1 : 0)));
          }
        }
      }
    }
  }
}

TEST(CellSamples, IntegrateSmoothFunctionsOnJitteredAndRoundClouds) {
  const auto f = [](const Vec3& x) { return std::exp(x.x + 2 * x.y); };
  {
    const Cloud cloud = box_cloud({21, 11}, 0.05, {.jitter = 0.3});
    const double exact = (std::exp(1) - 1) * (std::exp(1) - 1) / 2;
    EXPECT_NEAR(integral(CellSampler(cloud).all(), f), exact, 1e-3 * exact);
  }
  {
    // A disc of radius 1: the integral of x^2 is pi/4. First order at the rim: the boxes of the outermost points are
    // cut by tangents.
    const Cloud cloud = distribute(MPI_COMM_SELF, make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 20}), 0.15);
    const double square = integral(CellSampler(cloud).all(), [](const Vec3& x) { return x.x * x.x; });
    EXPECT_NEAR(square, M_PI / 4, 5e-3);
  }
}

TEST(CellSamples, NearAPlaceAreThoseOfAllTheCloud) {
  for (const double jitter : {0.0, 0.3}) {
    const Cloud cloud = box_cloud({21, 16}, 0.05, {.jitter = jitter});
    const CellSampler sampler(cloud);
    const CellSamples all = sampler.all();
    CellSamples near;
    const Vec3 centre{0.31, 0.72, 0};
    for (int repeat = 0; repeat < 2; ++repeat) sampler.near(centre, 0.2, near);
    std::size_t k = 0;
    for (int i = 0; i < cloud.owned; ++i) {
      if (norm(cloud.x[i] - centre) > 0.2) continue;
      ASSERT_LT(k, near.point.size());
      EXPECT_EQ(near.point[k], i);
      ASSERT_EQ(near.row[k + 1] - near.row[k], all.row[i + 1] - all.row[i]);
      for (auto n = near.row[k], m = all.row[i]; n < near.row[k + 1]; ++n, ++m) EXPECT_EQ(near.x[n], all.x[m]);
      ++k;
    }
    EXPECT_EQ(k, near.point.size());
    EXPECT_EQ(near.row.size(), k + 1);
    EXPECT_EQ(near.weight.size(), near.x.size());
  }
}

/// All other points, nearest first.
std::vector<Rival> rivals_of(const Cloud& cloud, int i) {
  std::vector<Rival> rivals;
  for (int j = 0; j < cloud.local(); ++j) {
    const Vec3 r = cloud.x[j] - cloud.x[i];
    if (j != i) rivals.push_back({cloud.x[j], dot(r, r), cloud.id[j], cloud.area[j], cloud.on_faces[j]});
  }
  std::ranges::sort(rivals, {}, &Rival::square);
  return rivals;
}

std::vector<Vec3> sorted(std::vector<Vec3> x) {
  std::ranges::sort(x, {}, [](const Vec3& p) { return std::tuple(p.x, p.y, p.z); });
  return x;
}

void expect_same_places_by_cubes(const Cloud& cloud) {
  for (int i = 0; i < cloud.owned; ++i) {
    std::vector<Facet> facets;
    for (const Facet& facet : cloud.facets)
      if (facet.point == i) facets.push_back(facet);
    const std::vector<Rival> rivals = rivals_of(cloud, i);
    NearestCell cell(cloud, i, facets, rivals, 1.25);
    constexpr int n = 12, per_cube = 4;
    std::vector<Vec3> by_cubes, one_by_one;
    SampleCubes cubes, single;
    cell.sample(0, n, per_cube, by_cubes, cubes);
    cell.sample(0, n, 1, one_by_one, single);
    EXPECT_EQ(sorted(by_cubes), sorted(one_by_one));
    ASSERT_EQ(cubes.begin.size(), cubes.index.size() + 1);
    EXPECT_EQ(cubes.begin.back(), static_cast<std::int32_t>(by_cubes.size()));
    for (std::size_t k = 0; k < cubes.index.size(); ++k)
      for (std::int32_t place = cubes.begin[k]; place < cubes.begin[k + 1]; ++place)
        for (int a = 0; a < cloud.dimension; ++a)
          EXPECT_LE(std::abs(by_cubes[place][a] - by_cubes[cubes.begin[k]][a]), cloud.spacing[i] * per_cube / n);
  }
}

TEST(CellSamples, AreTheSameIfWholeCubesAreAskedFirst) {
  expect_same_places_by_cubes(box_cloud({9, 8}, 0.1, {.jitter = 0.4}));
  expect_same_places_by_cubes(box_cloud({4, 5, 4}, 0.1, {.jitter = 0.4}));
  expect_same_places_by_cubes(box_cloud({4, 5, 4}, 0.1, {.jitter = 0.4, .on_walls = false}));
  const Cloud by_surface = make_cloud(MPI_COMM_SELF, parse_case(R"toml(
title = "a box with a hole"
method = "sph"
[steady]
[cloud]
shape = "surface"
spacing = "0.2 m"
part = [{ shape = "box", size = ["1 m", "1 m", "0.6 m"] },
        { shape = "cylinder", radius = "0.2 m", height = "1 m", at = ["0.5 m", "0.5 m", "-0.1 m"], combine = "cut" }]
[material.m]
conductivity = "1 W/(m K)"
)toml"),
                                      2);
  expect_same_places_by_cubes(by_surface);
}

TEST(CellSamplesParallel, DoNotDependOnTheRanks) {
  for (const std::vector<std::int64_t>& points :
       {std::vector<std::int64_t>{23, 17}, std::vector<std::int64_t>{9, 8, 7}}) {
    BoxOptions o{.jitter = 0.4, .support = 2.4};
    const Cloud serial = box_cloud(points, 0.1, o);
    o.comm = MPI_COMM_WORLD;
    const Cloud cloud = box_cloud(points, 0.1, o);
    const CellSamples all = CellSampler(serial).all(), mine = CellSampler(cloud).all();
    std::vector<int> of_id(serial.owned);
    for (int i = 0; i < serial.owned; ++i) of_id[serial.id[i]] = i;
    for (int k = 0; k < cloud.owned; ++k) {
      const int i = of_id[cloud.id[k]];
      ASSERT_EQ(mine.row[k + 1] - mine.row[k], all.row[i + 1] - all.row[i]);
      for (auto n = mine.row[k], m = all.row[i]; n < mine.row[k + 1]; ++n, ++m) EXPECT_EQ(mine.x[n], all.x[m]);
    }
  }
}

}  // namespace
}  // namespace calor
