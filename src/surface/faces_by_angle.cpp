#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>

#include "surface/edges.hpp"
#include "surface/surface.hpp"

namespace calor {
namespace {

/// Groups that grow together; the lowest member stands for a group.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int n) {
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

/// An edge between two facets.
struct Joint {
  std::int32_t f, g;
  double length;
};

std::vector<Joint> joints_of(const Surface& surface) {
  std::vector<Joint> joints;
  for_each_edge(sides_by_edge(surface), [&](std::span<const Side> sides) {
    if (sides.size() == 2) joints.push_back({sides[0].facet, sides[1].facet, length(surface, sides[0])});
  });
  return joints;
}

/// Unit normals. Facets too thin to have one get that of a neighbour, over long edges first: such facets are cut off
/// along a long edge, or fill a gap of round-off there.
std::vector<Vec3> normals_of(const Surface& surface, const std::vector<Joint>& joints) {
  double thin = 0;  // heights below this tell nothing
  if (surface.dimension == 3) {
    Vec3 low = surface.vertices[0], high = low;
    for (const Vec3& x : surface.vertices)
      for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
    // Files round to single precision, 6e-8 of the size: by less than .01 rad facets of this height lean over.
    thin = 1e-5 * norm(high - low);
  }
  std::vector<Vec3> normal(surface.facets.size());
  const auto has_normal = [&](std::int32_t f) { return normal[f] != Vec3{}; };
  for (std::size_t f = 0; f < normal.size(); ++f) {
    const auto& vertex = surface.facets[f].vertex;
    double longest = 0;
    for (int k = 0; k < 3 && surface.dimension == 3; ++k)
      longest = std::max(longest, norm(surface.vertices[vertex[(k + 1) % 3]] - surface.vertices[vertex[k]]));
    const Vec3 area = surface.area(static_cast<int>(f));
    if (const double size = norm(area); 2 * size > thin * longest) normal[f] = (1 / size) * area;
  }
  std::vector<Joint> open;
  std::ranges::copy_if(joints, std::back_inserter(open),
                       [&](const Joint& j) { return !has_normal(j.f) || !has_normal(j.g); });
  std::ranges::stable_sort(open, std::greater{}, &Joint::length);
  for (bool changes = true; changes;) {
    changes = false;
    for (const auto& [f, g, length] : open) {
      if (has_normal(f) == has_normal(g)) continue;
      const Vec3 known = has_normal(f) ? normal[f] : normal[g];
      normal[f] = normal[g] = known;
      changes = true;
    }
  }
  return normal;
}

}  // namespace

void name_faces_by_angle(Surface& surface, double angle) {
  surface.faces.clear();
  if (surface.facets.empty()) return;
  const std::vector<Joint> joints = joints_of(surface);
  const std::vector<Vec3> normal = normals_of(surface, joints);
  Groups groups(normal.size());
  for (const Joint& joint : joints)
    if (dot(normal[joint.f], normal[joint.g]) > std::cos(angle)) groups.join(joint.f, joint.g);
  std::vector<double> area(normal.size());  // of the groups, at their first facets
  std::vector<int> first;
  for (int f = 0; f < static_cast<int>(normal.size()); ++f) {
    const int root = groups.root(f);
    if (root == f) first.push_back(f);
    area[root] += norm(surface.area(f));
  }
  // Areas that are equal but for round-off stay in the order of the facets.
  const double largest = *std::ranges::max_element(area);
  std::ranges::stable_sort(first, std::greater{}, [&](int f) { return std::round(1e6 * area[f] / largest); });
  std::vector<std::int32_t> face(normal.size());
  for (const int f : first) {
    face[f] = static_cast<std::int32_t>(surface.faces.size());
    surface.faces.push_back("face" + std::to_string(surface.faces.size() + 1));
  }
  for (int f = 0; f < static_cast<int>(normal.size()); ++f) surface.facets[f].face = face[groups.root(f)];
}

}  // namespace calor
