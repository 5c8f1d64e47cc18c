#include "surface/surface_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "surface/facet_queries.hpp"
#include "surfaces.hpp"

namespace calor {
namespace {

using std::numbers::pi;

/// Facets strewn about the unit cube (square): thin ones and ones without area among them.
Surface strewn(int dimension, int count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0, 1), length(-0.1, 0.1);
  Surface s;
  s.dimension = dimension;
  for (int n = 0; n < count; ++n) {
    const Vec3 x{place(random), place(random), dimension == 3 ? place(random) : 0};
    Surface::Triangle facet;
    for (int k = 0; k < dimension; ++k) {
      Vec3 corner = x + Vec3{length(random), length(random), dimension == 3 ? length(random) : 0};
      if (dimension == 3 && k == 2 && n % 7 == 0) {  // almost or wholly on the line of the others
        const Vec3 &a = s.vertices[s.vertices.size() - 2], &b = s.vertices.back();
        corner = 0.3 * a + 0.7 * b + (n % 2 == 0 ? 0 : 1e-9) * corner;
      }
      s.vertices.push_back(corner);
      facet.vertex[k] = static_cast<std::int32_t>(s.vertices.size()) - 1;
    }
    s.facets.push_back(facet);
  }
  return s;
}

Corners corners(const Surface& s, int f) {
  const auto& v = s.facets[f].vertex;
  return {s.vertices[v[0]], s.vertices[v[1]], s.vertices[v[s.dimension == 2 ? 1 : 2]]};
}

std::vector<Vec3> places(int dimension, int count, double low, double high, int seed = 3) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(low, high);
  std::vector<Vec3> x(count);
  for (Vec3& p : x) p = {place(random), place(random), dimension == 3 ? place(random) : 0};
  return x;
}

TEST(WindingNumber, IsOneInsideAndNoneOutside) {
  const Surface s = unit_cube();
  const SurfaceTree tree(s);
  for (const Vec3& x : places(3, 2000, -0.5, 1.5)) {
    const bool inside = x.x > 0 && x.x < 1 && x.y > 0 && x.y < 1 && x.z > 0 && x.z < 1;
    EXPECT_NEAR(tree.winding_number(x), inside, 1e-2);
    EXPECT_EQ(tree.is_inside(x), inside);
  }
  const Surface square = polygon(4);
  const SurfaceTree plane(square);
  for (const Vec3& x : places(2, 2000, -1.5, 1.5)) {
    const bool inside = std::abs(x.x) + std::abs(x.y) < 1;
    EXPECT_NEAR(plane.winding_number(x), inside, 1e-2);
    EXPECT_EQ(plane.is_inside(x), inside);
  }
}

TEST(WindingNumber, IsRightCloseToFacets) {
  const Surface ball = sphere(20), circle = polygon(200);
  for (const Surface* s : {&ball, &circle}) {
    const SurfaceTree tree(*s);
    for (int f = 0; f < static_cast<int>(s->facets.size()); ++f) {
      const Vec3 n = (1 / norm(s->area(f))) * s->area(f), x = s->centroid(f);
      EXPECT_NEAR(tree.winding_number(x - 1e-10 * n), 1, 5e-2);
      EXPECT_NEAR(tree.winding_number(x + 1e-10 * n), 0, 5e-2);
    }
    for (const Vec3& x : s->vertices) {
      EXPECT_TRUE(tree.is_inside((1 - 1e-10) * x));
      EXPECT_FALSE(tree.is_inside((1 + 1e-10) * x));
    }
  }
}

TEST(WindingNumber, IsThatOfTheSumOverAllFacetsOfASurfaceWithHoles) {
  for (Surface s : {sphere(12), polygon(300)}) {
    for (Vec3& x : s.vertices) x *= 1 + 0.3 * std::sin(5 * x.x) * std::sin(4 * x.y);
    std::erase_if(s.facets, [&](const Surface::Triangle& f) { return std::sin(7 * s.vertices[f.vertex[0]].x) > 0.8; });
    const SurfaceTree tree(s);
    for (const Vec3& x : places(s.dimension, 1000, -1.5, 1.5)) {
      double sum = 0;
      for (int f = 0; f < static_cast<int>(s.facets.size()); ++f)
        sum += s.dimension == 2 ? angle(corners(s, f), x) / (2 * pi) : solid_angle(corners(s, f), x) / (4 * pi);
      EXPECT_NEAR(tree.winding_number(x), sum, 0.1);  // dipoles from 2.6 radii
    }
  }
}

