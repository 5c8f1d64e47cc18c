#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cloud/cloud.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

Cloud cloud_of(const Rings& rings, MPI_Comm comm = MPI_COMM_SELF) {
  return distribute(comm, make_rings(comm, rings), 3 * rings.radius / rings.rings);
}

double angle(Sector s) { return s == Sector::full ? 2 * pi : s == Sector::half ? pi : pi / 2; }

double area_of(const Cloud& c, const std::string& face) {
  double area = 0;
  for (const Facet& p : c.facets) area += c.faces[p.face] == face ? p.area : 0;
  return area;
}

TEST(RingsParallel, CloseTheBodyExactlyForEverySector) {
  for (const Sector sector : {Sector::full, Sector::half, Sector::quarter}) {
    for (const int levels : {0, 2, 5}) {
      for (const int rings : {1, 2, 3, 10}) {
        const Rings r = {
            .radius = 0.015, .rings = rings, .height = 0.0025, .levels = levels, .sector = sector, .thickness = 0.3};
        const CloudCheck c = check(cloud_of(r, MPI_COMM_WORLD));
        const double exact = angle(sector) / 2 * 0.015 * 0.015 * (levels ? 0.0025 : 0.3);
        EXPECT_NEAR(c.volume, exact, 1e-13 * exact);
        EXPECT_LT(c.volume_error, 1e-13);
        EXPECT_LT(c.area_sum, 1e-13);
        EXPECT_LT(c.moment_sum, 1e-13);
      }
    }
  }
}

TEST(Rings, HaveSixMorePointsOnEveryRing) {
  const Cloud full = cloud_of({.radius = 1, .rings = 10});
  EXPECT_EQ(full.count, 1 + 6 * 55);  // 1 + 6 (1 + ... + 10)
  EXPECT_EQ(cloud_of({.radius = 1, .rings = 10, .sector = Sector::half}).count, 1 + 3 * 55 + 10);
  // Quarter: intervals max(2, round(1.5 m)), halves to even: 2 3 4 6 8 9 10 12 14 15 and one more point on each ring.
  EXPECT_EQ(cloud_of({.radius = 1, .rings = 10, .sector = Sector::quarter}).count, 1 + 83 + 10);
  EXPECT_EQ(cloud_of({.radius = 1, .rings = 10, .height = 1, .levels = 4}).count, 4 * 331);
}

TEST(Rings, HaveTheWholeSideAsExchangingArea) {
  for (const Sector sector : {Sector::full, Sector::half, Sector::quarter}) {
    const Cloud disc = cloud_of({.radius = 2, .rings = 6, .sector = sector, .thickness = 0.1});
    EXPECT_NEAR(area_of(disc, "side"), angle(sector) * 2 * 0.1, 1e-14);
    const Cloud cylinder = cloud_of({.radius = 2, .rings = 6, .height = 3, .levels = 4, .sector = sector});
    EXPECT_NEAR(area_of(cylinder, "side"), angle(sector) * 2 * 3, 1e-13);
    EXPECT_NEAR(area_of(cylinder, "top"), angle(sector) * 2, 1e-13);
    EXPECT_NEAR(area_of(cylinder, "bottom"), angle(sector) * 2, 1e-13);
    if (sector == Sector::quarter) {
      EXPECT_NEAR(area_of(cylinder, "cut1"), 2 * 3, 1e-14);
      EXPECT_NEAR(area_of(cylinder, "cut2"), 2 * 3, 1e-14);
    }
    if (sector == Sector::half) {
      EXPECT_NEAR(area_of(cylinder, "cut1"), 4 * 3, 1e-14);
    }
  }
}

TEST(Rings, HaveSideNormalsThatPointOutward) {
  const Cloud c = cloud_of({.radius = 2, .rings = 5, .height = 1, .levels = 3});
  for (const Facet& p : c.facets) {
    if (c.faces[p.face] != "side") continue;
    const Vec3 radial = {c.x[p.point].x / 2, c.x[p.point].y / 2, 0};
    EXPECT_NEAR(norm(p.normal - radial), 0, 1e-14);
  }
}

TEST(Rings, HaveAreaVectorsOfTheChordsOnTheSide) {
  const Cloud c = cloud_of({.radius = 1, .rings = 4});
  for (const Facet& p : c.facets) {
    EXPECT_NEAR(norm(c.area[p.point]), 2 * std::sin(pi / 24), 1e-15);  // 24 points on the side
    EXPECT_NEAR(p.area, 2 * pi / 24, 1e-15);
  }
}

TEST(Rings, LieOnTheCutsOfASectorToTheLastBit) {
  const Cloud quarter = cloud_of({.radius = 1, .rings = 7, .sector = Sector::quarter});
  const Cloud half = cloud_of({.radius = 1, .rings = 7, .sector = Sector::half});
  EXPECT_EQ(quarter.faces, (std::vector<std::string>{"side", "cut1", "cut2"}));
  EXPECT_EQ(half.faces, (std::vector<std::string>{"side", "cut1"}));
  for (const Facet& p : quarter.facets) {
    if (quarter.faces[p.face] == "cut1") {
      EXPECT_EQ(quarter.x[p.point].y, 0);
    }
    if (quarter.faces[p.face] == "cut2") {
      EXPECT_EQ(quarter.x[p.point].x, 0);
    }
  }
  for (const Facet& p : half.facets) {
    if (half.faces[p.face] == "cut1") {
      EXPECT_EQ(half.x[p.point].y, 0);
    }
  }
}

TEST(Rings, AreTheSamePointsInAQuarterWhereTheIntervalsFit) {
  // Every ring of even number has whole multiples of four points: its quarter is the quarter of the whole.
  const Points full = make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 4});
  const Points quarter = make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 4, .sector = Sector::quarter});
  for (const Point& q : quarter.points) {
    const double r = norm(q.x);
    if (std::abs(r - 0.5) > 1e-9 && std::abs(r - 1) > 1e-9) continue;
    double nearest = 1, full_volume = 0;
    for (const Point& p : full.points) {
      if (norm(p.x - q.x) < nearest) nearest = norm(p.x - q.x), full_volume = p.full_volume;
    }
    EXPECT_LT(nearest, 1e-15);
    EXPECT_NEAR(q.full_volume, full_volume, 1e-15);
  }
}

TEST(Rings, HaveFullVolumesThatCountTheCellsOutsideToo) {
  const Points p = make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 5, .height = 2, .levels = 3});
  double sum = 0;
  for (const Point& q : p.points) sum += q.full_volume;
  EXPECT_NEAR(sum, pi * 1.1 * 1.1 * 3, 1e-12);  // half a ring and half a level beyond each wall
}

}  // namespace
}  // namespace calor
