#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "base/error.hpp"
#include "errors.hpp"
#include "surface/surface.hpp"
#include "surface/surface_tree.hpp"
#include "surfaces.hpp"

namespace calor {
namespace {

using std::numbers::pi;

Surface joined(Surface a, const Surface& b) {
  const auto first = static_cast<std::int32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (Surface::Triangle facet : b.facets) {
    for (int k = 0; k < a.dimension; ++k) facet.vertex[k] += first;
    a.facets.push_back(facet);
  }
  return a;
}

Surface turned(Surface s) {
  for (auto& facet : s.facets) std::swap(facet.vertex[0], facet.vertex[s.dimension - 1]);
  return s;
}

Surface moved(Surface s, double factor, const Vec3& by) {
  for (Vec3& x : s.vertices) x = factor * x + by;
  return s;
}

/// As a file of loose facets gives it: every facet has vertices of its own, all off by up to `noise`.
Surface soup_of(const Surface& s, double noise) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-noise, noise);
  Surface out;
  out.dimension = s.dimension;
  out.faces = s.faces;
  for (Surface::Triangle facet : s.facets) {
    for (int k = 0; k < s.dimension; ++k) {
      Vec3 x = s.vertices[facet.vertex[k]];
      for (int a = 0; a < s.dimension; ++a) x[a] += off(random);
      out.vertices.push_back(x);
      facet.vertex[k] = static_cast<std::int32_t>(out.vertices.size()) - 1;
    }
    out.facets.push_back(facet);
  }
  return out;
}

const SourceLocation here{.file = "part.stl", .line = 0, .column = 0};

TEST(Surface, EnclosesTheVolumeOfItsBody) {
  EXPECT_NEAR(enclosed_volume(unit_cube()), 1, 1e-15);
  EXPECT_NEAR(enclosed_volume(moved(unit_cube(), 2, {1e6, 0, -1e6})), 8, 1e-8);
  EXPECT_NEAR(enclosed_volume(turned(unit_cube())), -1, 1e-15);
  EXPECT_NEAR(enclosed_volume(tetrahedron()), 1.0 / 6, 1e-16);
  EXPECT_NEAR(enclosed_volume(polygon(4)), 2, 1e-15);  // a square of half diagonal 1
  EXPECT_EQ(enclosed_volume(Surface{}), 0);
}

TEST(Surface, OfASphereApproachesItsVolumeWithTheSecondOrder) {
  const auto error = [](int n) { return 4 * pi / 3 - enclosed_volume(sphere(n)); };
  EXPECT_NEAR(std::log2(error(16) / error(32)), 2, 0.01);
  EXPECT_NEAR(error(32), 0, 0.01);
}

TEST(Surface, HasAreasThatPointOutwardsAndAddUpToNothing) {
  for (const Surface& s : {unit_cube(), sphere(5), polygon(7)}) {
    Vec3 sum;
    for (int f = 0; f < static_cast<int>(s.facets.size()); ++f) sum += s.area(f);
    EXPECT_LT(norm(sum), 1e-14);
  }
  EXPECT_GT(dot(polygon(7).area(2), polygon(7).centroid(2)), 0);
  EXPECT_GT(dot(sphere(3).area(2), sphere(3).centroid(2)), 0);
}

TEST(Weld, MakesASoupOfFacetsOneSurfaceAgain) {
  for (const Surface& s : {unit_cube(), sphere(12), polygon(40)}) {
    Surface soup = soup_of(s, 1e-7);
    const auto loose = static_cast<int>(soup.vertices.size());
    EXPECT_EQ(weld(soup, 1e-6), loose - static_cast<int>(s.vertices.size()));
    EXPECT_EQ(soup.facets.size(), s.facets.size());
    EXPECT_NO_THROW(require_closed(soup, here));
  }
}

