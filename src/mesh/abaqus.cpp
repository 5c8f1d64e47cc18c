// Input files of Abaqus and CalculiX (CalculiX manual, "Input deck format"): nodes, elements, their sets and surfaces.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <unordered_map>

#include "mesh/mesh.hpp"
#include "mesh/text_file.hpp"

namespace calor {
namespace {

struct AbaqusType {
  ElementShape shape;
  int nodes;
};

/// By the name: its family, and the number of nodes that follows it (C3D8R, DC2D4, CPS3, CAX4, S4R, T3D2, ...).
std::optional<AbaqusType> abaqus_type(const std::string& name) {
  using enum ElementShape;
  struct Family {
    std::string_view start;
    int dimension;
  };
  constexpr Family families[] = {{"C3D", 3},  {"DC3D", 3}, {"CPS", 2},   {"CPE", 2}, {"CAX", 2},
                                 {"DC2D", 2}, {"M3D", 2},  {"SFM3D", 2}, {"DS", 2},  {"S", 2},
                                 {"T2D", 1},  {"T3D", 1},  {"DC1D", 1},  {"B2", 1},  {"B3", 1}};
  for (const auto& [start, dimension] : families) {
    if (!name.starts_with(start) || name.size() == start.size() || !std::isdigit(name[start.size()])) continue;
    const int nodes = std::stoi(name.substr(start.size(), 2));
    if (dimension == 1) return AbaqusType{line, nodes > 2 ? 3 : 2};
    static const std::map<std::pair<int, int>, ElementShape> shapes = {
        {{2, 3}, triangle},    {{2, 6}, triangle},     {{2, 4}, quadrilateral}, {{2, 8}, quadrilateral},
        {{3, 4}, tetrahedron}, {{3, 10}, tetrahedron}, {{3, 5}, pyramid},       {{3, 13}, pyramid},
        {{3, 6}, prism},       {{3, 15}, prism},       {{3, 8}, hexahedron},    {{3, 20}, hexahedron}};
    const auto found = shapes.find({dimension, nodes});
    if (found == shapes.end()) return std::nullopt;
    return AbaqusType{found->second, nodes};
  }
  return std::nullopt;
}

class AbaqusReader {
 public:
  AbaqusReader(const std::string& path, const SourceLocation& named) : file_(path, named) {}

  Mesh read() {
    while (!file_.at_end()) {
      const std::string_view line = file_.line();
      if (line.starts_with("**") || line.empty()) continue;
      if (line.starts_with('*')) {
        begin(line);
        continue;
      }
      const auto cells = split_at_commas(line);
      if (keyword_ == "*NODE") add_node(cells);
      if (keyword_ == "*ELEMENT") add_element(cells);
      if (keyword_ == "*ELSET") add_to_set(cells, element_sets_[set_]);
      if (keyword_ == "*NSET") add_to_set(cells, node_sets_[set_]);
      if (keyword_ == "*SURFACE") add_to_surface(cells);
      if (keyword_ == "*INSTANCE")
        file_.refuse("an instance that is moved", "write a flat file: one part, in the place where it belongs");
    }
    if (mesh_.x.empty()) file_.refuse("the mesh has no nodes", "give it *NODE and *ELEMENT");
    name_elements();
    add_surfaces();
    name_nodes();
    if (second_order_ > 0)
      mesh_.notes.push_back(fmt::format("of {} elements of higher order only the corners count", second_order_));
    return std::move(mesh_);
  }

 private:
  struct Set {
    std::string name;   ///< as first written
    std::size_t place;  ///< among the sets of its kind, in the order of the file
    std::vector<std::int64_t> labels = {};
  };
  using Sets = std::map<std::string, Set>;  // by upper case, as names are not told apart by it
  struct Side {
    std::string_view element;  ///< its number, or the name of a set
    int number;
  };

  std::string parameter(const std::vector<std::string_view>& cells, const std::string& key) const {
    for (const std::string_view cell : cells) {
      const std::size_t equals = cell.find('=');
      if (equals == cell.npos || upper(trimmed(cell.substr(0, equals))) != key) continue;
      std::string_view value = trimmed(cell.substr(equals + 1));
      if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
      return std::string(value);
    }
    return {};
  }
  static std::string add(Sets& sets, const std::string& name) {
    std::string key = upper(name);
    sets.try_emplace(key, Set{name, sets.size()});
    return key;
  }

