#include "surface/surface_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <sstream>

#include "case/case.hpp"
#include "errors.hpp"
#include "results.hpp"
#include "surface/solid_shapes.hpp"
#include "surfaces.hpp"

namespace calor {
namespace {

// Writers of the test's own, after the descriptions of the formats.

template <class Number>
std::string bytes_of(Number value, std::endian order = std::endian::little) {
  char bytes[sizeof(Number)];
  std::memcpy(bytes, &value, sizeof(Number));
  if (order != std::endian::native) std::reverse(bytes, bytes + sizeof(Number));
  return {bytes, sizeof(Number)};
}

std::string text_of(const Vec3& x) {
  std::ostringstream out;
  out.precision(17);
  out << x.x << ' ' << x.y << ' ' << x.z;
  return out.str();
}

std::string stl_text(const Surface& s) {
  std::string out;
  for (std::size_t face = 0; face < s.faces.size(); ++face) {
    out += "solid " + s.faces[face] + "\n";
    for (const auto& facet : s.facets) {
      if (facet.face != static_cast<std::int32_t>(face)) continue;
      out += " facet normal nan 0 0\n  outer loop\n";
      for (const auto v : facet.vertex) out += "   vertex " + text_of(s.vertices[v]) + "\n";
      out += "  endloop\n endfacet\n";
    }
    out += "endsolid " + s.faces[face] + "\n";
  }
  return out;
}

std::string stl_binary(const Surface& s) {
  std::string out = "solid as many programs write here";
  out.resize(80, ' ');
  out += bytes_of(static_cast<std::uint32_t>(s.facets.size()));
  for (const auto& facet : s.facets) {
    for (int n = 0; n < 3; ++n) out += bytes_of(0.0F);
    for (const auto v : facet.vertex)
      for (int a = 0; a < 3; ++a) out += bytes_of(static_cast<float>(s.vertices[v][a]));
    out += std::string(2, '\0');
  }
  return out;
}

std::string obj(const Surface& s) {
  std::string out = "# a comment\nmtllib no.mtl\n";
  for (const Vec3& x : s.vertices) out += "v " + text_of(x) + "\n";
  out += "vn 0 0 1\n";
  for (const auto& facet : s.facets) {
    out += "g " + s.faces[facet.face] + "\nf";
    for (const auto v : facet.vertex) out.append(" ").append(std::to_string(v + 1)).append("//1");
    out += "\r\n";
  }
  return out;
}

std::string ply_header(const Surface& s, const std::string& format, const std::string& number) {
  return "ply\nformat " + format + " 1.0\ncomment of a test\nelement vertex " + std::to_string(s.vertices.size()) +
         "\nproperty uchar red\nproperty " + number + " x\nproperty " + number + " y\nproperty " + number +
         " z\nelement face " + std::to_string(s.facets.size()) +
         "\nproperty list uchar int vertex_indices\nproperty list uchar float weights\nend_header\n";
}

std::string ply_text(const Surface& s) {
  std::string out = ply_header(s, "ascii", "double");
  for (const Vec3& x : s.vertices) out += "255 " + text_of(x) + "\n";
  for (const auto& facet : s.facets) {
    out += "3";
    for (const auto v : facet.vertex) out.append(" ").append(std::to_string(v));
    out += " 1 0.5\n";
  }
  return out;
}

template <class Number>
std::string ply_binary(const Surface& s, std::endian order) {
  std::string out = ply_header(s, order == std::endian::big ? "binary_big_endian" : "binary_little_endian",
                               sizeof(Number) == 4 ? "float32" : "float64");
  for (const Vec3& x : s.vertices) {
    out += '\7';
    for (int a = 0; a < 3; ++a) out += bytes_of(static_cast<Number>(x[a]), order);
  }
  for (const auto& facet : s.facets) {
    out += '\3';
    for (const auto v : facet.vertex) out += bytes_of(static_cast<std::int32_t>(v), order);
    out += '\2' + bytes_of(1.0F, order) + bytes_of(2.0F, order);
  }
  return out;
}

Surface read(const std::string& name, const std::string& contents) {
  const TemporaryFolder folder;
  return read_surface(folder.write(name, contents), {.file = "case.toml", .line = 3, .column = 0});
}

/// The message, with NAME for the path.
std::string refusal(const std::string& name, const std::string& contents) {
  const TemporaryFolder folder;
  const std::string path = folder.write(name, contents);
  const Error e = error_of([&] { read_surface(path, {.file = "case.toml", .line = 3, .column = 0}); });
  EXPECT_FALSE(e.cure().empty());
  const std::string what = e.what();
  return what.starts_with(path) ? "NAME" + what.substr(path.size()) : what;
}

/// Coordinates and faces of all facets, whatever their vertices are called.
void expect_same(const Surface& a, const Surface& b, double tolerance) {
  ASSERT_EQ(a.facets.size(), b.facets.size());
  for (std::size_t f = 0; f < a.facets.size(); ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_LE(norm(a.vertices[a.facets[f].vertex[k]] - b.vertices[b.facets[f].vertex[k]]), tolerance) << f;
}

Surface cuboid() {  // of no round numbers, in facets of six faces
  Surface s = unit_cube();
  for (Vec3& x : s.vertices) x = Vec3{-1.0 / 3, 2e-3, 1e3} + product({std::numbers::pi, 1e-2, 7}, x);
  return s;
}

TEST(SurfaceFiles, GiveBackWhatWasWritten) {
  const Surface s = cuboid();
  const double single = 1e3 * 1e-7;
  expect_same(read("a.stl", stl_text(s)), s, 0);
  expect_same(read("A.STL", stl_binary(s)), s, single);
  expect_same(read("a.obj", obj(s)), s, 0);
  expect_same(read("a.ply", ply_text(s)), s, 0);
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    expect_same(read("a.ply", ply_binary<double>(s, order)), s, 0);
    expect_same(read("a.ply", ply_binary<float>(s, order)), s, single);
  }
}

TEST(SurfaceFiles, NameFacesAfterSolidsAndGroups) {
  const Surface s = cuboid();
  for (const Surface& found : {read("a.stl", stl_text(s)), read("a.obj", obj(s))}) {
    EXPECT_EQ(found.faces, s.faces);
    for (std::size_t f = 0; f < s.facets.size(); ++f) EXPECT_EQ(found.facets[f].face, s.facets[f].face);
  }
  const std::vector<std::string> one = {"surface"};
  EXPECT_EQ(read("a.stl", stl_binary(s)).faces, one);
  EXPECT_EQ(read("a.ply", ply_text(s)).faces, one);
  Surface unnamed = s;
  unnamed.faces = {"", "", "", "", "", ""};
  EXPECT_EQ(read("a.stl", stl_text(unnamed)).faces, one);
  EXPECT_EQ(read("a.obj",
                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\no body\nusemtl hot wall\nf 1 2 4\ng rest\nf 1 "
                 "4 3\ng nothing\ng rest\nf 2 3 4\n")
                .faces,
            (std::vector<std::string>{"surface", "hot wall", "rest"}));
}

TEST(SurfaceFiles, CutPolygonsIntoFansAndCountBackFromTheLastVertex) {
  const Surface s =
      read("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nv -1 0.5 0\nf 1/1 2/2 3/3 \\\n4/4 5/5\n");
  ASSERT_EQ(s.facets.size(), 4u);
  EXPECT_EQ(s.facets[0].vertex, (std::array<std::int32_t, 3>{0, 1, 2}));
  EXPECT_EQ(s.facets[3].vertex, (std::array<std::int32_t, 3>{0, 3, 4}));
}

TEST(SurfaceFiles, NameTheLineOfWhatIsWrongInText) {
  const std::string facet = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
  const auto stl = [&](const std::string& rest) { return refusal("a.stl", facet + rest); };
  expect_words(stl("vertex 0 nan 0\nendloop\nendfacet\nendsolid a\n"), {"NAME:6: a coordinate is 'nan'"});
  expect_words(stl("vertex 0 1e999 0\nendloop\nendfacet\nendsolid a\n"), {"NAME:6: a coordinate is '1e999'"});
  expect_words(stl("vertex 0 1,5 0\nendloop\nendfacet\nendsolid a\n"), {"NAME:6: '1,5' where a number should come"});
  expect_words(stl("endloop\nendfacet\nendsolid a\n"), {"NAME:6: a facet has 2 corners"});
  expect_words(stl("vertex 0 1"), {"NAME:6: there is nothing where a number should come", "cut off"});
  expect_words(stl("vertex 0 1 0\nendloop\nendfacet\n"), {"without 'endsolid'"});
  expect_words(refusal("a.stl", "solid a\nendsolid a\n"), {"no facets"});
  expect_words(refusal("a.stl", "solid a\n<html>\n"), {"NAME:2: '<html>' where 'facet'"});
  expect_words(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), {"NAME:4: a facet has vertex 4", "3 before"});
  expect_words(refusal("a.obj", "v 0 0 0\nf 0 0 0\n"), {"NAME:2: a facet has vertex 0"});
  expect_words(refusal("a.obj", "v 0 0 0\nf -2 1 1\n"), {"NAME:2: a facet has vertex -2"});
  expect_words(refusal("a.obj", "v 0 0\nf 1 1 1\n"), {"NAME:1: there is nothing where a number"});
  expect_words(refusal("a.obj", "v 0 0 0\nf 1 1\n"), {"NAME:2: a facet has 2 corners"});
  expect_words(refusal("a.obj", "v 0 0 0\nf 1 1 99999999999999999999\n"), {"NAME:2:", "whole number"});
  expect_words(refusal("a.obj", "v 0 0 inf\n"), {"NAME:1: a coordinate is 'inf'"});
  expect_words(refusal("a.obj", "v 0 0 0\n"), {"no facets"});
  expect_words(refusal("a.obj", "cstype bezier\n"), {"NAME:1:", "curved"});
  const std::string ply = ply_header(tetrahedron(), "ascii", "float");
  expect_words(refusal("a.ply", ply + "1 0 0 0\n1 1 0\n"), {"NAME:15: there is nothing where a number"});
  expect_words(refusal("a.ply", ply + "1 0 0 0\n1 1 0 nan\n"), {"NAME:14:", "vertex 1 is not finite"});
}

TEST(SurfaceFiles, NameTheByteOfWhatIsWrongInBinaryFiles) {
  const Surface s = tetrahedron();
  std::string stl = stl_binary(s);
  expect_words(refusal("a.stl", stl + "x"), {"NAME: ", "4 facets has 284 bytes, this one has 285"});
  expect_words(refusal("a.stl", stl.substr(0, 200)), {"284 bytes", "200"});
  std::string huge = stl;
  huge.replace(80, 4, 4, '\xff');
  expect_words(refusal("a.stl", huge), {"4294967295 facets"});
  stl.replace(84 + 50 + 12, 4, bytes_of(std::numeric_limits<float>::quiet_NaN()));
  expect_words(refusal("a.stl", stl), {"facet 2 (byte 146) is not finite"});
  std::string empty = stl.substr(0, 84);
  empty.replace(80, 4, 4, '\0');
  expect_words(refusal("a.stl", empty), {"no facets"});

  const std::string ply = ply_binary<float>(s, std::endian::little);
  for (std::size_t size = ply.find("end_header") + 11; size < ply.size(); ++size)
    expect_words(refusal("a.ply", ply.substr(0, size)), {"NAME: byte ", "ends too early"});
  const std::size_t faces = ply.size() - 4 * 22;  // of 1 + 3 x 4 + 1 + 2 x 4 bytes
  std::string wrong = ply;
  wrong.replace(faces + 1, 4, bytes_of<std::int32_t>(4));
  expect_words(refusal("a.ply", wrong), {"facet 0 has vertex 4, but there are 4"});
  wrong.replace(faces + 1, 4, bytes_of<std::int32_t>(-1));
  expect_words(refusal("a.ply", wrong), {"facet 0 has vertex -1"});
  wrong = ply;
  wrong[faces] = '\2';
  expect_words(refusal("a.ply", wrong), {"a facet has 2 corners"});
  wrong = ply;
  const std::string count = "element vertex 4\n";
  wrong.replace(wrong.find(count), count.size(), "element vertex 900000000000000000\n");
  expect_words(refusal("a.ply", wrong), {"ends too early"});
}

TEST(SurfaceFiles, AreRefusedWhereTheyAreNoSurfaces) {
  for (const char* name : {"a.stl", "a.obj", "a.ply"}) {
    expect_words(refusal(name, ""), {"NAME:1: the file is empty"});
    expect_words(refusal(name, " \n\n"), {"NAME:1: the file is empty"});
    EXPECT_TRUE(refusal(name, "hello\n").starts_with("NAME"));
    EXPECT_TRUE(refusal(name, std::string(300, '\0')).starts_with("NAME"));
    EXPECT_TRUE(refusal(name, std::string(300, '\xee')).starts_with("NAME"));
  }
  expect_words(refusal("a.xyz", "1 2 3"), {"case.toml:3: ", "a.xyz", ".stl, .obj, .ply"});
  expect_words(refusal("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n"), {"header has no end"});
  expect_words(refusal("a.ply", "ply\nend_header\n"), {"no format"});
  expect_words(refusal("a.ply", "ply\nformat ascii 1.0\nend_header\n"), {"no element 'vertex'"});
  expect_words(refusal("a.ply", "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n"), {"-1"});
  expect_words(refusal("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty long x\nend_header\n"), {"'long'"});
  const std::string path = "/nowhere/a.stl";
  expect_error([&] { read_surface(path, {.file = "case.toml", .line = 3, .column = 0}); },
               {"case.toml:3: the file \"/nowhere/a.stl\" cannot be read"}, Fault::file);
}

// The shape of [[cloud.part]]
// ------------------------------------------------------------------------------------------

/// The part of a file of this name in a folder of its own; `keys` go with shape and file.
Surface part(const std::string& name, const std::string& contents, const std::string& keys) {
  const TemporaryFolder folder;
  Schema schema;
  schema.add({.path = "cloud.part[]",
              .sentence = "A part.",
              .keys = {{"shape", Kind::choice, "", required, "What it is.", solid_shapes().names()}}});
  const SolidShape& file = *solid_shapes().find("file");
  schema.add(
      {.path = "cloud.part[]", .sentence = "A file.", .keys = file.keys, .when_key = "shape", .when_value = "file"});
  const Case c =
      Case::parse("[[cloud.part]]\nshape = \"file\"\nfile = \"" + folder.write(name, contents) + "\"\n" + keys,
                  "case.toml", schema);
  return file.make(c.section("cloud").list("part").front(), 1);
}

TEST(FilePart, IsAClosedSurfaceInMetres) {
  const Surface s = part("a.stl", stl_text(unit_cube()), "unit = \"mm\"");
  EXPECT_EQ(s.vertices.size(), 8u);
  EXPECT_NEAR(enclosed_volume(s), 1e-9, 1e-23);
  EXPECT_NEAR(enclosed_volume(part("a.ply", ply_text(sphere(9)), "unit = \"inch\"")),
              enclosed_volume(sphere(9)) * std::pow(0.0254, 3), 1e-18);
  EXPECT_NEAR(enclosed_volume(part("a.obj", obj(unit_cube()), "unit = \"2.5 cm\"")), std::pow(0.025, 3), 1e-18);
}

TEST(FilePart, WeldsAndTurnsWhatTheFileHas) {
  Surface s = unit_cube();
  for (auto& facet : s.facets) std::swap(facet.vertex[0], facet.vertex[1]);
  std::swap(s.facets[5].vertex[0], s.facets[5].vertex[1]);
  EXPECT_NEAR(enclosed_volume(part("a.stl", stl_binary(s), "unit = \"m\"")), 1, 1e-15);
  std::string loose = stl_text(unit_cube());
  const std::size_t at = loose.find("vertex 1 ");
  loose.replace(at, 9, "vertex 1.00001 ");
  expect_error([&] { part("a.stl", loose, "unit = \"m\""); }, {"a.stl: the surface is not closed", "weld"});
  EXPECT_NEAR(enclosed_volume(part("a.stl", loose, "unit = \"m\"\nweld = 1e-4")), 1, 1e-4);
}

TEST(FilePart, IsRefusedWithAPlace) {
  const std::string cube = stl_text(unit_cube());
  expect_error([&] { part("a.stl", cube, ""); }, {"case.toml:1", "unit of length", "unit = \"mm\""});
  expect_error([&] { part("a.stl", cube, "unit = \"kg\""); }, {"case.toml:4:8", "kg", "unit = \"mm\""});
  expect_error([&] { part("a.stl", cube, "unit = \"-1 m\""); }, {"case.toml:4:8", "not positive"});
  expect_error([&] { part("a.stl", cube, "unit = \"m\"\nweld = 0.5"); }, {"case.toml:5:8", "weld"});
  Surface open = unit_cube();
  open.facets.pop_back();
  expect_error([&] { part("a.stl", stl_binary(open), "unit = \"mm\""); },
               {"a.stl: the surface is not closed: 3 edges with one facet only, at (0, 0.0005, 0.001) m, ("});
}

TEST(FilePart, MayHaveFacesByTheAngleBetweenFacets) {
  const Surface s = part("a.stl", stl_binary(cuboid()), "unit = \"m\"\nfaces = \"angle\"");
  EXPECT_EQ(s.faces.size(), 6u);
  EXPECT_EQ(part("a.stl", stl_binary(sphere(2)), "unit = \"m\"\nfaces = \"angle\"\nangle = \"60 deg\"").faces.size(),
            1u);
  expect_error([&] { part("a.stl", stl_binary(sphere(4)), "unit = \"m\"\nfaces = \"angle\"\nangle = \"1 deg\""); },
               {"faces, the most are 32", "larger angle"});
  Surface many = sphere(4);
  many.faces.clear();
  for (auto& facet : many.facets) {
    facet.face = static_cast<std::int32_t>(many.faces.size());
    many.faces.push_back("solid" + std::to_string(facet.face));
  }
  expect_error([&] { part("a.stl", stl_text(many), "unit = \"m\""); }, {"128 faces, the most are 32", "\"angle\""});
}

}  // namespace
}  // namespace calor
