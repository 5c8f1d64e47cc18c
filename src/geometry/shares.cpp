// How much of a place on an interface, and of every cell, the parts of a body have.
#include <algorithm>
#include <utility>

#include "cloud/lattice.hpp"
#include "cloud/part_shares.hpp"
#include "geometry/parts.hpp"
#include "surface/body.hpp"

namespace calor {
namespace {

/// How far from a place its surroundings are looked at, over the size of what is around it.
constexpr double nearby = 1e-6;
/// The farthest of the surroundings, in the same.
constexpr double farthest_offset = 1.5;
/// Shares of a cell that are smaller than this are round-off.
constexpr double shortest = 1e-9;

/// Places around the origin, one in every quadrant or octant; no two in line with a plane that is likely to be asked
/// for.
std::vector<Vec3> surroundings(int dimension) {
  std::vector<Vec3> places;
  for (int q = 0; q < 1 << dimension; ++q) {
    Vec3 place;
    const Vec3 size{1, 0.83, 0.69};
    for (int a = 0; a < dimension; ++a) place[a] = (q >> a & 1 ? 1 : -1) * size[a];
    places.push_back(place);
  }
  return places;
}

}  // namespace

bool Parts::knows_solids() const { return cloud_.solids && cloud_.solids->exist(); }

bool Parts::is_inside(const Vec3& x) const {
  if (cloud_.body) return cloud_.body->tree().is_inside(x);
  if (knows_solids()) return cloud_.solids->tag_at(x) >= 0;
  for (std::size_t f = 0; f < cloud_.walls.size(); ++f) {
    const double off = x[static_cast<int>(f / 2)] - cloud_.walls[f];
    if (f % 2 == 0 ? off < 0 : off > 0) return false;
  }
  return true;
}

/// False where it is surely none; only bodies by their surface tell.
bool Parts::has_wall_within(const Vec3& x, double distance) const {
  constexpr double slack = 1 + 1e-6;
  return !cloud_.body || cloud_.body->tree().closest(x, slack * distance);
}

bool Parts::knows_interfaces() const { return !point_tags_ && !has_formulas(); }

bool Parts::is_one_around(const Vec3& x, double radius) const {
  constexpr double slack = 1 + 1e-3;  // a place on an interface at this distance may belong to either side
  if (count() == 1) return true;
  if (!knows_interfaces()) return false;
  Vec3 up;
  if (layers_.axis >= 0) up[layers_.axis] = slack * radius;
  if (has_plane_between(x - up, x + up)) return false;
  return regions_.empty() || !cloud_.solids->interface_at(x, slack * radius);
}

std::vector<PlacesOfPart> Parts::shares(std::span<const Vec3> x, std::span<const int> tag,
                                        std::span<const double> size) const {
  const std::vector<int> own = at(x, tag);
  std::vector<std::size_t> near;  // the places that may lie on an interface
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!is_one_around(x[i], farthest_offset * nearby * size[i])) near.push_back(i);
  const std::vector<Vec3> offsets = surroundings(cloud_.dimension);
  std::vector<Vec3> around;
  std::vector<int> tags;
  for (const std::size_t i : near)
    for (const Vec3& offset : offsets) {
      const Vec3 to = x[i] + nearby * size[i] * offset;
      around.push_back(has_wall_within(x[i], norm(to - x[i])) && !is_inside(to) ? x[i] : to);
      tags.push_back(tag[i]);
    }
  std::vector<int> part(around.size());
  find(around, around, tags, part);
  std::vector<double> share(near.size() * count()), inside(near.size());
  for (std::size_t k = 0; k < around.size(); ++k) {
    const std::size_t n = k / offsets.size(), i = near[n];
    if (around[k] == x[i] || part[k] < 0 || contact(part[k], own[i])) continue;
    share[n * count() + part[k]] += 1, inside[n] += 1;
  }
  std::vector<PlacesOfPart> shares(count());
  const auto add = [&](int p, std::size_t i, double s) {
    shares[p].place.push_back(static_cast<int>(i)), shares[p].share.push_back(s);
  };
  for (std::size_t i = 0, n = 0; i < x.size(); ++i) {
    const bool is_near = n < near.size() && near[n] == i;
    for (int p = 0; p < count() && is_near && inside[n] > 0; ++p)
      if (const double s = share[n * count() + p]; s > 0) add(p, i, s / inside[n]);
    if (!is_near || inside[n] == 0) add(own[i], i, 1);
    n += is_near;
  }
  return shares;
}

std::vector<std::vector<double>> Parts::shares_of_lattice_cells() const {
  std::vector<std::vector<double>> share(count(), std::vector<double>(cloud_.owned));
  for (int i = 0; i < cloud_.owned; ++i) {
    const auto [low, high] = cloud_.lattice->cell(layers_.axis, cloud_.lattice->index(cloud_.id[i])[layers_.axis]);
    double begin = low;
    for (std::size_t layer = 0; layer < layers_.top.size(); ++layer) {
      const bool is_last = layer + 1 == layers_.top.size();
      const double end = is_last ? high : std::clamp(layers_.start + layers_.top[layer], begin, high);
      share[layer][i] = (end - begin) / (high - low);
      begin = end;
    }
  }
  return share;
}

std::vector<std::vector<double>> Parts::shares_of_cells() const {
  std::vector<Solids::Known> known;
  std::vector<std::vector<double>> share =
      part_shares(cloud_, {.count = count(),
                           .at = [&](std::span<const Vec3> x,
                                     std::span<int> part) { find(x, x, std::vector<int>(x.size(), -1), part, known); },
                           .is_one_around = [&](const Vec3& x, double radius) { return is_one_around(x, radius); }});
  // Regions by tag take whole cells where the points alone know of them.
  for (const Region& region : regions_)
    for (int i = 0; i < cloud_.owned && !region.where && !knows_solids(); ++i)
      for (int p = 0; p < count() && cloud_.tag[i] == region.tag; ++p) share[p][i] = p == region.part;
  return share;
}

std::vector<PlacesOfPart> Parts::cell_shares() const {
  std::vector<PlacesOfPart> shares(count());
  const auto add = [&](int part, int i, double share) {
    shares[part].place.push_back(i), shares[part].share.push_back(share);
  };
  const std::vector<int> own = at(cloud_.x, cloud_.tag);
  std::vector<std::vector<double>> share;
  if (count() > 1) share = cloud_.lattice && regions_.empty() ? shares_of_lattice_cells() : shares_of_cells();
  for (int i = 0; i < cloud_.local(); ++i) {
    double whole = 0;
    for (int p = 0; p < count() && count() > 1 && i < cloud_.owned; ++p)
      whole += share[p][i] > shortest ? share[p][i] : 0;
    if (whole == 0) {  // only the cells of owned points are known
      add(own[i], i, 1);
      continue;
    }
    for (int p = 0; p < count(); ++p)
      if (share[p][i] > shortest) add(p, i, share[p][i] / whole);
  }
  return shares;
}

}  // namespace calor
