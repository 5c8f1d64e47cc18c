#include "surface/solid_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "case/case.hpp"
#include "errors.hpp"
#include "surface/combine.hpp"
#include "surface/part_keys.hpp"
#include "surface/polygon.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

Schema part_schema() {
  Schema schema;
  Section part{.path = "cloud.part[]",
               .sentence = "A part.",
               .keys = {{"shape", Kind::choice, "", required, "What it is.", solid_shapes().names()}}};
  for (const Key& key : placing_keys()) part.keys.push_back(key);
  schema.add(part);
  for (const SolidShape& shape : solid_shapes())
    schema.add({.path = "cloud.part[]",
                .sentence = shape.sentence,
                .keys = shape.keys,
                .when_key = "shape",
                .when_value = shape.name});
  declare_holes(schema);
  return schema;
}

/// The surface of a part whose keys are given, closed as all of them.
Surface part(const std::string& keys, double chord = 1e-3) {
  const Case c = Case::parse("[[cloud.part]]\n" + keys, "part.toml", part_schema());
  const Table table = c.section("cloud").list("part").front();
  Surface out = place(solid_shapes().chosen(table, "shape").make(table, chord), table);
  require_closed(out, {.file = "part.toml"});
  return out;
}

double area_of(const Surface& surface, const std::string& face = "") {
  double area = 0;
  for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f)
    if (face.empty() || surface.faces.at(surface.facets[f].face) == face) area += norm(surface.area(f));
  return area;
}

Vec3 area_vector_of(const Surface& surface, const std::string& face) {
  Vec3 area;
  for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f)
    if (surface.faces.at(surface.facets[f].face) == face) area += surface.area(f);
  return area;
}

void expect_near(const Vec3& a, const Vec3& b, double within) { EXPECT_LE(norm(a - b), within); }

constexpr const char* l_polygon =
    "x = ['0 m', '3 m', '3 m', '1 m', '1 m', '0 m']\n"
    "y = ['0 m', '0 m', '1 m', '1 m', '2 m', '2 m']\n";
constexpr const char* two_holes =
    "[[cloud.part.hole]]\nx = ['0.2 m', '0.8 m', '0.8 m', '0.2 m']\n"
    "y = ['0.2 m', '0.2 m', '0.8 m', '0.8 m']\n"
    "[[cloud.part.hole]]\nx = ['2 m', '2.5 m', '2 m']\ny = ['0.1 m', '0.5 m', '0.9 m']\n";

// A body, and what is known of it.
struct Known {
  std::string keys;
  double volume;  ///< m^3; m^2 in the plane
  double area;    ///< of the whole surface, m^2; m in the plane
};

const std::vector<Known> polyhedra = {
    {"shape = 'rectangle'\nsize = ['3 m', '2 m']", 6, 10},
    {"shape = 'polygon'\n" + std::string(l_polygon), 4, 10},
    {"shape = 'polygon'\n" + std::string(l_polygon) + two_holes, 4 - 0.36 - 0.2, 10 + 2.4 + 0.8 + 2 * std::sqrt(0.41)},
    {"shape = 'box'\nsize = ['1 m', '2 m', '3 m']", 6, 22},
    {"shape = 'extrusion'\nheight = '2 m'\n" + std::string(l_polygon), 8, 28},
    {"shape = 'extrusion'\nheight = '2 m'\n" + std::string(l_polygon) + two_holes, 2 * 3.44,
     2 * 3.44 + 2 * (13.2 + 2 * std::sqrt(0.41))},
};

/// Of the spheroid with semi-axes 1, 1, 2: 2 pi a^2 (1 + c/(a e) asin e), e^2 = 1 - a^2/c^2.
double spheroid_area() {
  const double e = std::sqrt(0.75);
  return 2 * pi * (1 + 2 / e * std::asin(e));
}

