#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "surface/surface.hpp"

namespace calor {

void name_faces_by_angle(Surface& surface, double angle) {
  surface.faces.clear();
  if (surface.facets.empty()) return;
  const std::vector<int> patch = smooth_patches(surface, angle);
  std::vector<double> area(std::ranges::max(patch) + 1);
  for (std::size_t f = 0; f < patch.size(); ++f) area[patch[f]] += norm(surface.area(static_cast<int>(f)));
  std::vector<int> order(area.size());
  std::iota(order.begin(), order.end(), 0);
  // Areas that are equal but for round-off stay in the order of the facets.
  const double largest = std::ranges::max(area);
  std::ranges::stable_sort(order, std::greater{}, [&](int p) { return std::round(1e6 * area[p] / largest); });
  std::vector<std::int32_t> face(area.size());
  for (const int p : order) {
    face[p] = static_cast<std::int32_t>(surface.faces.size());
    surface.faces.push_back("face" + std::to_string(surface.faces.size() + 1));
  }
  for (std::size_t f = 0; f < patch.size(); ++f) surface.facets[f].face = face[patch[f]];
}

}  // namespace calor
