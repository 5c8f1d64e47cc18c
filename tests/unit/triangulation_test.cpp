#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/error.hpp"
#include "surface/outline.hpp"
#include "surface/plane.hpp"
#include "surface/triangulate.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

/// A polygon whose corners a centre sees at growing angles, at distances from `least` to `radius`.
std::vector<Vec3> star(std::mt19937& random, const Vec3& centre, double least, double radius, int corners) {
  std::uniform_real_distribution<double> distance(least, radius), early(0, 0.8);
  std::vector<Vec3> out;
  for (int n = 0; n < corners; ++n) {
    const double angle = 2 * pi * (n + early(random)) / corners, r = distance(random);
    out.push_back(centre + r * Vec3{std::cos(angle), std::sin(angle), 0});
  }
  return out;
}

Outline outline_of(const std::vector<std::vector<Vec3>>& polygons) {
  Outline out;
  out.faces = {"side"};
  for (const std::vector<Vec3>& polygon : polygons) {
    Contour contour{.corner = polygon, .face = std::vector<int>(polygon.size(), 0)};
    out.contours.push_back((polygon_area(polygon) > 0) == out.contours.empty() ? contour : reversed(contour));
  }
  return out;
}

/// That the triangles are counter-clockwise, have the area of the outline to 1e-13, and close its extrusion: nothing is
/// missing, nothing lies on something else.
void expect_filled(const Outline& outline) {
  std::vector<Vec3> corner;
  double area = 0, filled = 0;
  for (const Contour& contour : outline.contours) {
    corner.insert(corner.end(), contour.corner.begin(), contour.corner.end());
    area += polygon_area(contour.corner);
  }
  const auto triangles = triangulate(outline);
  EXPECT_EQ(triangles.size(), corner.size() + 2 * outline.contours.size() - 4);  // Euler
  for (const auto& [a, b, c] : triangles) {
    const double twice = orientation(corner[a], corner[b], corner[c]);
    EXPECT_GT(twice, 0);
    filled += twice / 2;
  }
  EXPECT_NEAR(filled, area, 1e-13 * area);
  const Surface surface = extruded(outline, 2);
  require_closed(surface, {.file = "outline"});
  EXPECT_NEAR(enclosed_volume(surface), 2 * area, 1e-13 * area);
}

TEST(Triangulation, FillsRandomPolygonsWithHoles) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    const auto corners = [&](int least, int most) { return std::uniform_int_distribution<int>(least, most)(random); };
    std::vector<std::vector<Vec3>> polygons = {star(random, {}, 0.6, 2, corners(12, 60))};
    // Holes around the centre, and in it.
    const int holes = corners(0, 8);
    for (int n = 0; n < holes; ++n) {
      const double angle = 2 * pi * n / 8;
      polygons.push_back(star(random, {0.35 * std::cos(angle), 0.35 * std::sin(angle), 0}, 0.02, 0.12, corners(5, 20)));
    }
    if (corners(0, 1)) polygons.push_back(star(random, {}, 0.02, 0.2, corners(5, 20)));
    SCOPED_TRACE(seed);
    expect_filled(outline_of(polygons));
  }
}

TEST(Triangulation, FillsCombsSpiralsAndCornersInLine) {
  std::vector<Vec3> comb = {{0, 0, 0}, {20, 0, 0}};
  for (int n = 19; n >= 0; --n) comb.insert(comb.end(), {{n + 0.9, 5, 0}, {n + 0.5, 1, 0}, {n + 0.1, 5, 0}});
  expect_filled(outline_of({comb}));

  std::vector<Vec3> spiral, back;
  for (int n = 0; n < 60; ++n) {
    spiral.push_back((1 + 0.05 * n) * Vec3{std::cos(0.3 * n), std::sin(0.3 * n), 0});
    back.push_back((1.5 + 0.05 * n) * Vec3{std::cos(0.3 * n), std::sin(0.3 * n), 0});
  }
  spiral.insert(spiral.end(), back.rbegin(), back.rend());
  expect_filled(outline_of({spiral}));

  std::vector<Vec3> square;  // with ten corners on each side
  for (const Vec3& turn : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{-1, 0, 0}, Vec3{0, -1, 0}})
    for (int n = -5; n < 5; ++n) square.push_back(5.0 * Vec3{turn.y, -turn.x, 0} + n * turn);
  expect_filled(outline_of({square}));
}

TEST(Triangulation, FillsAPlateWithAGridOfHoles) {
  std::vector<std::vector<Vec3>> polygons = {{{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}}};
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) {
      const Vec3 low{i + 0.25, j + 0.25, 0};
      polygons.push_back({low, low + Vec3{0.5, 0, 0}, low + Vec3{0.5, 0.5, 0}, low + Vec3{0, 0.5, 0}});
    }
  expect_filled(outline_of(polygons));
  for (std::vector<Vec3>& polygon : polygons)  // the same out of line with the axes
    for (Vec3& x : polygon) x = {0.8 * x.x - 0.6 * x.y, 0.6 * x.x + 0.8 * x.y, 0};
  expect_filled(outline_of(polygons));
}

}  // namespace
}  // namespace calor
