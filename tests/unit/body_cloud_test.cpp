#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "case_models.hpp"
#include "cloud/body_points.hpp"
#include "cloud/shapes.hpp"
#include "method_clouds.hpp"
#include "surface/combine.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

/// A closed curve of straight pieces around each list of corners; holes run clockwise.
Surface outline(const std::vector<std::vector<Vec3>>& loops) {
  Surface s{.dimension = 2, .vertices = {}, .facets = {}, .faces = {"side"}};
  for (const auto& loop : loops) {
    const int first = static_cast<int>(s.vertices.size()), n = static_cast<int>(loop.size());
    s.vertices.insert(s.vertices.end(), loop.begin(), loop.end());
    for (int k = 0; k < n; ++k) s.facets.push_back({{first + k, first + (k + 1) % n, -1}, 0});
  }
  return s;
}

std::vector<Vec3> circle(double radius, int pieces, int turn = 1) {
  std::vector<Vec3> x;
  for (int k = 0; k < pieces; ++k) {
    const double a = turn * 2 * pi * k / pieces;
    x.push_back({radius * std::cos(a), radius * std::sin(a), 0});
  }
  return x;
}

const std::vector<Vec3> ell = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};

/// The prism over an outline without holes that is star-shaped about its first corner.
Surface prism(const std::vector<Vec3>& base, double height) {
  Surface s{.dimension = 3, .vertices = {}, .facets = {}, .faces = {"side", "bottom", "top"}};
  const int n = static_cast<int>(base.size());
  for (const double z : {0.0, height})
    for (const Vec3& x : base) s.vertices.push_back({x.x, x.y, z});
  for (int k = 0; k < n; ++k) {
    const int l = (k + 1) % n;
    s.facets.push_back({{k, l, n + l}, 0});
    s.facets.push_back({{k, n + l, n + k}, 0});
  }
  for (int k = 1; k + 1 < n; ++k) {
    s.facets.push_back({{0, k + 1, k}, 1});
    s.facets.push_back({{n, n + k, n + k + 1}, 2});
  }
  return s;
}

/// A ball whose facets have edges of about radius pi / 2 / parts: an octahedron, each face cut into parts^2.
Surface ball(double radius, int parts) {
  Surface s{.dimension = 3, .vertices = {}, .facets = {}, .faces = {"side"}};
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 sign{octant & 1 ? -1. : 1., octant & 2 ? -1. : 1., octant & 4 ? -1. : 1.};
    const bool is_mirrored = sign.x * sign.y * sign.z < 0;
    const int first = static_cast<int>(s.vertices.size());
    const auto at = [&](int i, int j) { return first + i * (parts + 1) - i * (i - 1) / 2 + j; };
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; i + j <= parts; ++j) {
        const Vec3 x = product(sign, {double(i), double(j), double(parts - i - j)});
        s.vertices.push_back((radius / norm(x)) * x);
      }
    const auto add = [&](int a, int b, int c) {
      s.facets.push_back({is_mirrored ? std::array{a, c, b} : std::array{a, b, c}, 0});
    };
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < parts) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
  weld(s, 1e-9 * radius);
  return s;
}

SpacingField uniform(double d) {
  return {.at = [d](const Vec3&) { return d; }, .is_uniform = true};
}

struct Named {
  std::string name;
  Surface surface;
  double spacing;
};

std::vector<Named> bodies() {
  return {{"L", outline({ell}), 0.1},
          {"L, off the lattice", outline({ell}), 0.093},
          {"disc", outline({circle(1, 400)}), 0.1},
          {"ring", outline({circle(1, 400), circle(0.4, 300, -1)}), 0.07},
          {"box", prism({{0, 0, 0}, {1, 0, 0}, {1, 0.7, 0}, {0, 0.7, 0}}, 0.5), 0.1},
          {"prism of an L", prism(ell, 0.5), 0.15},
          {"cylinder", prism(circle(1, 100), 1), 0.2},
          {"ball", ball(1, 20), 0.2}};
}