const std::vector<Known> curved = {
    {"shape = 'disc'\nradius = '2 m'", 4 * pi, 4 * pi},
    {"shape = 'annulus'\ninner = '1 m'\nouter = '2 m'", 3 * pi, 6 * pi},
    {"shape = 'sector'\nouter = '2 m'\nfrom = '-30 deg'\nto = '60 deg'", pi, pi + 4},
    {"shape = 'sector'\ninner = '1 m'\nouter = '2 m'\nfrom = '90 deg'\nto = '360 deg'", 2.25 * pi, 4.5 * pi + 2},
    {"shape = 'cylinder'\nradius = '2 m'\nheight = '3 m'", 12 * pi, 20 * pi},
    {"shape = 'tube'\ninner = '1 m'\nouter = '2 m'\nheight = '3 m'", 9 * pi, 24 * pi},
    {"shape = 'cone'\nbottom_radius = '3 m'\nheight = '4 m'", 12 * pi, 24 * pi},
    {"shape = 'cone'\nbottom_radius = '0 m'\ntop_radius = '3 m'\nheight = '4 m'", 12 * pi, 24 * pi},
    {"shape = 'cone'\nbottom_radius = '4 m'\ntop_radius = '1 m'\nheight = '4 m'", 28 * pi, 42 * pi},
    {"shape = 'sphere'\nradius = '3 m'", 36 * pi, 36 * pi},
    {"shape = 'shell'\ninner = '1 m'\nouter = '2 m'", 28 * pi / 3, 20 * pi},
    {"shape = 'ellipsoid'\nsemi_axes = ['1 m', '1 m', '2 m']", 8 * pi / 3, spheroid_area()},
    // A square ring and a wedge of it, by Pappus: the square of side 1 around r = 2.5 sweeps 2.5 a turn.
    {"shape = 'revolution'\nr = ['2 m', '3 m', '3 m', '2 m']\nz = ['0 m', '0 m', '1 m', '1 m']", 5 * pi, 20 * pi},
    {"shape = 'revolution'\nangle = '90 deg'\nr = ['2 m', '3 m', '3 m', '2 m']\nz = ['0 m', '0 m', '1 m', '1 m']",
     1.25 * pi, 5 * pi + 2},
    // Half of a cylinder with a square hole that runs around it.
    {"shape = 'revolution'\nangle = '180 deg'\nr = ['0 m', '3 m', '3 m', '0 m']\nz = ['0 m', '0 m', '3 m', '3 m']\n"
     "[[cloud.part.hole]]\nr = ['1 m', '2 m', '2 m', '1 m']\nz = ['1 m', '1 m', '2 m', '2 m']",
     12 * pi, 24 * pi + 16},
};

TEST(SolidShapes, HaveTheExactVolumeAndAreaWhereTheyAreFlat) {
  for (const Known& body : polyhedra) {
    const Surface surface = part(body.keys);
    EXPECT_NEAR(enclosed_volume(surface), body.volume, 1e-14 * body.volume) << body.keys;
    EXPECT_NEAR(area_of(surface), body.area, 1e-14 * body.area) << body.keys;
  }
}

TEST(SolidShapes, OfOneRadiusFitIntoEachOther) {
  // What lies between them is an interface, so that the walls of both together are closed.
  const std::string bush = "shape = 'tube'\ninner = '2 m'\nouter = '3 m'\nheight = '1 m'";
  const std::string shell = "shape = 'shell'\ninner = '2 m'\nouter = '3 m'";
  for (const auto& [inside, around] :
       {std::pair<std::string, std::string>{"shape = 'tube'\ninner = '1 m'\nouter = '2 m'\nheight = '1 m'", bush},
        {"shape = 'cylinder'\nradius = '2 m'\nheight = '1 m'", bush},
        {"shape = 'sphere'\nradius = '2 m'", shell},
        {"shape = 'shell'\ninner = '1 m'\nouter = '2 m'", shell}}) {
    SCOPED_TRACE(inside);
    const Surface a = part(inside, 0.4), b = part(around, 0.4);
    Assembly body = assemble({a, b});
    EXPECT_LT(body.walls, std::ssize(body.surface.facets));
    body.surface.facets.resize(body.walls);
    EXPECT_NO_THROW(require_closed(body.surface, {}));
    EXPECT_NEAR(enclosed_volume(body.surface), enclosed_volume(a) + enclosed_volume(b), 1e-12 * enclosed_volume(b));
  }
}