  void begin(std::string_view line) {
    const auto cells = split_at_commas(line);
    keyword_ = upper(cells[0]);
    is_range_ = std::ranges::any_of(cells, [](std::string_view c) { return upper(c) == "GENERATE"; });
    const auto given = [&](const char* key) { return parameter(cells, key); };
    if (keyword_ == "*INCLUDE") file_.refuse("an *INCLUDE", "put everything into one file");
    if (keyword_ == "*ELEMENT") {
      const std::string type = upper(given("TYPE"));
      const auto known = abaqus_type(type);
      if (!known)
        file_.refuse(
            fmt::format("elements of type '{}' are not known", type),
            "take solids of three dimensions (C3D4, C3D6, C3D8, DC3D4, ...) or plane ones (CPS3, S4, DC2D3, ...)");
      type_ = *known;
      element_.reset();
    }
    set_ = {};
    if (keyword_ == "*ELEMENT" && !given("ELSET").empty()) set_ = add(element_sets_, given("ELSET"));
    if (keyword_ == "*NODE" && !given("NSET").empty()) set_ = add(node_sets_, given("NSET"));
    if (keyword_ == "*ELSET" || keyword_ == "*NSET") {
      const std::string name = given(keyword_ == "*ELSET" ? "ELSET" : "NSET");
      if (name.empty()) file_.refuse(fmt::format("{} without a name", keyword_), "name the set");
      set_ = add(keyword_ == "*ELSET" ? element_sets_ : node_sets_, name);
    }
    if (keyword_ == "*SURFACE") {
      const std::string type = upper(given("TYPE"));
      if (!type.empty() && type != "ELEMENT") keyword_ = "*SURFACE of nodes";
      set_ = given("NAME");
    }
  }

  void add_node(const std::vector<std::string_view>& cells) {
    if (cells.size() < 3) file_.refuse("a node without a place", "write number, x, y and z");
    const std::int64_t label = file_.to_integer(cells[0]);
    if (!index_.emplace(label, static_cast<std::int32_t>(mesh_.x.size())).second)
      file_.refuse(fmt::format("there are two nodes {}", label), "write a flat file: one part, every number once");
    Vec3 x;
    for (int a = 0; a < 3; ++a)
      if (cells.size() > static_cast<std::size_t>(a) + 1 && !cells[a + 1].empty()) x[a] = file_.to_number(cells[a + 1]);
    mesh_.x.push_back(x);
    mesh_.label.push_back(label);
    if (!set_.empty()) node_sets_[set_].labels.push_back(label);
  }

  /// The nodes of an element may go on in the next lines.
  void add_element(const std::vector<std::string_view>& cells) {
    std::size_t c = 0;
    if (!element_) {
      const std::int64_t label = file_.to_integer(cells[c++]);
      if (!element_index_.emplace(label, mesh_.elements.size()).second)
        file_.refuse(fmt::format("there are two elements {}", label), "write a flat file: one part, every number once");
      if (!set_.empty()) element_sets_[set_].labels.push_back(label);
      mesh_.elements.push_back({.shape = type_.shape});
      element_ = 0;
    }
    for (; c < cells.size(); ++c) {
      const std::int64_t label = file_.to_integer(cells[c]);
      const int k = (*element_)++;
      if (k >= corners_of(type_.shape)) continue;
      const auto found = index_.find(label);
      if (found == index_.end())
        file_.refuse_at(cells[c], fmt::format("there is no node {}", label), "add it to *NODE");
      mesh_.elements.back().node[k] = found->second;
    }
    if (*element_ < type_.nodes) return;
    if (*element_ > type_.nodes)
      file_.refuse(fmt::format("the element has {} nodes, its type has {}", *element_, type_.nodes), "give it as many");
    second_order_ += type_.nodes > corners_of(type_.shape);
    element_.reset();
  }

  static bool is_number(std::string_view cell) {
    return !cell.empty() && std::isdigit(static_cast<unsigned char>(cell.front()));
  }