TEST(Weld, FindsNeighboursInOtherCellsOfItsGrid) {
  for (int n = 0; n < 200; ++n) {  // two vertices on either side of every kind of border
    const double x = 8e-6 * (n - 100);
    Surface s;
    s.vertices = {{x - 4e-7, 0, 0}, {1, 0, 0}, {0, 1, 0}, {x + 4e-7, -1e-9, 0}, {1, 0, 1e-9}, {0, 0, 1}};
    s.facets = {{{0, 1, 2}, 0}, {{3, 4, 5}, 0}};
    EXPECT_EQ(weld(s, 1e-6), 2);
  }
}

TEST(Weld, UnitesOnlyEqualVerticesWithoutATolerance) {
  Surface soup = soup_of(unit_cube(), 0);
  EXPECT_EQ(weld(soup, 0), 36 - 8);
  soup = soup_of(unit_cube(), 1e-7);
  EXPECT_EQ(weld(soup, 0), 0);
}

TEST(Weld, LeavesOutFacetsWithoutAreaAndVerticesWithoutFacet) {
  Surface s = unit_cube();
  s.vertices.push_back({5, 5, 5});
  s.vertices.push_back(s.vertices[0] + Vec3{1e-9, 0, 0});
  s.facets.push_back({{0, 9, 1}, 0});
  EXPECT_EQ(weld(s, 1e-6), 2);
  EXPECT_EQ(s.facets.size(), 12u);
  EXPECT_EQ(s.vertices.size(), 8u);
}

TEST(RequireClosed, TellsOpenEdgesByNumberAndPlace) {
  Surface s = unit_cube();
  EXPECT_NO_THROW(require_closed(s, here));
  s.facets.pop_back();
  expect_error([&] { require_closed(s, here); },
               {"part.stl: the surface is not closed: 3 edges with one facet only, at (", "weld"});
  Surface line = polygon(5);
  EXPECT_NO_THROW(require_closed(line, here));
  line.facets.erase(line.facets.begin());
  expect_error([&] { require_closed(line, here); }, {"2 corners with one facet only, at (1, 0) m, ("});
  expect_error([&] { require_closed(Surface{}, here); }, {"no facets"});
}

TEST(RequireClosed, NamesFacetsThatComeTwiceAsTheReason) {
  Surface s = unit_cube();
  s.facets.insert(s.facets.end(), s.facets.begin(), s.facets.begin() + 4);
  expect_error([&] { require_closed(s, here); }, {"edges with more than two facets", "4 facets come twice", "remove"});
}

TEST(RequireClosed, TellsEdgesThatShellsShare) {
  Surface s = joined(unit_cube(), moved(unit_cube(), 1, {1, 1, 0}));
  weld(s, 1e-6);
  const Error e = error_of([&] { require_closed(s, here); });
  expect_words(e.what(), {"1 edge with more than two facets, at (1, 1, 0.5) m", "apart"});
  EXPECT_EQ(std::string(e.what()).find("twice"), std::string::npos);
}

TEST(RequireClosed, TellsFacetsThatFaceToTheWrongSide) {
  Surface s = unit_cube();
  std::swap(s.facets[3].vertex[0], s.facets[3].vertex[1]);
  expect_error([&] { require_closed(s, here); }, {"3 edges between facets that face to different sides"});
  EXPECT_EQ(orient(s), 1);
  EXPECT_NO_THROW(require_closed(s, here));
  EXPECT_NEAR(enclosed_volume(s), 1, 1e-15);
}