TEST(SolidShapes, HaveVolumesAndAreasThatConvergeWithTheSquareOfTheChord) {
  for (const Known& body : curved) {
    const Surface coarse = part(body.keys, 0.2), fine = part(body.keys, 0.05);
    const auto order = [&](double a, double b, double exact) {
      EXPECT_LT(std::abs(b - exact), 2e-3 * exact) << body.keys;
      return std::log(std::abs(a - exact) / std::abs(b - exact)) / std::log(4);
    };
    // How many chords go into an arc is a whole number, hence not quite 2. Segments of one chord have one sag, whatever
    // the radius: an inner arc of the plane, or of a tube, gives back what the outer one takes, and is left out.
    EXPECT_NEAR(order(area_of(coarse), area_of(fine), body.area), 2, 0.12) << body.keys;
    const bool has_arcs = coarse.dimension == 2 || body.keys.find("tube") != std::string::npos;
    if (has_arcs && std::ranges::count(coarse.faces, "inner")) continue;
    EXPECT_NEAR(order(enclosed_volume(coarse), enclosed_volume(fine), body.volume), 2, 0.12) << body.keys;
  }
}

TEST(SolidShapes, HaveNoFacetWithoutAreaAndOuterNormalsThatAddUpToNothing) {
  for (const std::vector<Known>* bodies : {&polyhedra, &curved})
    for (const Known& body : *bodies) {
      const Surface surface = part(body.keys, 0.2);
      Vec3 sum;
      for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f) {
        EXPECT_GT(norm(surface.area(f)), 1e-5) << body.keys;
        sum += surface.area(f);
      }
      expect_near(sum, {}, 1e-13 * body.area);
    }
}

TEST(SolidShapes, HaveFacetsNoLongerThanTheChordAndNoFartherFromASphereThanItsSag) {
  for (const double chord : {1.0, 0.3, 0.1}) {
    const Surface sphere = part("shape = 'sphere'\nradius = '2 m'", chord);
    for (const Surface::Triangle& facet : sphere.facets) {
      Vec3 corner[3];
      for (int n = 0; n < 3; ++n) {
        corner[n] = sphere.vertices[facet.vertex[n]];
        EXPECT_NEAR(norm(corner[n]), 2, 1e-14);
      }
      for (int n = 0; n < 3; ++n) EXPECT_LE(norm(corner[n] - corner[(n + 1) % 3]), chord);
      // Of a plane at distance p from the centre it is R - p.
      const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
      EXPECT_LE(2 - dot(corner[0], normal) / norm(normal), 1.02 * chord * chord / 16);
    }
  }
  for (const Surface::Triangle& facet : part("shape = 'disc'\nradius = '2 m'", 0.3).facets) EXPECT_EQ(facet.face, 0);
}

