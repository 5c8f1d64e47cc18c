// Gmsh's format MSH, versions 2.2 and 4.1 in ASCII (Gmsh reference manual, "File formats").
#include <fmt/format.h>

#include <cstdlib>
#include <map>
#include <unordered_map>

#include "mesh/mesh.hpp"
#include "mesh/text_file.hpp"

namespace calor {
namespace {

constexpr const char* cure_by_gmsh = "write it again: gmsh OLD.msh -save -format msh41 -bin 0 -o NEW.msh";

/// What Gmsh's type number of an element means.
struct GmshType {
  ElementShape shape;
  int nodes;
};
const std::map<std::int64_t, GmshType>& gmsh_types() {
  using enum ElementShape;
  static const std::map<std::int64_t, GmshType> types = {
      {1, {line, 2}},       {2, {triangle, 3}},       {3, {quadrilateral, 4}},  {4, {tetrahedron, 4}},
      {5, {hexahedron, 8}}, {6, {prism, 6}},          {7, {pyramid, 5}},        {8, {line, 3}},
      {9, {triangle, 6}},   {10, {quadrilateral, 9}}, {11, {tetrahedron, 10}},  {12, {hexahedron, 27}},
      {13, {prism, 18}},    {14, {pyramid, 14}},      {16, {quadrilateral, 8}}, {17, {hexahedron, 20}},
      {18, {prism, 15}},    {19, {pyramid, 13}}};
  return types;
}
constexpr std::int64_t single_point = 15;

class GmshReader {
 public:
  GmshReader(const std::string& path, const SourceLocation& named) : file_(path, named) {}

  Mesh read() {
    if (file_.word() != "$MeshFormat")
      file_.refuse("this is no mesh of Gmsh: it does not begin with $MeshFormat", cure_by_gmsh);
    const std::string_view version = file_.word();
    is_4_ = version == "4.1";
    if (!is_4_ && version != "2.2" && version != "2")
      file_.refuse(fmt::format("the format is {}, not 2.2 or 4.1", version), cure_by_gmsh);
    if (file_.integer() != 0) file_.refuse("the mesh is binary", cure_by_gmsh);
    file_.line();
    while (!file_.at_end()) {
      const std::string_view section = file_.line();
      if (section == "$PhysicalNames") read_names();
      if (section == "$Entities") read_entities();
      if (section == "$PartitionedEntities") file_.refuse("the mesh is partitioned", "write it without partitions");
      if (section == "$Nodes") is_4_ ? read_nodes_4() : read_nodes_2();
      if (section == "$Elements") is_4_ ? read_elements_4() : read_elements_2();
    }
    if (mesh_.x.empty()) file_.refuse("the mesh has no nodes", "write it again: it is not complete");
    if (second_order_ > 0)
      mesh_.notes.push_back(fmt::format("of {} elements of higher order only the corners count", second_order_));
    return std::move(mesh_);
  }

 private:
  void read_names() {
    for (std::int64_t n = file_.count(); n > 0; --n) {
      const std::int64_t dimension = file_.integer(), number = file_.integer();
      std::string_view name = file_.line();
      if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
      physical_[{dimension, number}] = name;
    }
  }

  /// The physical group of every entity: the first where it is in several.
  void read_entities() {
    std::int64_t count[4] = {};
    for (auto& c : count) c = file_.count();
    for (int dimension = 0; dimension < 4; ++dimension) {
      for (std::int64_t n = 0; n < count[dimension]; ++n) {
        const std::int64_t tag = file_.integer();
        for (int k = dimension == 0 ? 3 : 6; k > 0; --k) file_.word();
        const std::int64_t groups = file_.count();
        for (std::int64_t g = 0; g < groups; ++g) {
          const std::int64_t group = file_.integer();
          if (g == 0) group_of_[{dimension, tag}] = std::abs(group);  // negative: turned over
        }
        for (std::int64_t b = dimension == 0 ? 0 : file_.count(); b > 0; --b) file_.word();
      }
    }
  }

