#pragma once
// Meshes as other programs write them: nodes, elements of all dimensions, and names of sets of them. Every rank that
// reads one holds all of it.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/vec3.hpp"

namespace calor {

/// Corners are numbered as Gmsh and Abaqus do.
enum class ElementShape : std::uint8_t { line, triangle, quadrilateral, tetrahedron, pyramid, prism, hexahedron };
int corners_of(ElementShape shape);
int dimension_of(ElementShape shape);
/// The corners of every side, outwards for elements that are not inside out; of plane elements their edges.
const std::vector<std::vector<int>>& sides_of(ElementShape shape);

struct MeshElement {
  ElementShape shape = ElementShape::triangle;
  std::array<std::int32_t, 8> node = {};  ///< indices into Mesh::x, as many as the shape has corners
  int name = 0;                           ///< index into Mesh::names
};

struct Mesh {
  std::vector<Vec3> x;              ///< as in the file, in its unit
  std::vector<std::int64_t> label;  ///< number of every node in the file
  std::vector<MeshElement> elements;
  std::vector<std::string> names = {""};  ///< of groups of elements; "" for those without
  struct NodeSet {
    int name;  ///< index into names
    std::vector<std::int32_t> nodes;
  };
  std::vector<NodeSet> node_sets;  ///< the largest first: of several that hold a facet the last one names it
  std::vector<std::string> notes;  ///< what was left out

  /// Index of a name, which is added where there is none.
  int name_index(const std::string& name);
};

/// Gmsh 2.2 and 4.1, ASCII. The names are physical groups. Throws Error.
Mesh read_gmsh(const std::string& path, const SourceLocation& named = {});
/// Abaqus and CalculiX, one flat part. The names are sets of elements, of several that hold an element the smallest
/// (of equal ones the later), and surfaces of elements, which become elements. Throws Error.
Mesh read_abaqus(const std::string& path, const SourceLocation& named = {});
/// VTK's unstructured grids in XML, not compressed. The names are numbers in an array of the cells. Throws Error.
Mesh read_vtu(const std::string& path, const SourceLocation& named = {});
/// One of these, by the ending of the name. Throws Error.
Mesh read_mesh(const std::string& path, const SourceLocation& named = {});

}  // namespace calor
