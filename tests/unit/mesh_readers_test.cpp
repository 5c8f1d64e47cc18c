// Readers of meshes: one body in every format.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "cloud/shapes.hpp"
#include "errors.hpp"
#include "mesh/mesh.hpp"
#include "results.hpp"

namespace calor {
namespace {

Mesh read_text(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  return read_mesh(folder.write(name, text));
}

const std::string gmsh_2 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
1 7 "left side"
2 9 "steel"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 2 0 0
3 2 1 0
40 0 1 0
5 9 9 9
$EndNodes
$Elements
5
1 15 2 3 1 1
2 1 2 7 1 40 1
3 1 2 8 1 2 3
4 2 2 9 1 1 2 3
5 2 2 9 1 1 3 40
$EndElements
)";

const std::string gmsh_4 = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 7 "left side"
2 9 "steel"
$EndPhysicalNames
$Entities
1 2 1 0
1 0 0 0 1 3
1 0 0 0 0 1 0 1 -7 2 1 -1
2 0 0 0 0 1 0 1 8 0
1 0 0 0 2 1 0 1 9 2 1 2
$EndEntities
$Nodes
2 5 1 40
0 1 0 1
1
0 0 0
2 1 0 4
2
3
40
5
2 0 0
2 1 0
0 1 0
9 9 9
$EndNodes
$Elements
4 5 1 5
0 1 15 1
1 1
1 1 1 1
2 40 1
1 2 1 1
3 2 3
2 1 2 2
4 1 2 3
5 1 3 40
$EndElements
)";

const std::string abaqus = R"(*Heading
 a rectangle
** comment
*NODE, NSET=Nall
1, 0., 0.
2, 2., 0.
3, 2., 1., 0.
40, 0., 1.,
5, 9., 9., 9.
*ELEMENT, TYPE=CPS3, ELSET=Eall
4, 1, 2,
3
5, 1, 3, 40
*ELEMENT, TYPE=T2D2, ELSET="left side"
2, 40, 1
*ELSET, ELSET=steel, GENERATE
4, 5, 1
*NSET, NSET=8
2, 3
*SOLID SECTION, ELSET=steel, MATERIAL=S
)";

std::string vtu(const std::string& format) {
  // Cells: lines (40, 1), (2, 3), triangles; groups 7, 8, 9, 9.
  const std::vector<double> x = {0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0, 9, 9, 9};
  const std::vector<std::int64_t> nodes = {3, 0, 1, 2, 0, 1, 2, 0, 2, 3}, ends = {2, 4, 7, 10}, groups = {7, 8, 9, 9};
  const std::vector<std::uint8_t> types = {3, 3, 5, 5};
  std::string appended;
  const auto encoded = [](const std::string& bytes) {
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t n = 0; n < bytes.size(); n += 3) {
      std::uint32_t value = 0;
      for (std::size_t k = n; k < n + 3; ++k)
        value = value << 8 | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0);
      for (std::size_t k = 0; k < 4; ++k) out += n + k > bytes.size() ? '=' : digits[value >> (18 - 6 * k) & 63];
    }
    return out;
  };
  const auto array = [&](const std::string& name, const std::string& type, const auto& values) {
    const std::string head = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                             (name == "Points" ? "3" : "1") + "\" format=\"";
    if (format == "ascii") return head + fmt::format("ascii\">{}</DataArray>\n", fmt::join(values, " "));
    const std::uint64_t size = values.size() * sizeof values[0];
    std::string bytes(sizeof size + size, '\0');
    std::memcpy(bytes.data(), &size, sizeof size);
    std::memcpy(bytes.data() + sizeof size, values.data(), size);
    if (format == "binary") return head + "binary\">\n" + encoded(bytes) + "\n</DataArray>\n";
    const std::size_t offset = appended.size();
    appended += format == "raw" ? bytes : encoded(bytes);
    return head + fmt::format("appended\" offset=\"{}\"/>\n", offset);
  };
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<!-- <Piece> -->\n<UnstructuredGrid>\n"
      "<Piece NumberOfPoints=\"5\" NumberOfCells=\"4\">\n<Points>\n";
  text += array("Points", "Float64", x) + "</Points>\n<Cells>\n" + array("connectivity", "Int64", nodes) +
          array("offsets", "Int64", ends) + array("types", "UInt8", types) + "</Cells>\n<CellData>\n" +
          array("MaterialIDs", "Int64", groups) + "</CellData>\n</Piece>\n</UnstructuredGrid>\n";
  if (!appended.empty())
    text += "<AppendedData encoding=\"" + std::string(format == "raw" ? "raw" : "base64") + "\">\n_" + appended +
            "\n</AppendedData>\n";
  return text + "</VTKFile>\n";
}