TEST(SolidShapes, HaveTheFacesThatTheManualNames) {
  const auto expect_areas = [](const std::string& keys, const std::vector<std::pair<std::string, double>>& areas) {
    const Surface surface = part(keys, 0.03);
    EXPECT_EQ(surface.faces.size(), areas.size()) << keys;
    for (const auto& [face, area] : areas) EXPECT_NEAR(area_of(surface, face), area, 1e-4 * area) << keys << face;
  };
  expect_areas(polyhedra[0].keys, {{"xmin", 2}, {"xmax", 2}, {"ymin", 3}, {"ymax", 3}});
  expect_areas(polyhedra[1].keys, {{"side1", 3}, {"side2", 1}, {"side3", 2}, {"side4", 1}, {"side5", 1}, {"side6", 2}});
  expect_areas(polyhedra[3].keys, {{"xmin", 6}, {"xmax", 6}, {"ymin", 3}, {"ymax", 3}, {"zmin", 2}, {"zmax", 2}});
  expect_areas(curved[1].keys, {{"inner", 2 * pi}, {"outer", 4 * pi}});
  expect_areas(curved[3].keys, {{"inner", 1.5 * pi}, {"outer", 3 * pi}, {"start", 1}, {"end", 1}});
  expect_areas(curved[4].keys, {{"side", 12 * pi}, {"bottom", 4 * pi}, {"top", 4 * pi}});
  expect_areas(curved[5].keys, {{"inner", 6 * pi}, {"outer", 12 * pi}, {"bottom", 3 * pi}, {"top", 3 * pi}});
  expect_areas(curved[6].keys, {{"side", 15 * pi}, {"bottom", 9 * pi}});
  expect_areas(curved[7].keys, {{"side", 15 * pi}, {"top", 9 * pi}});
  expect_areas(curved[8].keys, {{"side", 25 * pi}, {"bottom", 16 * pi}, {"top", pi}});
  expect_areas(curved[10].keys, {{"inner", 4 * pi}, {"outer", 16 * pi}});
  expect_areas(
      curved[13].keys,
      {{"side1", 1.25 * pi}, {"side2", 1.5 * pi}, {"side3", 1.25 * pi}, {"side4", pi}, {"start", 1}, {"end", 1}});
  // The side on the axis is on no face.
  expect_areas(
      curved[14].keys,
      {{"side1", 4.5 * pi}, {"side2", 9 * pi}, {"side3", 4.5 * pi}, {"hole1", 6 * pi}, {"start", 8}, {"end", 8}});
}

TEST(SolidShapes, HaveOuterNormalsOnEveryFace) {
  const Surface box = part("shape = 'box'\nsize = ['1 m', '2 m', '3 m']");
  expect_near(area_vector_of(box, "xmin"), {-6, 0, 0}, 1e-14);
  expect_near(area_vector_of(box, "ymax"), {0, 3, 0}, 1e-14);
  expect_near(area_vector_of(box, "zmin"), {0, 0, -2}, 1e-14);
  const Surface wedge = part(curved[13].keys, 0.05);
  expect_near(area_vector_of(wedge, "start"), {0, -1, 0}, 1e-14);
  expect_near(area_vector_of(wedge, "end"), {-1, 0, 0}, 1e-14);
  const Surface sector = part(curved[3].keys, 0.05);
  expect_near(area_vector_of(sector, "start"), {1, 0, 0}, 1e-14);
  expect_near(area_vector_of(sector, "end"), {0, 1, 0}, 1e-14);
}

TEST(SolidShapes, KeepTheNamesOfSidesOfAPolygonGivenClockwise) {
  const std::string names = "names = ['south', 'east', 'notch', 'notch', 'north', 'west']\n";
  const Surface forwards = part("shape = 'polygon'\n" + names + l_polygon);
  EXPECT_EQ(forwards.faces.size(), 5);
  const Surface backwards = part(
      "shape = 'polygon'\nnames = ['west', 'north', 'notch', 'notch', 'east', 'south']\n"
      "x = ['0 m', '0 m', '1 m', '1 m', '3 m', '3 m']\ny = ['0 m', '2 m', '2 m', '1 m', '1 m', '0 m']");
  EXPECT_EQ(enclosed_volume(backwards), 4);
  for (const std::string& face : forwards.faces)
    expect_near(area_vector_of(backwards, face), area_vector_of(forwards, face), 1e-15);
  const Surface one = part("shape = 'extrusion'\nheight = '1 m'\nnames = 'side'\n" + std::string(l_polygon));
  EXPECT_EQ(one.faces, (std::vector<std::string>{"side", "bottom", "top"}));
}

// Places -------------------------------------------------------------------------------------------------------------