/// The closest place by a fine net of the facet: an upper bound, near the truth.
double distance_by_net(const Corners& c, const Vec3& x) {
  constexpr int n = 60;
  double least = 1e300;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j)
      least = std::min(least, norm((1.0 / n) * ((n - i - j) * c[0] + double(i) * c[1] + double(j) * c[2]) - x));
  return least;
}

TEST(ClosestPlace, OfATriangleIsThatOfAFineNet) {
  const Surface s = strewn(3, 40);
  for (int f = 0; f < 40; ++f)
    for (const Vec3& off : places(3, 40, -0.2, 0.2, f)) {
      const Vec3 x = s.centroid(f) + off;
      const Corners c = corners(s, f);
      const Vec3 p = closest_on_triangle(c, x);
      const double net = distance_by_net(c, x), side = 0.4;
      EXPECT_LE(norm(p - x), net + 1e-12);
      EXPECT_GE(norm(p - x), net - side / 60);
      EXPECT_LT(distance_by_net(c, p), side / 60);  // it is on the triangle
    }
}

TEST(ClosestPlace, IsThatOfAllFacets) {
  for (const Surface& s : {strewn(3, 500), strewn(2, 500)}) {
    const SurfaceTree tree(s);
    for (const Vec3& x : places(s.dimension, 1000, -0.5, 1.5)) {
      double least = 1e300;
      for (int f = 0; f < 500; ++f) {
        const Corners c = corners(s, f);
        least = std::min(least,
                         norm((s.dimension == 2 ? closest_on_segment(c[0], c[1], x) : closest_on_triangle(c, x)) - x));
      }
      const auto found = tree.closest(x, std::numeric_limits<double>::infinity());
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->distance, least, 1e-15);
      EXPECT_NEAR(norm(found->x - x), least, 1e-15);
      EXPECT_NEAR(distance_by_net(corners(s, found->facet), found->x), 0, 1e-2);
      EXPECT_TRUE(tree.closest(x, least * (1 + 1e-12) + 1e-300));
      EXPECT_FALSE(tree.closest(x, least * (1 - 1e-12)));
    }
  }
}

TEST(Crossings, AreThoseOfAllFacets) {
  for (const Surface& s : {strewn(3, 500), strewn(2, 500)}) {
    const SurfaceTree tree(s);
    const auto from = places(s.dimension, 3000, -0.2, 1.2, 1), to = places(s.dimension, 3000, -0.2, 1.2, 2);
    int crossed = 0;
    for (int n = 0; n < 3000; ++n) {
      const Vec3 end = n % 2 == 0 ? to[n] : 0.9 * from[n] + 0.1 * to[n];
      bool any = false;
      for (int f = 0; f < 500 && !any; ++f) {
        const Corners c = corners(s, f);
        any = s.dimension == 2 ? segment_crossed(c[0], c[1], from[n], end) : triangle_crossed(c, from[n], end);
      }
      EXPECT_EQ(tree.is_crossed(from[n], end), any);
      crossed += any;
    }
    EXPECT_GT(crossed, 300);
    EXPECT_LT(crossed, 2700);
  }
}

TEST(Crossings, LieWhereTheFacetsAre) {
  const Surface cube = unit_cube();
  const SurfaceTree tree(cube);
  std::vector<double> at = tree.crossings({-1, 0.3, 0.2}, {3, 0.3, 0.2});
  std::ranges::sort(at);
  ASSERT_EQ(at.size(), 2u);
  EXPECT_NEAR(at[0], 0.25, 1e-15);
  EXPECT_NEAR(at[1], 0.5, 1e-15);
  EXPECT_TRUE(tree.crossings({0.1, 0.3, 0.2}, {0.9, 0.3, 0.2}).empty());
  const Surface circle = polygon(4);  // a square of corners (1, 0), (0, 1) ...
  at = SurfaceTree(circle).crossings({0, 0.25, 0}, {1, 0.25, 0});
  ASSERT_EQ(at.size(), 1u);
  EXPECT_NEAR(at[0], 0.75, 1e-15);
}

