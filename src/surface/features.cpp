#include "surface/features.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "surface/edges.hpp"

namespace calor {
namespace {

constexpr double smooth = 0.8660254037844387;  // cosine of 30 degrees
/// Splits smooth patches by faces, and numbers what results in the order of the first facets.
void number_patches(const Surface& surface, Features& out) {
  const std::vector<int> smooth_patch = smooth_patches(surface, std::acos(smooth));
  std::map<std::pair<int, int>, int> number;
  for (std::size_t f = 0; f < smooth_patch.size(); ++f) {
    const auto [found, is_new] = number.try_emplace({smooth_patch[f], surface.facets[f].face}, out.count);
    out.count += is_new;
    out.patch.push_back(found->second);
  }
}

/// A step of a line: an edge that is not smooth, or a segment in the plane.
struct Step {
  int a, b;
  std::vector<int> facets = {};
};

std::vector<Step> steps_of(const Surface& surface, const Features& features) {
  std::vector<Step> steps;
  if (surface.dimension == 2) {
    for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f)
      steps.push_back({surface.facets[f].vertex[0], surface.facets[f].vertex[1], {f}});
    return steps;
  }
  for_each_edge(sides_by_edge(surface), [&](std::span<const Side> sides) {
    const int f = sides.front().facet, g = sides.back().facet;
    const bool is_smooth = sides.size() == 2 && features.patch[f] == features.patch[g] &&
                           dot(features.normal[f], features.normal[g]) > smooth;
    if (is_smooth) return;
    Step step{sides[0].edge[0], sides[0].edge[1]};
    for (const Side& side : sides) step.facets.push_back(side.facet);
    steps.push_back(std::move(step));
  });
  return steps;
}

std::vector<int> patches_beside(const Features& features, const Step& step) {
  std::vector<int> beside;
  for (const int f : step.facets) beside.push_back(features.patch[f]);
  std::ranges::sort(beside);
  return beside;
}

/// Joins steps to lines, from corner to corner, then those that are closed.
class Tracer {
 public:
  Tracer(const Surface& surface, std::vector<Step> steps, Features& out)
      : surface_(surface), steps_(std::move(steps)), used_(steps_.size(), 0), out_(out) {
    for (int s = 0; s < static_cast<int>(steps_.size()); ++s)
      at_[steps_[s].a].push_back(s), at_[steps_[s].b].push_back(s);
  }

  void trace() {
    for (const auto& [vertex, steps] : at_) {
      if (!is_corner(vertex, steps)) continue;
      std::vector<int> facets;
      for (const int s : steps) facets.insert(facets.end(), steps_[s].facets.begin(), steps_[s].facets.end());
      out_.corners.push_back({vertex, std::move(facets)});
    }
    for (const auto& [vertex, steps] : at_)
      if (is_corner(vertex, steps))
        for (const int s : steps) follow(vertex, s);
    for (int s = 0; s < static_cast<int>(steps_.size()); ++s) follow(steps_[s].a, s);
  }

 private:
  bool is_corner(int vertex, const std::vector<int>& steps) const {
    if (steps.size() != 2) return true;
    const Step &s = steps_[steps[0]], &t = steps_[steps[1]];
    if (patches_beside(out_, s) != patches_beside(out_, t)) return true;
    const auto way = [&](const Step& step) {
      const Vec3 r = surface_.vertices[step.a == vertex ? step.b : step.a] - surface_.vertices[vertex];
      return (1 / norm(r)) * r;
    };
    return dot(way(s), way(t)) > -smooth;
  }

  void follow(int vertex, int s) {
    if (used_[s]) return;
    Features::Line line{.vertices = {vertex}, .facets = {}};
    for (;;) {
      used_[s] = 1;
      vertex = steps_[s].a == vertex ? steps_[s].b : steps_[s].a;
      line.vertices.push_back(vertex);
      line.facets.insert(line.facets.end(), steps_[s].facets.begin(), steps_[s].facets.end());
      const std::vector<int>& next = at_.at(vertex);
      if (is_corner(vertex, next)) break;
      s = used_[next[0]] ? next[1] : next[0];
      if (used_[s]) break;
    }
    out_.lines.push_back(std::move(line));
  }

  const Surface& surface_;
  std::vector<Step> steps_;
  std::vector<char> used_;
  std::map<int, std::vector<int>> at_;  // steps at every vertex
  Features& out_;
};

/// Adds the tips of cones: where a patch is smooth from facet to facet, but not all around a vertex.
void add_tips(const Surface& surface, Features& out) {
  constexpr double sharp = 0.5;  // cosine of the angle between two facets; 60 degrees
  std::vector<std::vector<int>> facets(surface.vertices.size());
  for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f)
    for (const std::int32_t v : surface.facets[f].vertex) facets[v].push_back(f);
  for (const auto& line : out.lines)
    for (const int v : line.vertices) facets[v].clear();  // has an edge, or is a corner already
  for (int v = 0; v < static_cast<int>(facets.size()); ++v) {
    const auto is_apart = [&](int f) {
      return std::ranges::any_of(facets[v], [&](int g) { return dot(out.normal[f], out.normal[g]) < sharp; });
    };
    if (std::ranges::any_of(facets[v], is_apart)) out.corners.push_back({v, facets[v]});
  }
}

}  // namespace

Features features_of(const Surface& surface) {
  Features out;
  if (surface.facets.empty()) return out;
  out.normal = facet_normals(surface);
  number_patches(surface, out);
  Tracer(surface, steps_of(surface, out), out).trace();
  if (surface.dimension == 3) add_tips(surface, out);
  return out;
}

}  // namespace calor