TEST(SolidShapes, KeepVolumeAndFacesWhereverTheyStand) {
  for (const std::vector<Known>* bodies : {&polyhedra, &curved})
    for (const Known& body : *bodies) {
      const Surface here = part(body.keys, 0.3);
      const std::string placing = here.dimension == 2
                                      ? "at = ['3 m', '-2 m']\nturn = '25 deg'\n"
                                      : "at = ['3 m', '-2 m', '1 m']\nturn = ['25 deg', '40 deg', '-70 deg']\n";
      const Surface there = part(placing + body.keys, 0.3);
      EXPECT_NEAR(enclosed_volume(there), enclosed_volume(here), 3e-14 * body.volume) << body.keys;
      for (const std::string& face : here.faces)
        EXPECT_NEAR(area_of(there, face), area_of(here, face), 1e-13 * body.area) << body.keys;
    }
}

TEST(SolidShapes, TurnAroundFixedAxesInTheOrderXYZAndThenMove) {
  const std::string box = "shape = 'box'\nsize = ['1 m', '2 m', '3 m']\n";
  const auto far_corner = [](const Surface& surface) { return surface.vertices[5]; };  // (1, 2, 3), on the top
  expect_near(far_corner(part(box)), {1, 2, 3}, 0);
  // By hand; right angles are exact.
  expect_near(far_corner(part("turn = ['90 deg', '0 deg', '0 deg']\n" + box)), {1, -3, 2}, 0);
  expect_near(far_corner(part("turn = ['0 deg', '90 deg', '0 deg']\n" + box)), {3, 2, -1}, 0);
  expect_near(far_corner(part("turn = ['0 deg', '0 deg', '90 deg']\n" + box)), {-2, 1, 3}, 0);
  expect_near(far_corner(part("turn = ['90 deg', '90 deg', '0 deg']\n" + box)), {2, -3, -1}, 0);
  expect_near(far_corner(part("at = ['10 m', '0 m', '0 m']\nturn = ['90 deg', '90 deg', '0 deg']\n" + box)),
              {12, -3, -1}, 0);
  // A third of a turn, (1, 0) -> (-1/2, sqrt(3)/2).
  const Surface plane = part("shape = 'rectangle'\nsize = ['1 m', '1 m']\nturn = '120 deg'");
  expect_near(plane.vertices[1], {-0.5, std::sqrt(0.75), 0}, 1e-15);
}

TEST(SolidShapes, ComeInCopies) {
  const Surface one = part("shape = 'tube'\ninner = '1 m'\nouter = '2 m'\nheight = '1 m'", 0.1);
  const Surface five = part(
      "shape = 'tube'\ninner = '1 m'\nouter = '2 m'\nheight = '1 m'\ncount = 5\nstep = ['5 m', '0 m', '1 m']", 0.1);
  EXPECT_EQ(five.faces, one.faces);
  EXPECT_NEAR(enclosed_volume(five), 5 * enclosed_volume(one), 1e-12);
  EXPECT_NEAR(area_of(five, "inner"), 5 * area_of(one, "inner"), 1e-12);
  expect_near(five.vertices.back() - one.vertices.back(), {20, 0, 4}, 1e-13);
  EXPECT_EQ(enclosed_volume(part("shape = 'rectangle'\nsize = ['1 m', '1 m']\ncount = 3\nstep = ['2 m', '0 m']")), 3);
}

TEST(SolidShapes, MayReachIntoTheBoxOfACopyButNotTouchIt) {
  // An angle of two arms 3 long and 1 wide; the next one lies in its corner.
  const std::string angle =
      "shape = 'extrusion'\nheight = '1 m'\nx = ['0 m', '3 m', '3 m', '1 m', '1 m', '0 m']\n"
      "y = ['0 m', '0 m', '1 m', '1 m', '3 m', '3 m']\ncount = 3\n";
  EXPECT_NEAR(enclosed_volume(part(angle + "step = ['1.1 m', '1.1 m', '0 m']")), 15, 1e-13);
  EXPECT_NEAR(enclosed_volume(part("shape = 'disc'\nradius = '1 m'\ncount = 4\nstep = ['1.5 m', '1.5 m']", 0.01)),
              4 * pi, 1e-3);
  const auto expect_touching = [](const std::string& keys, const std::string& words) {
    expect_error([&] { part(keys, 0.1); }, {"part.toml", words, "longer step"});
  };
  expect_touching(angle + "step = ['1 m', '1 m', '0 m']", "copy 2 touches the first one");
  expect_touching(angle + "step = ['0.5 m', '-0.2 m', '0.3 m']", "copy 2 touches the first one");
  expect_touching("shape = 'box'\nsize = ['1 m', '1 m', '1 m']\ncount = 2\nstep = ['1 m', '0.3 m', '0 m']",
                  "the shape measures 1 x 1 x 1 m");
  expect_touching("shape = 'disc'\nradius = '1 m'\ncount = 4\nstep = ['1.3 m', '1.3 m']", "copy 2 touches");
  expect_touching("shape = 'rectangle'\nsize = ['1 m', '1 m']\ncount = 2\nstep = ['0 m', '-1 m']", "copy 2 touches");
}

