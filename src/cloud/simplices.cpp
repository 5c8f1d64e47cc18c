#include "cloud/simplices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "cloud/cells.hpp"
#include "cloud/short_edges.hpp"

namespace calor {
namespace {

using Nodes = std::vector<std::int32_t>;

/// Of six times a tetrahedron, or twice a triangle.
double determinant(const std::vector<Vec3>& x, const std::array<std::int32_t, 4>& n, int dimension) {
  const Vec3 a = x[n[1]] - x[n[0]], b = x[n[2]] - x[n[0]];
  return dimension == 2 ? cross(a, b).z : dot(cross(a, b), x[n[3]] - x[n[0]]);
}

/// Cuts a plane polygon into triangles at its first node in the file.
void cut_polygon(const Nodes& polygon, const auto& use) {
  const std::size_t n = polygon.size(), first = std::ranges::min_element(polygon) - polygon.begin();
  for (std::size_t k = 1; k + 1 < n; ++k)
    use(Nodes{polygon[first], polygon[(first + k) % n], polygon[(first + k + 1) % n]});
}

/// Cuts an element into simplices: cones from its first node in the file over the sides that do not hold it. Then every
/// side is cut at its own first node, whichever element it belongs to. Simplices with a node twice are left out.
void cut_element(const MeshElement& e, const auto& use) {
  const int corners = corners_of(e.shape);
  const std::int32_t top = *std::min_element(e.node.begin(), e.node.begin() + corners);
  const auto cone = [&](const Nodes& base) {
    Nodes all = base;
    all.insert(all.begin(), top);
    Nodes sorted = all;
    std::ranges::sort(sorted);
    if (std::ranges::adjacent_find(sorted) == sorted.end()) use(all);
  };
  for (const std::vector<int>& side : sides_of(e.shape)) {
    Nodes base;
    for (const int corner : side) base.push_back(e.node[corner]);
    if (std::ranges::find(base, top) != base.end()) continue;
    if (base.size() > 2)
      cut_polygon(base, cone);
    else
      cone(base);
  }
}

/// Nodes that lie at one place become the first of them: meshes of several pieces hold those between them more than
/// once. `to`: of every node the one that stays; returns how many go. Only nodes that are `used` count.
std::int64_t merge_coincident(const std::vector<Vec3>& x, const std::vector<char>& used, Nodes& to) {
  const Bounds box = bounds_of(x);
  const double near = 1e-7 * norm(box.high - box.low);  // single precision has no more digits
  std::map<std::array<std::int64_t, 3>, Nodes> cells;   // of size `near`
  std::int64_t merged = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    to[i] = static_cast<std::int32_t>(i);
    if (!used[i]) continue;
    std::array<std::int64_t, 3> cell = {};
    for (int a = 0; a < 3; ++a) cell[a] = near > 0 ? std::llround((x[i][a] - box.low[a]) / near) : 0;
    for (int n = 0; n < 27 && to[i] == static_cast<std::int32_t>(i); ++n) {
      const auto found = cells.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
      if (found == cells.end()) continue;
      for (const std::int32_t j : found->second)
        if (norm(x[j] - x[i]) <= near) to[i] = j;
    }
    if (to[i] == static_cast<std::int32_t>(i))
      cells[cell].push_back(to[i]);
    else
      ++merged;
  }
  return merged;
}

/// Facets of simplices, by their nodes in ascending order.
struct FacetOfSimplex {
  std::array<std::int32_t, 3> key;
  std::int32_t simplex;
  int opposite;  ///< the node of the simplex that is not in it
};

std::array<std::int32_t, 3> key_of(Nodes nodes) {
  std::ranges::sort(nodes);
  std::array<std::int32_t, 3> key = {-1, -1, -1};
  std::ranges::copy(nodes, key.begin());
  return key;
}

class Cutter {
 public:
  Cutter(const Mesh& mesh, const SourceLocation& file) : mesh_(mesh), file_(file) {}

  Simplices cut(double unit) {
    for (const MeshElement& e : mesh_.elements) most_ = std::max(most_, dimension_of(e.shape));
    if (most_ < 2)
      throw Error(Fault::bad_case, file_, "the mesh has neither triangles nor tetrahedra, nor what is made of them",
                  "give it the elements of a plane body or of a body in space");
    out_.dimension = most_;
    take_nodes(unit);
    for (const MeshElement& e : mesh_.elements)
      if (dimension_of(e.shape) == most_) add(e);
    turn_flat_elements();
    find_surface();
    if (join_near_nodes()) find_surface();
    remark();
    return std::move(out_);
  }

