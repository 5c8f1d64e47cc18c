#include "mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace calor {

int corners_of(ElementShape shape) {
  constexpr int corners[] = {2, 3, 4, 4, 5, 6, 8};
  return corners[static_cast<int>(shape)];
}

int dimension_of(ElementShape shape) {
  return shape == ElementShape::line ? 1 : shape <= ElementShape::quadrilateral ? 2 : 3;
}

const std::vector<std::vector<int>>& sides_of(ElementShape shape) {
  static const std::vector<std::vector<int>> sides[] = {
      {{0}, {1}},
      {{0, 1}, {1, 2}, {2, 0}},
      {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
      {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}},
      {{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}},
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  return sides[static_cast<int>(shape)];
}

int Mesh::name_index(const std::string& name) {
  const auto found = std::ranges::find(names, name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  names.push_back(name);
  return static_cast<int>(names.size()) - 1;
}

Mesh read_mesh(const std::string& path, const SourceLocation& named) {
  if (path.ends_with(".msh")) return read_gmsh(path, named);
  if (path.ends_with(".inp")) return read_abaqus(path, named);
  if (path.ends_with(".vtu")) return read_vtu(path, named);
  throw Error(Fault::bad_case, named, fmt::format("the file \"{}\" is no mesh that calor reads", path),
              "give a file .msh (Gmsh 2.2 or 4.1, ASCII), .inp (Abaqus, CalculiX) or .vtu (VTK)");
}

}  // namespace calor
