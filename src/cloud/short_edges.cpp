#include "cloud/short_edges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

namespace calor {
namespace {

struct Edge {
  std::int32_t a, b;
  double length;
};

class Collapser {
 public:
  Collapser(Simplices& body, std::span<const BoundaryFacet> surface)
      : body_(body), x_(body.x), facets_(surface.begin(), surface.end()), to_(x_.size()) {
    std::iota(to_.begin(), to_.end(), 0);
  }

  std::vector<std::int32_t> run() {
    constexpr int most_passes = 10;  // every one lets edges of the next be short
    for (int pass = 0; pass < most_passes; ++pass) {
      const std::vector<Edge> edges = short_edges();
      if (edges.empty()) break;
      connect();
      std::int64_t gone = 0;
      for (const auto& [a, b, length] : edges) {
        if (to_[a] != a || to_[b] != b) continue;
        // The one that lies on fewer faces goes; of two that are alike the later one, if it can.
        const bool a_goes_first = rank_[a] < rank_[b];
        const auto [first, second] = a_goes_first ? std::pair(a, b) : std::pair(b, a);
        gone += collapse(first, second) || (rank_[a] == rank_[b] && collapse(second, first));
      }
      std::erase_if(body_.simplices, [](const Simplex& s) { return s.node[0] < 0; });
      std::erase_if(facets_, [](const BoundaryFacet& f) { return f.node[0] < 0; });
      if (gone == 0) break;
    }
    for (std::int32_t& to : to_)
      while (to_[to] != to) to = to_[to];
    return to_;
  }

 private:
  /// Those below 0.4 of the spacing at their ends, the shortest first.
  std::vector<Edge> short_edges() const {
    std::vector<Edge> edges;
    for (const Simplex& s : body_.simplices)
      for (int k = 0; k <= body_.dimension; ++k)
        for (int l = 0; l < k; ++l) {
          const auto [a, b] = std::minmax(s.node[k], s.node[l]);
          edges.push_back({a, b, norm(x_[b] - x_[a])});
        }
    const auto ends = [](const Edge& e) { return std::pair(e.a, e.b); };
    std::ranges::sort(edges, {}, ends);
    const auto same = [&](const Edge& e, const Edge& f) { return ends(e) == ends(f); };
    edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
    // In meshes of good simplices the mean edge of a node is 1.2 spacings long, as some of them are diagonals.
    std::vector<double> sum(x_.size()), count(x_.size());
    for (const auto& [a, b, length] : edges)
      for (const std::int32_t i : {a, b}) sum[i] += length, count[i] += 1;
    constexpr double near = 0.4 / 1.2;
    std::erase_if(
        edges, [&](const Edge& e) { return e.length >= near * 0.5 * (sum[e.a] / count[e.a] + sum[e.b] / count[e.b]); });
    std::ranges::stable_sort(edges, {}, &Edge::length);
    return edges;
  }

  void connect() {
    simplices_of_.assign(x_.size(), {});
    facets_of_.assign(x_.size(), {});
    std::vector<std::set<int>> names(x_.size());
    for (std::size_t s = 0; s < body_.simplices.size(); ++s)
      for (int k = 0; k <= body_.dimension; ++k) {
        simplices_of_[body_.simplices[s].node[k]].push_back(static_cast<std::int32_t>(s));
        names[body_.simplices[s].node[k]].insert(body_.simplices[s].name);
      }
    for (std::size_t f = 0; f < facets_.size(); ++f)
      for (int k = 0; k < body_.dimension; ++k) facets_of_[facets_[f].node[k]].push_back(static_cast<std::int32_t>(f));
    rank_.assign(x_.size(), 0);
    for (std::size_t i = 0; i < x_.size(); ++i) rank_[i] = directions_at(i) + static_cast<int>(names[i].size()) - 1;
  }

  /// How many directions the facets of a node have: 0 inside, 1 on smooth faces, 2 on edges, more at corners.
  int directions_at(std::size_t i) const {
    std::vector<Vec3> normals;
    for (const std::int32_t f : facets_of_[i]) {
      const Vec3 n = (1 / norm(facets_[f].area)) * facets_[f].area;
      if (std::ranges::none_of(normals, [&](const Vec3& m) { return dot(m, n) > cos_smooth; })) normals.push_back(n);
    }
    return static_cast<int>(normals.size());
  }