 private:
  /// Keeps the nodes that elements of the body use.
  void take_nodes(double unit) {
    std::vector<char> used(mesh_.x.size(), 0);
    for (const MeshElement& e : mesh_.elements)
      for (int k = 0; dimension_of(e.shape) == most_ && k < corners_of(e.shape); ++k) used[e.node[k]] = 1;
    new_index_.resize(mesh_.x.size());
    merged_ = merge_coincident(mesh_.x, used, new_index_);
    for (std::size_t i = 0; i < mesh_.x.size(); ++i) {
      if (!used[i]) {
        new_index_[i] = -1;
      } else if (new_index_[i] == static_cast<std::int32_t>(i)) {
        new_index_[i] = static_cast<std::int32_t>(out_.x.size());
        out_.x.push_back(unit * mesh_.x[i]);
        out_.label.push_back(mesh_.label[i]);
      } else {
        new_index_[i] = new_index_[new_index_[i]];
      }
    }
    if (most_ == 3) return;
    const Bounds box = bounds_of(out_.x);
    if (box.high.z - box.low.z > 1e-6 * norm(box.high - box.low))
      throw Error(Fault::bad_case, file_, "the mesh is a surface in space, without volume",
                  "mesh the volume (gmsh -3), or give a plane mesh with one z");
    for (Vec3& x : out_.x) x.z = 0;
  }

  MeshElement renumbered(MeshElement e) const {
    for (int k = 0; k < corners_of(e.shape); ++k) e.node[k] = new_index_[e.node[k]];
    return e;
  }

  void add(const MeshElement& element) {
    const MeshElement e = renumbered(element);
    const std::size_t begin = out_.simplices.size();
    double size = 0, volume = 0;
    cut_element(e, [&](const Nodes& nodes) {
      Simplex s{.node = {}, .name = e.name};
      std::ranges::copy(nodes, s.node.begin());
      volume += determinant(out_.x, s.node, most_);
      out_.simplices.push_back(s);
    });
    for (int k = 1; k < corners_of(e.shape); ++k) size = std::max(size, norm(out_.x[e.node[k]] - out_.x[e.node[0]]));
    const bool is_flat = std::abs(volume) <= 1e-9 * std::pow(size, most_);
    bool is_folded = false;
    for (std::size_t s = begin; s < out_.simplices.size(); ++s) {
      out_.simplices[s].sign = is_flat ? 0 : volume < 0 ? -1 : 1;
      is_folded = is_folded || (!is_flat && out_.volume(out_.simplices[s]) < -1e-9 * std::pow(size, most_));
    }
    flat_ += is_flat, folded_ += is_folded;
    ++(volume < 0 ? inside_out_ : right_)[e.shape];
  }

  /// Flat elements hold no volume, but the elements on both sides are neighbours by their facets: they stay, turned as
  /// most others.
  void turn_flat_elements() {
    std::int64_t sum = 0;
    for (const Simplex& s : out_.simplices) sum += s.sign;
    for (Simplex& s : out_.simplices)
      if (s.sign == 0) s.sign = sum < 0 ? -1 : 1;
  }

  /// Short edges become nodes. Were there some?
  bool join_near_nodes() {
    const Nodes to = collapse_short_edges(out_, out_.surface);
    Nodes place(to.size(), -1);
    std::int32_t count = 0;
    for (std::size_t i = 0; i < to.size(); ++i) {
      if (to[i] != static_cast<std::int32_t>(i)) continue;
      out_.x[count] = out_.x[i], out_.label[count] = out_.label[i];
      place[i] = count++;
    }
    joined_ = static_cast<std::int64_t>(to.size()) - count;
    if (joined_ == 0) return false;
    out_.x.resize(count), out_.label.resize(count);
    for (std::int32_t& node : new_index_)
      if (node >= 0) node = place[to[node]];
    for (Simplex& s : out_.simplices)
      for (int k = 0; k <= most_; ++k) s.node[k] = place[s.node[k]];
    return true;
  }

  Nodes facet(const Simplex& s, int opposite) const {
    Nodes nodes;
    for (int k = 0; k <= most_; ++k)
      if (k != opposite) nodes.push_back(s.node[k]);
    return nodes;
  }

  void find_surface() {
    out_.surface.clear(), on_surface_.clear(), inside_.clear();
    std::vector<FacetOfSimplex> facets;
    facets.reserve((most_ + 1) * out_.simplices.size());
    for (std::size_t s = 0; s < out_.simplices.size(); ++s)
      for (int k = 0; k <= most_; ++k)
        facets.push_back({key_of(facet(out_.simplices[s], k)), static_cast<std::int32_t>(s), k});
    std::ranges::sort(facets, {}, [](const FacetOfSimplex& f) { return std::tie(f.key, f.simplex, f.opposite); });
    name_facets();
    for (std::size_t begin = 0, end = 0; begin < facets.size(); begin = end) {
      while (end < facets.size() && facets[end].key == facets[begin].key) ++end;
      if (end - begin > 2) refuse_overlap(facets[begin], end - begin);
      const auto name = names_.find(facets[begin].key);
      if (name != names_.end()) (end - begin == 1 ? on_surface_ : inside_)[name->second] += 1;
      if (end - begin == 1) add_facet(facets[begin]);
    }
  }

