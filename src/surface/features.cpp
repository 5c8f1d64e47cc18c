#include "surface/smooth_patches.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace calor {
namespace {

constexpr double smooth = 0.8660254037844387;  // cosine of 30 degrees
/// Height of a triangle over the size of the surface below which its normal is made of rounding: coordinates in files
/// have seven digits.
constexpr double sliver = 2e-5;

/// An edge of two triangles, or a vertex of two segments.
struct Joint {
  int a, b;  ///< vertices, a < b; in the plane a == b
  int facet[2];
};

std::vector<Joint> joints_of(const Surface& surface) {
  struct Half {
    int a, b, facet;
  };
  std::vector<Half> halves;
  for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f) {
    const auto& v = surface.facets[f].vertex;
    for (int n = 0; n < surface.dimension; ++n) {
      const auto [a, b] = surface.dimension == 2 ? std::minmax(v[n], v[n]) : std::minmax(v[n], v[(n + 1) % 3]);
      halves.push_back({a, b, f});
    }
  }
  std::ranges::sort(halves, {}, [](const Half& h) { return std::pair(h.a, h.b); });
  std::vector<Joint> joints;
  for (std::size_t n = 0; n + 1 < halves.size(); n += 2)
    joints.push_back({halves[n].a, halves[n].b, {halves[n].facet, halves[n + 1].facet}});
  return joints;
}

double size_of(const Surface& surface) {
  Vec3 low = surface.vertices[0], high = low;
  for (const Vec3& x : surface.vertices)
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  return norm(high - low);
}

double length(const Surface& surface, const Joint& joint) {
  return norm(surface.vertices[joint.b] - surface.vertices[joint.a]);
}

std::vector<Vec3> normals_of(const Surface& surface, const std::vector<Joint>& joints) {
  const int count = static_cast<int>(surface.facets.size());
  std::vector<Vec3> normal(count);
  std::vector<double> longest(count), height(count);
  std::vector<int> across(count, -1);
  for (const Joint& joint : joints)
    for (int side : {0, 1})
      if (const int f = joint.facet[side]; length(surface, joint) > longest[f])
        longest[f] = length(surface, joint), across[f] = joint.facet[1 - side];
  for (int f = 0; f < count; ++f) {
    const Vec3 area = surface.area(f);
    if (norm(area) > 0) normal[f] = (1 / norm(area)) * area;
    height[f] = longest[f] > 0 ? 2 * norm(area) / longest[f] : 0;
  }
  if (surface.dimension == 2) return normal;
  const double least = sliver * size_of(surface);
  std::vector<int> slivers;
  for (int f = 0; f < count; ++f)
    if (height[f] < least && across[f] >= 0) slivers.push_back(f);
  // The broadest first: a fan of slivers takes its normal from one neighbour to the next.
  std::ranges::stable_sort(slivers, std::greater(), [&](int f) { return height[f]; });
  for (const int f : slivers) normal[f] = normal[across[f]];
  return normal;
}

/// Finds the representative of a set.
int root(std::vector<int>& parent, int f) {
  while (parent[f] != f) f = parent[f] = parent[parent[f]];
  return f;
}

bool is_smooth(const Surface& surface, const SmoothPatches& patches, const Joint& joint) {
  const auto [f, g] = joint.facet;
  return surface.facets[f].face == surface.facets[g].face && dot(patches.normal[f], patches.normal[g]) > smooth;
}

/// Numbers the patches in the order of their first facets.
void number_patches(const Surface& surface, const std::vector<Joint>& joints, SmoothPatches& out) {
  std::vector<int> parent(surface.facets.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Joint& joint : joints)
    if (is_smooth(surface, out, joint)) {
      const auto [first, second] = std::minmax(root(parent, joint.facet[0]), root(parent, joint.facet[1]));
      parent[second] = first;
    }
  out.patch.resize(parent.size());
  for (int f = 0; f < static_cast<int>(parent.size()); ++f) {
    const int r = root(parent, f);
    out.patch[f] = r == f ? out.count++ : out.patch[r];
  }
}

/// A step of a line: an edge that is not smooth, or a segment in the plane.
struct Step {
  int a, b;
  std::vector<int> facets;
};

std::vector<Step> steps_of(const Surface& surface, const std::vector<Joint>& joints, const SmoothPatches& patches) {
  std::vector<Step> steps;
  if (surface.dimension == 2) {
    for (int f = 0; f < static_cast<int>(surface.facets.size()); ++f)
      steps.push_back({surface.facets[f].vertex[0], surface.facets[f].vertex[1], {f}});
    return steps;
  }
  for (const Joint& joint : joints)
    if (!is_smooth(surface, patches, joint)) steps.push_back({joint.a, joint.b, {joint.facet[0], joint.facet[1]}});
  return steps;
}

std::vector<int> patches_beside(const SmoothPatches& patches, const Step& step) {
  std::vector<int> beside;
  for (const int f : step.facets) beside.push_back(patches.patch[f]);
  std::ranges::sort(beside);
  return beside;
}

/// Joins steps to lines, from corner to corner, then those that are closed.
class Tracer {
 public:
  Tracer(const Surface& surface, std::vector<Step> steps, SmoothPatches& out)
      : surface_(surface), steps_(std::move(steps)), used_(steps_.size(), 0), out_(out) {
    for (int s = 0; s < static_cast<int>(steps_.size()); ++s) at_[steps_[s].a].push_back(s), at_[steps_[s].b].push_back(s);
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
    SmoothPatches::Line line{.vertices = {vertex}, .facets = {}};
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
  SmoothPatches& out_;
};

}  // namespace

SmoothPatches smooth_patches(const Surface& surface) {
  SmoothPatches out;
  if (surface.facets.empty()) return out;
  const std::vector<Joint> joints = joints_of(surface);
  out.normal = normals_of(surface, joints);
  number_patches(surface, joints, out);
  Tracer(surface, steps_of(surface, joints, out), out).trace();
  return out;
}

}  // namespace calor
