// Surfaces cut by each other: volumes add up, and what comes out is closed, also where walls lie in one plane.
#include <gtest/gtest.h>

#include <random>

#include "base/error.hpp"
#include "surface/combine.hpp"
#include "surface/outline.hpp"
#include "surfaces.hpp"

namespace calor {
namespace {

Surface moved(Surface s, const Vec3& way, double scale = 1) {
  for (Vec3& x : s.vertices) x = scale * x + way;
  return s;
}

Surface walls_of(const Assembly& assembly) {
  Surface walls = assembly.surface;
  walls.facets.resize(assembly.walls);
  return walls;
}

double area_of_interfaces(const Assembly& assembly) {
  double sum = 0;
  for (int f = assembly.walls; f < static_cast<int>(assembly.surface.facets.size()); ++f)
    sum += norm(assembly.surface.area(f));
  return sum;
}

void expect_volumes_add_up(const Surface& a, const Surface& b) {
  const Surface rest = difference(a, b), both = intersection(a, b), other = difference(b, a);
  for (const Surface* s : {&rest, &both, &other}) {
    if (s->facets.empty()) continue;
    EXPECT_NO_THROW(require_closed(*s, {}));
  }
  const double size = enclosed_volume(a) + enclosed_volume(b);
  EXPECT_NEAR(enclosed_volume(rest) + enclosed_volume(both), enclosed_volume(a), 1e-9 * size);
  EXPECT_NEAR(enclosed_volume(other) + enclosed_volume(both), enclosed_volume(b), 1e-9 * size);
  const Assembly assembly = assemble({rest, b});
  EXPECT_NO_THROW(require_closed(walls_of(assembly), {}));
  EXPECT_NEAR(enclosed_volume(walls_of(assembly)), enclosed_volume(rest) + enclosed_volume(b), 1e-9 * size);
}

TEST(Combine, VolumesOfBodiesAtRandomPlacesAddUp) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> along(-0.6, 0.6), larger(0.4, 1.2);
  const Surface tube =
      revolved({.contours = {{.corner = {{0.3, 0, 0}, {0.6, 0, 0}, {0.6, 1, 0}, {0.3, 1, 0}}, .face = {0, 1, 2, 3}}},
                .faces = {"bottom", "outer", "top", "inner"}},
               full_turn, 0.2);
  const std::vector<Surface> bodies = {unit_cube(), sphere(5), tube, tetrahedron()};
  for (int n = 0; n < 40; ++n) {
    const Vec3 way{along(random), along(random), along(random)};
    const auto& a = bodies[n % bodies.size()];
    const auto& b = bodies[n / bodies.size() % bodies.size()];
    expect_volumes_add_up(a, moved(b, way, larger(random)));
  }
}

TEST(Combine, AreasInThePlaneAddUp) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(-1, 1), larger(0.4, 1.2);
  for (int n = 0; n < 30; ++n)
    expect_volumes_add_up(polygon(3 + n), moved(polygon(40 - n), {along(random), along(random), 0}, larger(random)));
}

/// A cube of 0.5 at places where its walls lie on those of the unit cube, cross them, or touch them from outside.
TEST(Combine, WallsInOnePlaneAreCutCleanly) {
  for (const double x : {-0.5, -0.25, 0.0, 0.25, 0.5, 1.0})
    for (const double y : {-0.25, 0.0, 0.3, 0.5})
      for (const double z : {0.0, 0.5, 1.0}) {
        const Surface cube = moved(unit_cube(), {x, y, z}, 0.5);
        const auto shared = [](double low) { return std::max(0.0, std::min(1.0, low + 0.5) - std::max(0.0, low)); };
        EXPECT_NEAR(enclosed_volume(intersection(unit_cube(), cube)), shared(x) * shared(y) * shared(z), 1e-12);
        const bool touches_in_an_edge = (x == -0.5 || x == 1) && z == 1;
        if (!touches_in_an_edge) expect_volumes_add_up(unit_cube(), cube);
      }
}

TEST(Combine, WhatLiesInsideIsACavityAndWhatLiesOutsideChangesNothing) {
  const Surface ball = moved(sphere(4), {0.5, 0.5, 0.5}, 0.3);
  EXPECT_NEAR(enclosed_volume(difference(unit_cube(), ball)), 1 - enclosed_volume(ball), 1e-12);
  EXPECT_EQ(difference(unit_cube(), moved(ball, {3, 0, 0})).facets.size(), unit_cube().facets.size());
  EXPECT_TRUE(difference(ball, unit_cube()).facets.empty());
  EXPECT_TRUE(intersection(ball, moved(ball, {3, 0, 0})).facets.empty());
}

TEST(Combine, SolidsThatTouchHaveOneInterface) {
  const Surface post = moved(unit_cube(), {0.25, 0.3, 1}, 0.5);
  const Assembly assembly = assemble({unit_cube(), post});
  EXPECT_NEAR(area_of_interfaces(assembly), 0.25, 1e-12);
  EXPECT_NO_THROW(require_closed(walls_of(assembly), {}));
  EXPECT_NEAR(enclosed_volume(walls_of(assembly)), 1.125, 1e-12);
  EXPECT_EQ(assembly.surface.faces[assembly.surface.facets.back().face], "zmin");

  const Surface core = moved(sphere(4), {0.5, 0.5, 0.5}, 0.3);
  double area = 0;
  for (int f = 0; f < static_cast<int>(core.facets.size()); ++f) area += norm(core.area(f));
  EXPECT_NEAR(area_of_interfaces(assemble({difference(unit_cube(), core), core})), area, 1e-12);
}

}  // namespace
}  // namespace calor