  [[noreturn]] void refuse_overlap(const FacetOfSimplex& f, std::size_t count) const {
    std::string nodes;
    for (int k = 0; k < most_; ++k) nodes += fmt::format("{}{}", k > 0 ? ", " : "", out_.label[f.key[k]]);
    throw Error(Fault::bad_case, file_, fmt::format("{} elements share the side between the nodes {}", count, nodes),
                "no more than two may: remove elements that are there twice");
  }

  /// By the elements of the surface.
  void name_facets() {
    names_.clear(), sets_.clear(), set_names_.clear();
    for (const MeshElement& element : mesh_.elements) {
      if (dimension_of(element.shape) != most_ - 1 || element.name == 0) continue;
      const MeshElement e = renumbered(element);
      const Nodes nodes(e.node.begin(), e.node.begin() + corners_of(e.shape));
      if (std::ranges::find(nodes, -1) != nodes.end()) continue;
      if (most_ == 2)
        names_[key_of(nodes)] = e.name;
      else
        cut_polygon(nodes, [&](const Nodes& triangle) { names_[key_of(triangle)] = e.name; });
    }
    for (const Mesh::NodeSet& set : mesh_.node_sets) {
      std::vector<char> in(out_.x.size(), 0);
      for (const std::int32_t node : set.nodes)
        if (new_index_[node] >= 0) in[new_index_[node]] = 1;
      if (std::ranges::find(in, 0) == in.end()) continue;  // a set of all nodes names nothing
      sets_.push_back(std::move(in));
      set_names_.push_back(set.name);
    }
  }

  void add_facet(const FacetOfSimplex& f) {
    const Simplex& s = out_.simplices[f.simplex];
    const Nodes nodes = facet(s, f.opposite);
    const Vec3 a = out_.x[nodes[1]] - out_.x[nodes[0]];
    // Outward for sides opposite to the nodes 0 and 2 of a simplex that is not inside out.
    Vec3 area = most_ == 2 ? Vec3{a.y, -a.x, 0} : 0.5 * cross(a, out_.x[nodes[2]] - out_.x[nodes[0]]);
    if ((f.opposite % 2 == 1) != (s.sign < 0)) area = -area;
    BoundaryFacet out{.node = {}, .area = area};
    std::ranges::copy(nodes, out.node.begin());
    if (const auto name = names_.find(f.key); name != names_.end()) {
      out.name = name->second;
    } else {
      for (std::size_t n = 0; n < sets_.size(); ++n)  // the largest first, so that smaller ones count
        if (std::ranges::all_of(nodes, [&](std::int32_t i) { return sets_[n][i] != 0; })) out.name = set_names_[n];
    }
    out_.surface.push_back(out);
  }

  void remark() {
    const auto note = [&](std::int64_t count, const std::string& what) {
      if (count > 0) out_.notes.push_back(fmt::format("{} {}", count, what));
    };
    note(merged_, "nodes of the mesh lie where others do; they count as one, and the elements around them as joined");
    note(joined_, "nodes of the mesh lie nearer to another one than 0.4 spacings; they count as one with it");
    note(flat_, "elements of the mesh are flat: they hold no volume");
    note(folded_, "elements of the mesh are folded: their volume is that of the parts, less what is folded");
    std::int64_t turned = 0;
    for (const auto& [shape, count] : inside_out_)
      if (right_.contains(shape)) turned += std::min(count, right_.at(shape));
    note(turned, "elements of the mesh are inside out compared with the others; they are turned");
    for (const auto& [name, count] : inside_)
      if (!on_surface_.contains(name))
        out_.notes.push_back(
            fmt::format("the group '{}' of the mesh lies inside the body and is no face", mesh_.names[name]));
  }

  const Mesh& mesh_;
  const SourceLocation& file_;
  Simplices out_;
  int most_ = 0;     // the dimension
  Nodes new_index_;  // of every node of the mesh; -1: not used
  std::int64_t merged_ = 0, joined_ = 0, flat_ = 0, folded_ = 0;
  std::map<ElementShape, std::int64_t> inside_out_, right_;
  std::map<std::array<std::int32_t, 3>, int> names_;
  std::vector<std::vector<char>> sets_;              // of nodes
  std::vector<int> set_names_;                       // of each
  std::map<int, std::int64_t> on_surface_, inside_;  // facets by their name
};

}  // namespace

double Simplices::volume(const Simplex& s) const {
  return s.sign * determinant(x, s.node, dimension) / (dimension == 2 ? 2 : 6);
}

Simplices make_simplices(const Mesh& mesh, double unit, const SourceLocation& file) {
  return Cutter(mesh, file).cut(unit);
}

}  // namespace calor
