#include "cloud/convex_cell.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "case_models.hpp"

namespace calor {
namespace {

ConvexCell box(const Vec3& low, const Vec3& high, int dimension = 3) {
  ConvexCell cell;
  cell.set(low, high, dimension);
  return cell;
}

Vec3 direction(int n) { return {scattered(3 * n), scattered(3 * n + 1), scattered(3 * n + 2)}; }

TEST(ConvexCell, HasTheMomentsOfABox) {
  const auto m = box({-1, -2, -1}, {2, 1, 3}).moments();
  EXPECT_NEAR(m.volume, 36, 1e-13);
  EXPECT_NEAR(m.first.x, 18, 1e-13);
  EXPECT_NEAR(m.first.y, -18, 1e-13);
  EXPECT_NEAR(m.first.z, 36, 1e-13);
  EXPECT_NEAR(m.second[0], 36, 1e-12);          // 12 [x^3 / 3] = 12 * 3
  EXPECT_NEAR(m.second[1], 36, 1e-12);          // 12 [y^3 / 3] = 12 * 3
  EXPECT_NEAR(m.second[2], 84, 1e-12);          // 9 [z^3 / 3] = 9 * 28 / 3
  EXPECT_NEAR(m.second[3], 36 * -0.25, 1e-12);  // volume times the product of the means
  EXPECT_NEAR(m.second[4], 36 * 0.5, 1e-12);
  EXPECT_NEAR(m.second[5], 36 * -0.5, 1e-12);
  EXPECT_NEAR(box({-1, -2, 0}, {2, 1, 0}, 2).volume(), 9, 1e-13);
  EXPECT_NEAR(box({-1, 0, 0}, {2, 0, 0}, 1).volume(), 3, 1e-13);
}

TEST(ConvexCell, CutsACornerOffACube) {
  // x + y + z <= 2.5 of the unit cube: without a tetrahedron of edges 0.5.
  ConvexCell cell = box({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(cell.cut({1, 1, 1}, 2.5));
  EXPECT_NEAR(cell.volume(), 1 - 0.125 / 6, 1e-15);
  EXPECT_FALSE(cell.cut({1, 1, 1}, 2.6));
  EXPECT_NEAR(cell.reach(), std::sqrt(2.25), 1e-15);  // corners such as (1, 1, 0.5)
}

TEST(ConvexCell, PartsOnBothSidesOfAPlaneMakeTheWhole) {
  for (int n = 0; n < 200; ++n) {
    ConvexCell whole = box({-1, -1, -1}, {1, 1, 1});
    for (int cut = 0; cut < 12; ++cut) whole.cut(direction(20 * n + cut), 0.5);
    const Vec3 normal = direction(20 * n + 19);
    ConvexCell below = whole, above = whole;
    below.cut(normal, 0.1), above.cut(-normal, -0.1);
    const auto all = whole.moments(), a = below.moments(), b = above.moments();
    EXPECT_NEAR(a.volume + b.volume, all.volume, 1e-13);
    EXPECT_LE(norm(a.first + b.first - all.first), 1e-13);
    for (int c = 0; c < 6; ++c) EXPECT_NEAR(a.second[c] + b.second[c], all.second[c], 1e-13);
  }
}

TEST(ConvexCell, CutsThroughCornersAndEdgesWhateverTheRounding) {
  // A cube, cut through its edges by planes that all meet in its corners: the octahedron |x| + |y| + |z| <= 1 and the
  // rhombic dodecahedron |x| + |y| <= 1, ..., of volumes 4/3 and 2.
  ConvexCell octahedron = box({-1, -1, -1}, {1, 1, 1}), dodecahedron = octahedron;
  for (const double x : {-1. / 3, 1. / 3})
    for (const double y : {-1. / 3, 1. / 3})
      for (const double z : {-1. / 3, 1. / 3}) octahedron.cut({x, y, z}, 1. / 3);
  for (const double s : {-0.7, 0.7})
    for (const double t : {-0.7, 0.7}) {
      dodecahedron.cut({s, t, 0}, 0.7);
      dodecahedron.cut({s, 0, t}, 0.7);
      dodecahedron.cut({0, s, t}, 0.7);
    }
  EXPECT_NEAR(octahedron.volume(), 4. / 3, 1e-13);
  EXPECT_NEAR(dodecahedron.volume(), 2, 1e-13);
}

}  // namespace
}  // namespace calor