  void add_to_set(const std::vector<std::string_view>& cells, Set& set) {
    if (is_range_) {
      if (cells.size() < 2) file_.refuse("GENERATE needs a first and a last number", "write first, last, step");
      const std::int64_t step = cells.size() > 2 ? file_.to_integer(cells[2]) : 1;
      const std::int64_t first = file_.to_integer(cells[0]), last = file_.to_integer(cells[1]);
      if (step < 1 || (last - first) / step > static_cast<std::int64_t>(file_.text().size()))
        file_.refuse("a range that this file cannot hold", "write first, last, step");
      for (std::int64_t label = first; label <= last; label += step) set.labels.push_back(label);
      return;
    }
    const Sets& sets = keyword_ == "*ELSET" ? element_sets_ : node_sets_;
    for (const std::string_view cell : cells) {
      if (is_number(cell)) {
        set.labels.push_back(file_.to_integer(cell));
        continue;
      }
      const auto other = sets.find(upper(cell));
      if (other == sets.end())
        file_.refuse_at(cell, fmt::format("there is no set '{}' before this one", cell), "name one");
      const std::vector<std::int64_t> labels = other->second.labels;
      set.labels.insert(set.labels.end(), labels.begin(), labels.end());
    }
  }

  void add_to_surface(const std::vector<std::string_view>& cells) {
    if (cells.size() < 2) file_.refuse("a side of a surface without its number", "write element or set, S1 (S2, ...)");
    const std::string side = upper(cells[1]);
    if (side.size() < 2 || side[0] != 'S' || !std::isdigit(static_cast<unsigned char>(side[1]))) {
      file_.refuse_at(cells[1], fmt::format("'{}' is no side of an element that calor knows", cells[1]),
                      "write S1, S2, ...");
    }
    surfaces_[set_].push_back({cells[0], static_cast<int>(file_.to_integer(cells[1].substr(1)))});
  }

  /// Sets by size, the largest first, so that smaller ones count; of equal ones the later, as programs that make meshes
  /// write their own sets with the elements and those of their users after them.
  static std::vector<const Set*> largest_first(const Sets& sets) {
    std::vector<const Set*> order;
    for (const auto& [key, set] : sets) order.push_back(&set);
    std::ranges::sort(order, {}, &Set::place);
    std::ranges::stable_sort(order, std::greater(), [](const Set* s) { return s->labels.size(); });
    return order;
  }

  void name_elements() {
    for (const Set* set : largest_first(element_sets_)) {
      const int name = mesh_.name_index(set->name);
      for (const std::int64_t label : set->labels)
        if (const auto found = element_index_.find(label); found != element_index_.end())
          mesh_.elements[found->second].name = name;
    }
  }

  void name_nodes() {
    for (const Set* set : largest_first(node_sets_)) {
      Mesh::NodeSet out{mesh_.name_index(set->name), {}};
      for (const std::int64_t label : set->labels)
        if (const auto found = index_.find(label); found != index_.end()) out.nodes.push_back(found->second);
      mesh_.node_sets.push_back(std::move(out));
    }
  }

  void add_side(const std::string& surface, std::size_t element, int number) {
    const MeshElement e = mesh_.elements[element];
    if (number < 1 || number > static_cast<int>(sides_of(e.shape).size()))
      throw Error(Fault::bad_case, SourceLocation{.file = file_.path()},
                  fmt::format("surface '{}' has a side S{} that its element has not", surface, number), "correct it");
    const std::vector<int>& corners = sides_of(e.shape)[number - 1];
    using enum ElementShape;
    MeshElement out{.shape = corners.size() == 2 ? line : corners.size() == 3 ? triangle : quadrilateral};
    for (std::size_t k = 0; k < corners.size(); ++k) out.node[k] = e.node[corners[k]];
    out.name = mesh_.name_index(surface);
    mesh_.elements.push_back(out);
  }

  void add_surfaces() {
    for (const auto& [name, sides] : surfaces_) {
      for (const auto& [element, number] : sides) {
        const auto set = element_sets_.find(upper(element));
        std::vector<std::int64_t> labels;
        if (set != element_sets_.end())
          labels = set->second.labels;
        else
          labels.push_back(file_.to_integer(element));
        for (const std::int64_t label : labels)
          if (const auto found = element_index_.find(label); found != element_index_.end())
            add_side(name, found->second, number);
      }
    }
  }

  TextFile file_;
  Mesh mesh_;
  std::string keyword_, set_;  // of the current block; the key of the set that it fills
  bool is_range_ = false;
  AbaqusType type_ = {};
  std::optional<int> element_;  // nodes so far of an element that goes on in the next line
  std::int64_t second_order_ = 0;
  Sets element_sets_, node_sets_;
  std::map<std::string, std::vector<Side>> surfaces_;
  std::unordered_map<std::int64_t, std::int32_t> index_;
  std::unordered_map<std::int64_t, std::size_t> element_index_;
};

}  // namespace

Mesh read_abaqus(const std::string& path, const SourceLocation& named) { return AbaqusReader(path, named).read(); }

}  // namespace calor
