#include "cloud/lattice.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "cloud/cloud.hpp"
#include "cloud/points.hpp"

namespace calor {
namespace {

Cloud cloud_of(const BoxLattice& box, MPI_Comm comm = MPI_COMM_SELF) {
  return distribute(comm, make_box(comm, box), 2 * Lattice(box).largest_dx());
}

BoxLattice box_of(int dimension) {
  return {.dimension = dimension,
          .size = {1.2, 0.7, 0.9},
          .points = {7, 5, 4},
          .origin = {0.1, dimension > 1 ? -3.0 : 0.0, 0}};
}

TEST(Lattice, HasItsOutermostPointsOnTheWallsToTheLastBit) {
  const BoxLattice box = {.dimension = 1, .size = {0.7, 0, 0}, .points = {1000, 1, 1}, .origin = {0.1, 0, 0}};
  const Cloud c = cloud_of(box);
  EXPECT_EQ(c.x.front().x, 0.1);
  EXPECT_EQ(c.x.back().x, 0.1 + 0.7);
}

TEST(Lattice, RunsAlongXFirst) {
  const std::vector<Point> p = make_box(MPI_COMM_SELF, box_of(3)).points;
  ASSERT_EQ(p.size(), 7u * 5 * 4);
  for (int i = 0; i < 140; ++i) {
    EXPECT_EQ(p[i].id, i);
    EXPECT_NEAR(p[i].x.x, 0.1 + 0.2 * (i % 7), 1e-15);
    EXPECT_NEAR(p[i].x.y, -3 + 0.175 * (i / 7 % 5), 1e-15);
    EXPECT_NEAR(p[i].x.z, 0.3 * (i / 35), 1e-15);
  }
}

TEST(Lattice, CutsTheCellsOfWallPointsInHalvesQuartersAndEighths) {
  const Cloud c = cloud_of(box_of(3));
  for (int i = 0; i < c.owned; ++i) {
    const int walls = std::popcount(c.on_faces[i]);
    EXPECT_DOUBLE_EQ(c.volume[i], c.full_volume[i] / (1 << walls));
    EXPECT_DOUBLE_EQ(c.full_volume[i], 0.2 * 0.175 * 0.3);
    EXPECT_DOUBLE_EQ(c.spacing[i], 0.3);  // the largest of the three
  }
}

TEST(Lattice, GivesEveryWallItsArea) {
  for (const bool on_walls : {true, false}) {
    BoxLattice box = box_of(3);
    box.on_walls = on_walls;
    const Cloud c = cloud_of(box);
    std::vector<double> area(6, 0.0);
    for (const Facet& p : c.facets) {
      area[p.face] += p.area;
      EXPECT_EQ(p.normal[p.face / 2], p.face % 2 ? 1 : -1);
      EXPECT_TRUE(c.on_faces[p.point] >> p.face & 1);
    }
    const std::vector<double> exact = {0.63, 0.63, 1.08, 1.08, 0.84, 0.84};
    for (int f = 0; f < 6; ++f) EXPECT_NEAR(area[f], exact[f], 1e-14) << c.faces[f];
  }
}

TEST(Lattice, InCellsHasItsPointsAtTheCentresOfWholeCells) {
  BoxLattice box = box_of(2);
  box.on_walls = false;
  const Cloud c = cloud_of(box);
  EXPECT_FALSE(c.points_on_walls);
  EXPECT_DOUBLE_EQ(c.x[0].x, 0.1 + 1.2 / 14);
  EXPECT_DOUBLE_EQ(c.x[0].y, -3 + 0.07);
  for (int i = 0; i < c.owned; ++i) EXPECT_DOUBLE_EQ(c.volume[i], 1.2 * 0.7 / 35);
}

TEST(Lattice, IsABoxLatticeOnlyWithOneSpacingAlongAllAxes) {
  EXPECT_FALSE(cloud_of(box_of(3)).box_lattice);
  EXPECT_TRUE(cloud_of(box_of(1)).box_lattice);
  EXPECT_TRUE(cloud_of({.dimension = 2, .size = {0.3, 0.1, 0}, .points = {31, 11, 1}}).box_lattice);
  EXPECT_FALSE(cloud_of({.dimension = 2, .size = {0.3, 0.1, 0}, .points = {31, 11, 1}, .jitter = 0.1}).box_lattice);
}

TEST(LatticeParallel, ClosesTheBodyExactly) {
  for (int dimension : {1, 2, 3}) {
    for (const bool on_walls : {true, false}) {
      for (const double jitter : {0.0, 0.2, 0.45}) {
        BoxLattice box = box_of(dimension);
        box.on_walls = on_walls;
        box.jitter = jitter;
        box.section = dimension == 3 ? 1 : 0.01;
        const CloudCheck c = check(cloud_of(box, MPI_COMM_WORLD));
        EXPECT_LT(c.volume_error, 1e-13) << dimension << on_walls << jitter;
        EXPECT_LT(c.area_sum, 1e-13) << dimension << on_walls << jitter;
        EXPECT_LT(c.moment_sum, 1e-13) << dimension << on_walls << jitter;
      }
    }
  }
}

}  // namespace
}  // namespace calor