  static bool has(const auto& element, int count, std::int32_t node) {
    return std::find(element.node.begin(), element.node.begin() + count, node) != element.node.begin() + count;
  }

  /// Is the edge between two nodes all that joins them, and does it lie on the surface if both do?
  bool is_free(std::int32_t from, std::int32_t to) const {
    const int D = body_.dimension;
    std::set<std::int32_t> around_from, around_to, shared;
    for (const std::int32_t s : simplices_of_[from]) {
      const Simplex& simplex = body_.simplices[s];
      auto& nodes = has(simplex, D + 1, to) ? shared : around_from;
      nodes.insert(simplex.node.begin(), simplex.node.begin() + D + 1);
    }
    if (shared.empty()) return false;
    for (const std::int32_t s : simplices_of_[to])
      around_to.insert(body_.simplices[s].node.begin(), body_.simplices[s].node.begin() + D + 1);
    for (const std::int32_t node : around_from)
      if (around_to.contains(node) && !shared.contains(node)) return false;
    if (facets_of_[from].empty()) return true;
    return std::ranges::any_of(facets_of_[from], [&](std::int32_t f) { return has(facets_[f], D, to); });
  }

  bool keeps_shape(std::int32_t from, std::int32_t to) const {
    const int D = body_.dimension;
    for (const std::int32_t s : simplices_of_[from]) {
      Simplex simplex = body_.simplices[s];
      if (has(simplex, D + 1, to)) continue;
      const double before = body_.volume(simplex);
      std::replace(simplex.node.begin(), simplex.node.end(), from, to);
      constexpr double least_left = 0.1;
      if (!(body_.volume(simplex) > least_left * std::abs(before))) return false;
    }
    for (const std::int32_t f : facets_of_[from]) {
      BoundaryFacet facet = facets_[f];
      if (has(facet, D, to)) continue;
      std::replace(facet.node.begin(), facet.node.end(), from, to);
      const Vec3 area = turned_like(facet);
      if (!(dot(area, facet.area) > cos_smooth * norm(area) * norm(facet.area))) return false;
    }
    return true;
  }

  /// The area of a facet whose nodes have moved by little, outwards as before.
  Vec3 turned_like(const BoundaryFacet& facet) const {
    const Vec3 a = x_[facet.node[1]] - x_[facet.node[0]];
    const Vec3 area = body_.dimension == 2 ? Vec3{a.y, -a.x, 0} : 0.5 * cross(a, x_[facet.node[2]] - x_[facet.node[0]]);
    return dot(area, facet.area) < 0 ? -area : area;
  }

  bool collapse(std::int32_t from, std::int32_t to) {
    const int D = body_.dimension;
    if (rank_[from] >= D || rank_[from] > rank_[to] || !is_free(from, to) || !keeps_shape(from, to)) return false;
    for (const std::int32_t s : simplices_of_[from]) {
      Simplex& simplex = body_.simplices[s];
      if (has(simplex, D + 1, to)) {
        for (int k = 0; k <= D; ++k)
          if (simplex.node[k] != from) std::erase(simplices_of_[simplex.node[k]], s);
        simplex.node.fill(-1);
      } else {
        std::replace(simplex.node.begin(), simplex.node.end(), from, to);
        simplices_of_[to].push_back(s);
      }
    }
    for (const std::int32_t f : facets_of_[from]) {
      BoundaryFacet& facet = facets_[f];
      if (has(facet, D, to)) {
        for (int k = 0; k < D; ++k)
          if (facet.node[k] != from) std::erase(facets_of_[facet.node[k]], f);
        facet.node.fill(-1);
      } else {
        std::replace(facet.node.begin(), facet.node.end(), from, to);
        facet.area = turned_like(facet);
        facets_of_[to].push_back(f);
      }
    }
    simplices_of_[from].clear(), facets_of_[from].clear();
    to_[from] = to;
    return true;
  }

  static constexpr double cos_smooth = 0.866;  // of 30 degrees

  Simplices& body_;
  const std::vector<Vec3>& x_;
  std::vector<BoundaryFacet> facets_;
  std::vector<std::int32_t> to_;
  std::vector<std::vector<std::int32_t>> simplices_of_, facets_of_;  // of every node
  std::vector<int> rank_;  // of every node: directions of the surface, and one more for every further group of elements
};

}  // namespace

std::vector<std::int32_t> collapse_short_edges(Simplices& body, std::span<const BoundaryFacet> surface) {
  return Collapser(body, surface).run();
}

}  // namespace calor