  void add_node(std::int64_t label, const Vec3& x) {
    if (!index_.emplace(label, static_cast<std::int32_t>(mesh_.x.size())).second)
      file_.refuse(fmt::format("there are two nodes {}", label), "number the nodes anew");
    mesh_.label.push_back(label);
    mesh_.x.push_back(x);
  }
  Vec3 place() {
    const double x = file_.number(), y = file_.number();
    return {x, y, file_.number()};
  }

  void read_nodes_2() {
    for (std::int64_t n = file_.count(); n > 0; --n) {
      const std::int64_t label = file_.integer();
      add_node(label, place());
    }
  }

  void read_nodes_4() {
    const std::int64_t blocks = file_.count();
    for (int k = 0; k < 3; ++k) file_.word();
    for (std::int64_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = file_.integer();
      file_.word();
      const bool is_parametric = file_.integer() != 0;
      std::vector<std::int64_t> labels(file_.count());
      for (auto& label : labels) label = file_.integer();
      for (const std::int64_t label : labels) {
        add_node(label, place());
        for (std::int64_t k = is_parametric ? dimension : 0; k > 0; --k) file_.word();
      }
    }
  }

  /// A group without a name is called by its number; 0 is none.
  int name_of(int dimension, std::int64_t group) {
    if (group == 0) return 0;
    const auto found = physical_.find({dimension, group});
    return mesh_.name_index(found == physical_.end() ? std::to_string(group) : found->second);
  }

  const GmshType* known(std::int64_t type) const {
    if (type == single_point) return nullptr;
    const auto found = gmsh_types().find(type);
    if (found == gmsh_types().end())
      file_.refuse(fmt::format("elements of type {} are not known", type),
                   "make a mesh of first or second order: gmsh -order 1");
    return &found->second;
  }

  void read_element(const GmshType* type, int name) {
    MeshElement e;
    const int nodes = type ? type->nodes : 1;
    if (type) e.shape = type->shape;
    e.name = name;
    for (int k = 0; k < nodes; ++k) {
      const std::int64_t label = file_.integer();
      if (!type || k >= corners_of(type->shape)) continue;
      const auto found = index_.find(label);
      if (found == index_.end())
        file_.refuse(fmt::format("there is no node {}", label), "write it again: it is not complete");
      e.node[k] = found->second;
    }
    if (!type) return;
    second_order_ += nodes > corners_of(type->shape);
    mesh_.elements.push_back(e);
  }

  void read_elements_2() {
    for (std::int64_t n = file_.count(); n > 0; --n) {
      file_.word();
      const GmshType* type = known(file_.integer());
      std::int64_t group = 0;
      for (std::int64_t t = 0, tags = file_.count(); t < tags; ++t) {
        const std::int64_t tag = file_.integer();
        if (t == 0) group = tag;
      }
      read_element(type, type ? name_of(dimension_of(type->shape), group) : 0);
    }
  }

  void read_elements_4() {
    const std::int64_t blocks = file_.count();
    for (int k = 0; k < 3; ++k) file_.word();
    for (std::int64_t b = 0; b < blocks; ++b) {
      const auto dimension = static_cast<int>(file_.integer());
      const std::int64_t entity = file_.integer();
      const GmshType* type = known(file_.integer());
      const auto group = group_of_.find({dimension, entity});
      const int name = group == group_of_.end() ? 0 : name_of(dimension, group->second);
      for (std::int64_t n = file_.count(); n > 0; --n) {
        file_.word();
        read_element(type, name);
      }
    }
  }

  TextFile file_;
  Mesh mesh_;
  bool is_4_ = false;
  std::int64_t second_order_ = 0;
  std::map<std::pair<std::int64_t, std::int64_t>, std::string> physical_;   // by dimension and number
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> group_of_;  // by dimension and tag of the entity
  std::unordered_map<std::int64_t, std::int32_t> index_;                    // by the number of the node
};

}  // namespace

Mesh read_gmsh(const std::string& path, const SourceLocation& named) { return GmshReader(path, named).read(); }

}  // namespace calor
