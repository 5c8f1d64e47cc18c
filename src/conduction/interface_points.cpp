#include "conduction/interface_points.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "conduction/fibres.hpp"

namespace calor {

int spacings_between(const Cloud& cloud, int a, int b) {
  constexpr double round_off = 1e-6;
  double most = 1;
  if (!cloud.lattice) {
    most = norm(quotient(cloud.x[b] - cloud.x[a], cloud.mean_metric(a, b)));
  } else {
    const LatticeIndex at = cloud.lattice->index(cloud.id[a]), to = cloud.lattice->index(cloud.id[b]);
    for (int axis = 0; axis < cloud.dimension; ++axis)
      most = std::max(most, static_cast<double>(std::abs(to[axis] - at[axis])));
  }
  return std::max(1, static_cast<int>(std::ceil(most - round_off)));
}

InterfacePoints::InterfacePoints(const Cloud& cloud, const Parts& parts, const Neighbours& neighbours)
    : cloud_(cloud), parts_(parts), beside_thin_(cloud.local()) {
  collective_try(cloud.comm, [&] {
    find_parts();
    // On lattices the lines through the cells have told.
    if (!cloud.lattice && parts.may_be_thin()) find_thin_regions(neighbours);
  });
  mark_near(neighbours);
}

bool InterfacePoints::have_nothing_between(int i, int j) const {
  const bool are_far = near_[i] == 0 && near_[j] == 0;
  return are_far || (cloud_.lattice && spacings_between(cloud_, i, j) == 1);
}

void InterfacePoints::find_parts() {
  own_ = parts_.at(cloud_.x, cloud_.tag);
  if (cloud_.lattice && parts_.count() > 1) one_part_ = hold_one_part(cloud_, parts_);
  parts_here_.assign(cloud_.local(), 0);
  for (const PlacesOfPart& places : parts_.shares(cloud_.x, cloud_.tag, cloud_.spacing))
    for (const int i : places.place) ++parts_here_[i];
}

/// Marks the ends of short pairs that run through another part between two points of one: a region may be too thin to
/// be seen from the points.
void InterfacePoints::find_thin_regions(const Neighbours& neighbours) {
  constexpr double short_pair = 1.3;  // spacings
  constexpr std::size_t at_once = 10000;
  std::vector<Parts::Segment> segments;
  std::vector<std::pair<std::int32_t, std::int32_t>> ends;
  const auto look = [&] {
    const Parts::Pieces pieces = parts_.along(segments);
    for (std::size_t n = 0; n < ends.size(); ++n)
      if (pieces.of(n).size() > 1) beside_thin_[ends[n].first] = beside_thin_[ends[n].second] = 1;
    segments.clear(), ends.clear();
  };
  for (std::int32_t i = 0; i < cloud_.owned; ++i) {
    for (const std::int32_t j : neighbours.of(i)) {
      if ((j < cloud_.owned && j < i) || !are_of_one_part(i, j)) continue;
      if (norm(quotient(cloud_.x[j] - cloud_.x[i], cloud_.mean_metric(i, j))) > short_pair) continue;
      segments.push_back({cloud_.x[i], cloud_.x[j], cloud_.tag[i], cloud_.tag[j], spacings_between(cloud_, i, j)});
      ends.emplace_back(i, j);
    }
    if (segments.size() > at_once) look();
  }
  look();
}

/// Marks the points that see another part, at a neighbour or beside it, and their neighbours: what is between them and
/// a point of their own part may be of another.
void InterfacePoints::mark_near(const Neighbours& neighbours) {
  std::vector<double> sees(cloud_.local());
  for (std::int32_t i = 0; i < cloud_.owned; ++i) {
    sees[i] = is_divided(i) || beside_thin_[i];
    for (const std::int32_t j : neighbours.of(i)) sees[i] = sees[i] > 0 || own_[j] != own_[i] || is_divided(j);
  }
  cloud_.halo.update(std::span<double>(sees));
  near_ = sees;
  for (std::int32_t i = 0; i < cloud_.owned; ++i)
    for (const std::int32_t j : neighbours.of(i)) near_[i] = std::max(near_[i], sees[j]);
  cloud_.halo.update(std::span<double>(near_));
}

}  // namespace calor