TEST(MeshReaders, GiveTheSameCloudFromEveryFormat) {
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.msh", gmsh_2},        {"b.msh", gmsh_4},     {"c.inp", abaqus},       {"d.vtu", vtu("ascii")},
      {"e.vtu", vtu("binary")}, {"f.vtu", vtu("raw")}, {"g.vtu", vtu("base64")}};
  for (const auto& [name, text] : files) {
    SCOPED_TRACE(name);
    const Points p = mesh_points(MPI_COMM_SELF, read_text(name, text), 0.1, [](int) { return 1.0; }, {});
    ASSERT_EQ(p.points.size(), 4u);
    EXPECT_EQ(p.dimension, 2);
    const bool has_names = !name.ends_with("vtu");
    EXPECT_EQ(p.faces, has_names ? (std::vector<std::string>{"surface", "left side", "8"})
                                 : (std::vector<std::string>{"surface", "7", "8"}));
    EXPECT_EQ(p.tags, (std::vector<std::string>{"", has_names ? "steel" : "9"}));
    // A rectangle 0.2 x 0.1 cut from its first corner: areas of 0.01 m^2, a third of one or of both at every corner.
    const double third = 0.01 / 3;
    const std::vector<double> volumes = {2 * third, third, 2 * third, third};
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(p.points[i].volume, volumes[i], 1e-16);
    EXPECT_NEAR(norm(p.points[3].x - Vec3{0, 0.1, 0}), 0, 1e-16);
    EXPECT_NEAR(norm(p.points[3].area - Vec3{-0.05, 0.1, 0}), 0, 1e-16);
    EXPECT_EQ(p.points[3].on_faces, 3u);
    EXPECT_EQ(p.points[1].on_faces, 5u);
    EXPECT_EQ(p.points[0].tag, 1);
  }
}

TEST(MeshReaders, TakeTheCornersOfElementsOfSecondOrder) {
  const Mesh mesh = read_text("a.inp", R"(*NODE
1, 0, 0
2, 1, 0
3, 0, 1
4, .5, 0
5, .5, .5
6, 0, .5
*ELEMENT, TYPE=CPS6
1, 1, 2, 3, 4, 5, 6
)");
  ASSERT_EQ(mesh.elements.size(), 1u);
  EXPECT_EQ(mesh.elements[0].shape, ElementShape::triangle);
  expect_words(mesh.notes.at(0), {"1 elements", "only the corners"});
}

TEST(MeshReaders, CallSidesByTheSmallestSetOrTheSurface) {
  const Mesh mesh = read_text("a.inp", R"(*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=C3D8R, ELSET=All
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=most
1, 2, 3, 4, 5, 6, 7
*NSET, NSET=Low
1, 2, 3, 4
*SURFACE, NAME=Front, TYPE=ELEMENT
all, S3
)");
  const Points p = mesh_points(MPI_COMM_SELF, mesh, 1, [](int) { return 1.0; }, {});
  EXPECT_EQ(p.faces, (std::vector<std::string>{"surface", "Front", "most", "Low"}));
  EXPECT_EQ(p.tags, (std::vector<std::string>{"", "All"}));
  double area[4] = {};
  for (const SurfacePiece& piece : p.facets) area[piece.face] += piece.area;
  EXPECT_NEAR(area[1], 1, 1e-15);  // y = 0
  EXPECT_NEAR(area[3], 1, 1e-15);  // z = 0
  // Of the other four, cut into triangles at their first node, node 8 is in 5 of 8.
  EXPECT_NEAR(area[0] + area[2], 4, 1e-15);
  EXPECT_GT(area[2], 1);
}

}  // namespace
}  // namespace calor