TEST(Crossings, LetNothingThroughEdgesAndCorners) {
  const Surface ball = sphere(7), circle = polygon(9);
  for (const Surface* s : {&ball, &circle}) {
    const SurfaceTree tree(*s);
    std::vector<Vec3> aims = s->vertices;  // corners, middles of edges, centroids
    for (int f = 0; f < static_cast<int>(s->facets.size()); ++f) {
      aims.push_back(0.5 * (s->vertices[s->facets[f].vertex[0]] + s->vertices[s->facets[f].vertex[1]]));
      aims.push_back(s->centroid(f));
    }
    for (const Vec3& x : aims) {
      for (const Vec3& inside : places(s->dimension, 10, -0.3, 0.3)) {
        EXPECT_TRUE(tree.is_crossed(inside, inside + 2 * (x - inside)));
        EXPECT_FALSE(tree.is_crossed(inside, inside + 0.99 * (x - inside)));
      }
      EXPECT_FALSE(tree.is_crossed(1.01 * x, 3 * x));
    }
  }
}

TEST(Crossings, AreSeenAlongAxesAndInThePlanesOfBoxes) {
  const Surface s = unit_cube();
  const SurfaceTree tree(s);
  EXPECT_TRUE(tree.is_crossed({0.5, 0.5, 0.5}, {0.5, 0.5, 1.5}));
  EXPECT_TRUE(tree.is_crossed({0.5, 0.5, -0.5}, {0.5, 0.5, 0.5}));
  EXPECT_TRUE(tree.is_crossed({-1, 0, 0.5}, {0.5, 0.5, 0.5}));
  EXPECT_FALSE(tree.is_crossed({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8}));
  EXPECT_FALSE(tree.is_crossed({-1, 1.1, 0.5}, {2, 1.1, 0.5}));
  EXPECT_FALSE(tree.is_crossed({0, 0.5, 0.5}, {0.5, 0.5, 0.5}));  // begins on a facet
}

TEST(Boxes, TouchWhereABoxOfAFacetIs) {
  for (const Surface& s : {strewn(3, 300), strewn(2, 300)}) {
    const SurfaceTree tree(s);
    int touched = 0;
    for (const Vec3& x : places(s.dimension, 1000, -0.2, 1.2)) {
      const double h = s.dimension == 2 ? 0.01 : 0.03;
      const Vec3 low = x - Vec3{h, h, s.dimension == 2 ? 0 : h}, high = x + Vec3{h, 2 * h, s.dimension == 2 ? 0 : h};
      bool any = false;
      for (int f = 0; f < 300; ++f) {
        bool overlaps = true;
        for (int a = 0; a < 3; ++a) {
          const Corners c = corners(s, f);
          overlaps = overlaps && std::min({c[0][a], c[1][a], c[2][a]}) <= high[a] &&
                     std::max({c[0][a], c[1][a], c[2][a]}) >= low[a];
        }
        any = any || overlaps;
      }
      EXPECT_EQ(tree.touches(low, high), any);
      touched += any;
    }
    EXPECT_GT(touched, 100);
    EXPECT_LT(touched, 950);
  }
}

TEST(SurfaceTree, BearsFacetsInOnePlace) {
  Surface s;
  s.vertices = {{1, 1, 1}, {2, 1, 1}, {1, 2, 1}};
  for (int n = 0; n < 1000; ++n) s.facets.push_back({{0, 1, 2}, 0});
  const SurfaceTree tree(s);
  EXPECT_NEAR(tree.closest({1.1, 1.1, 3}, 5)->distance, 2, 1e-15);
  EXPECT_TRUE(tree.is_crossed({1.1, 1.1, 3}, {1.1, 1.1, 0}));
  EXPECT_TRUE(std::isfinite(tree.winding_number({1, 1, 1})));
  const Surface nothing;
  const SurfaceTree none(nothing);
  EXPECT_EQ(none.winding_number({0, 0, 0}), 0);
  EXPECT_FALSE(none.closest({0, 0, 0}, 1));
  EXPECT_FALSE(none.is_crossed({0, 0, 0}, {1, 1, 1}));
}

}  // namespace
}  // namespace calor