TEST(Orient, TurnsShellsOutwardsAndCavitiesInwards) {
  for (const Surface& s : {sphere(6), polygon(12)}) {
    const double volume = enclosed_volume(s);
    const int power = s.dimension;
    const auto shell = [&](double size, bool inwards) {
      const Surface one = moved(s, size, {0.1, -0.2, 0});
      return inwards ? turned(one) : one;
    };
    // A body, a cavity in it, a body in that, and one beside them.
    const double exact = volume * (1 - std::pow(0.6, power) + std::pow(0.3, power) + std::pow(0.5, power));
    for (int inside_out = 0; inside_out < 16; ++inside_out) {
      Surface all = shell(1, inside_out & 1);
      all = joined(all, shell(0.6, inside_out & 2));
      all = joined(all, shell(0.3, inside_out & 4));
      const Surface beside = moved(s, 0.5, {5, 0, 0});
      all = joined(all, inside_out & 8 ? turned(beside) : beside);
      const int wrong = (inside_out & 1) + !(inside_out & 2) + (inside_out >> 2 & 1) + (inside_out >> 3 & 1);
      EXPECT_EQ(orient(all), wrong) << inside_out;
      EXPECT_NEAR(enclosed_volume(all), exact, 1e-13) << inside_out;
      EXPECT_EQ(orient(all), 0);
      const SurfaceTree tree(all);
      EXPECT_TRUE(tree.is_inside({0.1, -0.2, 0}));
      EXPECT_FALSE(tree.is_inside({0.1, 0.2, 0}));
      EXPECT_TRUE(tree.is_inside({0.1, 0.6, 0}));
    }
  }
}

TEST(Orient, TakesShellsThatTouchForNeighbours) {
  Surface s = joined(unit_cube(), turned(moved(unit_cube(), 1, {1, 0, 0})));
  EXPECT_EQ(orient(s), 1);
  EXPECT_NEAR(enclosed_volume(s), 2, 1e-14);
}

std::size_t faces_by_angle(Surface s) {
  name_faces_by_angle(s, pi / 6);
  return s.faces.size();
}

TEST(FacesByAngle, EndAtEdgesThatAreSharperThanTheAngle) {
  Surface cube = unit_cube();
  name_faces_by_angle(cube, pi / 6);
  EXPECT_EQ(cube.faces, (std::vector<std::string>{"face1", "face2", "face3", "face4", "face5", "face6"}));
  for (int f = 0; f < 12; ++f) EXPECT_EQ(cube.facets[f].face, f / 2);
  EXPECT_EQ(faces_by_angle(sphere(8)), 1u);
  EXPECT_EQ(faces_by_angle(polygon(13)), 1u);   // turns by 27.7 degrees
  EXPECT_EQ(faces_by_angle(polygon(11)), 11u);  // by 32.7
}

TEST(FacesByAngle, AreNumberedFromTheLargest) {
  Surface s = unit_cube();
  for (Vec3& x : s.vertices) x = {3 * x.x, 2 * x.y, x.z};
  name_faces_by_angle(s, pi / 6);
  for (int wall = 0; wall < 6; ++wall) EXPECT_EQ(s.facets[2 * wall].face, (std::array{4, 5, 2, 3, 0, 1})[wall]);
}

TEST(FacesByAngle, GoOnAcrossFacetsTooThinForANormal) {
  Surface s = unit_cube();
  // A vertex a hair off the diagonal of the first wall makes a thin facet of a normal along that wall.
  const auto [a, b, c] = s.facets[0].vertex;
  Vec3 middle = 0.5 * (s.vertices[b] + s.vertices[c]);
  for (int k = 0; k < 3; ++k)  // the diagonal is the longest edge
    if (const auto& v = s.facets[0].vertex; norm(s.vertices[v[k]] - s.vertices[v[(k + 1) % 3]]) > 1.2) {
      middle = 0.5 * (s.vertices[v[k]] + s.vertices[v[(k + 1) % 3]]) + Vec3{1e-8, 1e-8, 1e-8};
      const auto added = static_cast<std::int32_t>(s.vertices.size());
      s.vertices.push_back(middle);
      const std::int32_t from = v[k], to = v[(k + 1) % 3], tip = v[(k + 2) % 3];
      s.facets[0] = {{from, added, tip}, 0};
      s.facets.push_back({{added, to, tip}, 0});
      s.facets.push_back({{from, to, added}, 0});
      break;
    }
  ASSERT_NO_THROW(require_closed(s, here));
  name_faces_by_angle(s, pi / 6);
  EXPECT_EQ(s.faces.size(), 6u);
  EXPECT_EQ(s.facets[12].face, s.facets[0].face);
  EXPECT_EQ(s.facets[13].face, s.facets[0].face);
}

}  // namespace
}  // namespace calor