TEST(BodyCloud, HasClosedAreasAndTheVolumeOfTheBody) {
  for (const Named& body : bodies()) {
    const double volume = enclosed_volume(body.surface);
    const Cloud cloud =
        distribute(MPI_COMM_SELF, make_body(MPI_COMM_SELF, assemble({body.surface}), uniform(body.spacing), 1, 1),
                   3 * body.spacing);
    const CloudCheck is = check(cloud);
    EXPECT_NEAR(is.volume / volume, 1, 1e-12) << body.name;
    EXPECT_LE(is.area_sum, 1e-14) << body.name;
    EXPECT_LE(is.moment_sum, 1e-14) << body.name;
    double area = 0, least = 1e300, most = 0;
    for (const Facet& facet : cloud.facets) area += facet.area;
    double surface = 0;
    for (int f = 0; f < static_cast<int>(body.surface.facets.size()); ++f) surface += norm(body.surface.area(f));
    EXPECT_NEAR(area / surface, 1, 1e-12) << body.name;
    for (int i = 0; i < cloud.owned; ++i) {
      const double v = cloud.volume[i] / cloud.full_volume[i];
      least = std::min(least, v), most = std::max(most, v);
    }
    EXPECT_GT(least, 0.05) << body.name;
    EXPECT_LT(most, 2.5) << body.name;
  }
}

TEST(BodyCloud, HasWeightsThatReproduceLinearFields) {
  for (const Named& body : bodies()) {
    const Cloud cloud =
        distribute(MPI_COMM_SELF, make_body(MPI_COMM_SELF, assemble({body.surface}), uniform(body.spacing), 1, 1),
                   3 * body.spacing);
    const Weights w = sph_weights(cloud, 1.2);
    EXPECT_LE(w.report.residual, 1e-11) << body.name;
    EXPECT_EQ(w.report.negative, 0) << body.name;
  }
}

TEST(BodyCloud, HasPointsOnTheEdgesOfBothWallsOfASlotFarNarrowerThanTheSpacing) {
  // The top and the bottom of the plate are patches that lie on both sides of the slot.
  const Surface plate = prism({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, 1);
  for (const double width : {0.04, 0.002}) {
    Surface kerf = prism({{0.9, -0.1, 0}, {0.9 + width, -0.1, 0}, {0.9 + width, 1.1, 0}, {0.9, 1.1, 0}}, 2);
    for (Vec3& x : kerf.vertices) x.z -= 0.5;
    const Points points = make_body(MPI_COMM_SELF, assemble({difference(plate, kerf)}), uniform(0.2), 1, 1);
    const auto on_edge = [&](double x, double z) {
      return std::ranges::count_if(points.points, [&](const Point& p) {
        return std::abs(p.x.x - x) < 1e-9 && std::abs(p.x.z - z) < 1e-9 && p.x.y < 1;
      });
    };
    for (const double z : {0, 1})
      for (const double x : {0.9, 0.9 + width}) EXPECT_GE(on_edge(x, z), 5) << x << ", " << z;
  }
}

TEST(BodyCloud, LosesDetailsOfEdgesThatAreSmallAndShallowAgainstTheSpacing) {
  // Notches of 0.25 spacings, 0.4 spacings apart.
  std::vector<Vec3> base = {{0, 0, 0}, {1, 0, 0}};
  for (int n = 50; n >= 0; --n) base.push_back({0.02 * n, n % 2 == 0 ? 1.5 : 1.475, 0});
  const Points points = make_body(MPI_COMM_SELF, assemble({prism(base, 0.4)}), uniform(0.1), 1, 1);
  for (const Point& p : points.points)
    for (const Point& q : points.points)
      if (p.id < q.id) EXPECT_GT(norm(p.x - q.x), 0.03);
}

TEST(BodyCloud, TellsOfGapsBetweenPartsButNotOfFacesFlushWithEachOther) {
  const auto notes_on_gaps = [](const std::string& hole, const std::string& pin) {
    const CaseModel m(R"toml(title = "pin in a plate"
method = "sph"
[cloud]
shape = "surface"
spacing = "2.5 mm"
[[cloud.part]]
shape = "box"
size = ["24 mm", "14 mm", "10 mm"]
)toml" + hole + R"toml([[cloud.part]]
shape = "cylinder"
height = "10 mm"
at = ["12 mm", "7 mm", "0 mm"]
)toml" + pin + simple_material({.k = "4", .rho = "2000", .c = "800"}) +
                      "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n");
    return std::ranges::count_if(m.cloud().notes,
                                 [](const std::string& note) { return note.find(" m apart") != note.npos; });
  };
  EXPECT_EQ(notes_on_gaps("", "radius = \"5 mm\"\n"), 0);
  // A hole wider than the pin by 0.1 mm.
  const std::string hole =
      "[[cloud.part]]\nshape = \"cylinder\"\nradius = \"5.1 mm\"\nheight = \"10 mm\"\nat = [\"12 mm\", \"7 mm\", \"0 "
      "mm\"]\n"
      "combine = \"cut\"\n";
  EXPECT_EQ(notes_on_gaps(hole, "radius = \"5 mm\"\n"), 1);
}

}  // namespace
}  // namespace calor
