#include "output/material_volumes.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

namespace calor {

MaterialVolumes::MaterialVolumes(HeatSystem& system) : system_(system) {
  const Cloud& cloud = system.cloud();
  const Parts& parts = system.material().parts();
  std::vector<int> parts_of_cell(cloud.owned);
  for (const PlacesOfPart& in_cells : system.material().cell_shares())
    for (const int i : in_cells.place)
      if (i < cloud.owned) ++parts_of_cell[i];
  constexpr double next = 1.3;  // spacings: the neighbours along the axes of a lattice, and about as many elsewhere
  std::vector<Parts::Segment> segments;
  std::vector<std::int32_t> buffer;
  for (int i = 0; i < cloud.owned; ++i) {
    if (parts_of_cell[i] < 2) continue;
    for (const std::int32_t j : system.discretisation().conduction->coupled(i, buffer)) {
      if (cloud.square_in_spacings(i, j) >= next * next) continue;
      rays_.push_back({i, j});
      segments.push_back({cloud.x[i], cloud.x[j], cloud.tag[i], cloud.tag[j]});
    }
  }
  pieces_ = parts.along(segments);
}

MaterialVolumes::Material MaterialVolumes::of(const std::string& material) const {
  const Cloud& cloud = system_.cloud();
  const Parts& parts = system_.material().parts();
  Material found{std::vector<char>(cloud.local()), std::vector<double>(cloud.local())};
  std::vector<double> volume(cloud.owned);
  for (int part = 0; part < parts.count(); ++part) {
    if (parts[part].material != material) continue;
    std::ranges::transform(found.lies_in, system_.material().lie_in(part), found.lies_in.begin(), std::bit_or{});
    const auto& [place, share] = system_.material().cell_shares()[part];
    for (std::size_t n = 0; n < place.size(); ++n)
      if (place[n] < cloud.owned) volume[place[n]] += share[n] * cloud.volume[place[n]];
  }
  std::size_t ray = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    while (ray < rays_.size() && rays_[ray].i < i) ++ray;
    const bool has_rays = ray < rays_.size() && rays_[ray].i == i;
    if (volume[i] > 0 && has_rays)
      add_slices(material, ray, volume[i], found);
    else if (volume[i] > 0)
      found.volume[nearest_in(found.lies_in, i)] += volume[i];
  }
  cloud.halo.add_up(found.volume);
  return found;
}

/// Shares the volume of a cell out by the lengths of its rays that run through the material: what is reached from the
/// point itself is its own, what begins beyond another material that of the other end.
void MaterialVolumes::add_slices(const std::string& material, std::size_t first_ray, double volume,
                                 Material& found) const {
  const Parts& parts = system_.material().parts();
  const int i = rays_[first_ray].i;
  constexpr double shortest = 1e-9;  // pieces, over the ray: round-off
  std::vector<std::pair<int, double>> lengths;
  double whole = 0;
  for (std::size_t ray = first_ray; ray < rays_.size() && rays_[ray].i == i; ++ray) {
    const std::int32_t j = rays_[ray].j;
    bool is_own = true;
    double begin = 0;
    for (const auto& [part, end] : pieces_.of(ray)) {
      const double length = std::min(end, 0.5) - std::min(begin, 0.5);  // the cell ends midway
      begin = end;
      if (length <= shortest) continue;
      const bool is_in = parts[part].material == material;
      is_own = is_own && is_in;
      const int point = is_own ? i : j;
      if (!is_in || !found.lies_in[point]) continue;
      lengths.emplace_back(point, length);
      whole += length;
    }
  }
  if (whole == 0) lengths.emplace_back(nearest_in(found.lies_in, i), whole = 1);
  for (const auto& [point, length] : lengths) found.volume[point] += volume * length / whole;
}

/// Of the points that owned point i couples to; itself where it lies in the material or none does.
int MaterialVolumes::nearest_in(const std::vector<char>& lies_in, int i) const {
  if (lies_in[i]) return i;
  const Cloud& cloud = system_.cloud();
  int next = i;
  double nearest = std::numeric_limits<double>::infinity();
  std::vector<std::int32_t> buffer;
  for (const std::int32_t j : system_.discretisation().conduction->coupled(i, buffer)) {
    const double distance = norm(cloud.x[j] - cloud.x[i]);
    if (lies_in[j] && distance < nearest) nearest = distance, next = j;
  }
  return next;
}

}  // namespace calor