// Refusals -----------------------------------------------------------------------------------------------------------

void expect_refused(const std::string& keys, const std::vector<std::string>& words, double chord = 1) {
  SCOPED_TRACE(keys);
  expect_error([&] { part(keys, chord); }, words);
}

TEST(SolidShapes, RefuseLengthsThatAreNotPositive) {
  expect_refused("shape = 'disc'\nradius = '0 m'", {"part.toml:3:", "radius = 0 m is not positive"});
  expect_refused("shape = 'box'\nsize = ['1 m', '-1 m', '1 m']", {"part.toml:3:", "a length of -1 m"});
  expect_refused("shape = 'box'\nsize = ['1 m', '1 m']", {"size has 2 numbers", "give 3"});
  expect_refused("shape = 'cylinder'\nradius = '1 m'\nheight = '-1 m'", {"part.toml:4:", "height"});
  expect_refused("shape = 'tube'\ninner = '2 m'\nouter = '2 m'\nheight = '1 m'", {"inner = 2 m is not below outer"});
  expect_refused("shape = 'annulus'\ninner = '0 m'\nouter = '2 m'", {"inner = 0 m is not positive"});
  expect_refused("shape = 'cone'\nbottom_radius = '0 m'\nheight = '1 m'", {"both radii of the cone are 0"});
  expect_refused("shape = 'cone'\nbottom_radius = '1 m'\ntop_radius = '-1 m'\nheight = '1 m'",
                 {"top_radius", "negative"});
  expect_refused("shape = 'ellipsoid'\nsemi_axes = ['1 m', '1 m', '0 m']", {"semi_axes", "not positive"});
}

TEST(SolidShapes, RefuseAnglesThatAreNone) {
  const std::string sector = "shape = 'sector'\nouter = '1 m'\n",
                    ring =
                        "shape = 'revolution'\n"
                        "r = ['1 m', '2 m', '2 m']\nz = ['0 m', '0 m', '1 m']\n";
  expect_refused(sector + "from = '30 deg'\nto = '-30 deg'", {"part.toml:5:", "ends at -30 degrees and begins at 30"});
  expect_refused(sector + "from = '0 deg'\nto = '360 deg'", {"a sector of 360 degrees", "annulus"});
  expect_refused(ring + "angle = '0 deg'", {"an angle of 0 degrees", "up to 360"});
  expect_refused(ring + "angle = '361 deg'", {"an angle of 361 degrees"});
}

TEST(SolidShapes, RefusePolygonsThatEncloseNothing) {
  const auto polygon = [](const std::string& x, const std::string& y) {
    return "shape = 'polygon'\nx = [" + x + "]\ny = [" + y + "]\n";
  };
  expect_refused(polygon("'0 m', '1 m'", "'0 m', '1 m'"), {"part.toml:3:", "2 corners", "at least 3"});
  expect_refused(polygon("'0 m', '1 m', '1 m'", "'0 m', '1 m'"), {"part.toml:4:", "2 coordinates for 3 corners"});
  expect_refused(polygon("'0 m', '1 m', '0 m', '1 m'", "'0 m', '1 m', '1 m', '0 m'"), {"sides 1 and 3 cross"});
  expect_refused(polygon("'0 m', '2 m', '2 m', '1 m', '0 m'", "'0 m', '0 m', '1 m', '0 m', '1 m'"),
                 {"sides 1 and 3 cross or touch"});
  expect_refused(polygon("'0 m', '1 m', '1 m', '0 m'", "'0 m', '0 m', '1 m', '0 m'"), {"corners 4 and 1 coincide"});
  expect_refused(polygon("'0 m', '1 m', '2 m'", "'0 m', '0 m', '0 m'"), {"turns back on itself"});
  expect_refused("shape = 'revolution'\nr = ['-1 m', '1 m', '1 m']\nz = ['0 m', '0 m', '1 m']\n",
                 {"corner 1 has r = -1 m"});
}

TEST(SolidShapes, RefuseHolesThatAreNotInside) {
  const auto with_hole = [](const std::string& x, const std::string& more = "") {
    return "shape = 'polygon'\nx = ['0 m', '4 m', '4 m', '0 m']\ny = ['0 m', '0 m', '4 m', '4 m']\n" + more +
           "[[cloud.part.hole]]\nx = [" + x + "]\ny = ['1 m', '1 m', '3 m', '3 m']\n";
  };
  const std::string other = "[[cloud.part.hole]]\nx = ['1.5 m', '2 m', '1.5 m']\ny = ['1.5 m', '1.5 m', '2 m']\n";
  expect_refused(with_hole("'3 m', '5 m', '5 m', '3 m'"), {"part.toml:6:", "crosses or touches a side of the polygon"});
  expect_refused(with_hole("'0 m', '1 m', '1 m', '0 m'"), {"crosses or touches a side of the polygon"});
  expect_refused(with_hole("'5 m', '6 m', '6 m', '5 m'"), {"the hole lies outside the polygon"});
  expect_refused(with_hole("'1 m', '3 m', '3 m', '1 m'", other), {"hole 1 lie in each other"});
  expect_refused("shape = 'polygon'\nx = ['0 m', '4 m', '4 m']\ny = ['0 m', '0 m', '4 m']\n[[cloud.part.hole]]\n",
                 {"part.toml:5:", "a polygon without x"});
  expect_refused("shape = 'disc'\nradius = '1 m'\n[[cloud.part.hole]]\n", {"'hole' goes with shape = \"polygon\""});
}

TEST(SolidShapes, RefuseNamesThatDoNotFit) {
  const std::string extrusion = "shape = 'extrusion'\nheight = '1 m'\n" + std::string(l_polygon);
  expect_refused(extrusion + "names = ['a', 'b']", {"2 names for 6 sides"});
  expect_refused(extrusion + "names = 'top'", {"\"top\" is the name of another face"});
  expect_refused(extrusion + "names = ''", {"an empty name"});
}

TEST(SolidShapes, RefusePlacesThatDoNotFit) {
  const std::string box = "shape = 'box'\nsize = ['1 m', '2 m', '3 m']\n", disc = "shape = 'disc'\nradius = '1 m'\n";
  expect_refused(box + "at = ['1 m', '2 m']", {"at has 2 numbers for a shape of 3 dimensions"});
  expect_refused(box + "turn = '90 deg'", {"turn has 1 angle", "give three"});
  expect_refused(disc + "turn = ['90 deg', '0 deg', '0 deg']", {"turn has 3 angles", "give one"});
  expect_refused(box + "count = 0", {"a count of 0"});
  expect_refused(box + "count = 2", {"2 copies in one place", "add step"});
  expect_refused(box + "step = ['1 m', '0 m', '0 m']", {"a step without copies"});
  expect_refused(box + "count = 2\nstep = ['0 m', '0 m', '0 m']", {"the copies lie on each other"});
}

TEST(SolidShapes, RefuseFacetsThatNoMemoryHolds) {
  expect_refused("shape = 'disc'\nradius = '1 km'", {"part.toml:3:", "facets", "larger spacing"}, 1e-6);
  expect_refused("shape = 'sphere'\nradius = '1 m'", {"part.toml:3:", "facets", "larger spacing"}, 1e-4);
}

}  // namespace
}  // namespace calor
