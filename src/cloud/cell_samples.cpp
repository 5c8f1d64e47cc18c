#include "cloud/cell_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cloud/lattice.hpp"
#include "surface/solids.hpp"

namespace calor {
namespace {

/// Samples along a spacing.
int per_spacing(int dimension) { return dimension == 3 ? 4 : 8; }
/// Cells narrower than the spacing tells are sampled more finely until this many samples lie in them.
constexpr std::size_t least_samples = 8;
constexpr int most_refinements = 3;
/// No part of a cell is taken to be farther from its point than this many spacings, beside contacts that may run along
/// another row of points.
constexpr double farthest = 1.25, farthest_at_contacts = 1.75;

double mean(const std::vector<double>& v) {
  double sum = 0;
  for (double a : v) sum += a;
  return v.empty() ? 1 : sum / static_cast<double>(v.size());
}

// Where contacts end cells, a cell is that of the nearest point on the same side.

const Sides* sides_of(const Cloud& cloud) { return cloud.solids ? cloud.solids->sides() : nullptr; }

bool is_beside_contact(const Cloud& cloud, int i) {
  const Sides* sides = sides_of(cloud);
  return sides && sides->is_beside[i];
}

void remove_beyond_contacts(const Cloud& cloud, int i, std::vector<Vec3>& places, SampleCubes& cubes) {
  const Sides& sides = *sides_of(cloud);
  std::vector<int> part(places.size());
  sides.at(places, cloud.tag[i], part);
  const SampleCubes all = std::exchange(cubes, {{}, {0}});
  std::int32_t count = 0;
  for (std::size_t k = 0; k < all.index.size(); ++k) {
    for (std::int32_t n = all.begin[k]; n < all.begin[k + 1]; ++n)
      if (!sides.separated[sides.part[i]][part[n]]) places[count++] = places[n];
    if (count == cubes.begin.back()) continue;
    cubes.index.push_back(all.index[k]), cubes.begin.push_back(count);
  }
  places.resize(count);
}

}  // namespace

std::vector<double> weights_of(const Cloud& cloud, std::span<const Vec3> samples) {
  const auto n = static_cast<double>(samples.size());
  std::vector<double> weights(samples.size(), 1 / n);
  if (!cloud.axisymmetric) return weights;
  double sum = 0;
  for (const Vec3& x : samples) sum += x.x;
  for (std::size_t k = 0; k < weights.size() && sum > 0; ++k) weights[k] = samples[k].x / sum;
  return weights;
}

double wall_distance(const Cloud& cloud, const Facet& facet) {
  if (cloud.points_on_walls) return 0;
  const int i = facet.point;
  if (cloud.walls.empty()) return 0.5 * cloud.full_volume[i] / facet.area;
  const int axis = facet.face / 2;
  constexpr double least = 0.05;  // of a spacing, for jittered points that all but touch the wall
  return std::max(std::abs(cloud.walls[facet.face] - cloud.x[i][axis]), least * cloud.metric[i][axis]);
}

Vec3 place_on_wall(const Cloud& cloud, const Facet& facet) {
  return cloud.x[facet.point] + wall_distance(cloud, facet) * facet.normal;
}

CellSampler::CellSampler(const Cloud& cloud)
    : cloud_(cloud), cells_(cloud.x, mean(cloud.spacing)), order_(order_by_cells(cells_, cloud.x)) {
  for (const Facet& facet : cloud.facets) {
    while (static_cast<int>(patches_of_.size()) <= facet.point)
      patches_of_.push_back(static_cast<std::int32_t>(&facet - cloud.facets.data()));
  }
  patches_of_.resize(cloud.owned + 1, static_cast<std::int32_t>(cloud.facets.size()));
}

CellSamples CellSampler::all() const {
  CellSamples out;
  for (int i = 0; i < cloud_.owned; ++i) add(i, out);
  return out;
}

void CellSampler::near(const Vec3& centre, double radius, CellSamples& out) const {
  out.x.clear(), out.weight.clear(), out.row.assign(1, 0);
  std::vector<std::int32_t> points;
  visit_within(centre, radius, [&](int i) {
    if (i < cloud_.owned) points.push_back(i);
  });
  std::ranges::sort(points);
  out.point.clear();
  for (int i : points) add(i, out);
}

template <class Visit>
void CellSampler::visit_within(const Vec3& centre, double radius, const Visit& visit) const {
  std::array<std::int64_t, 3> low, high;
  for (int a = 0; a < 3; ++a)
    low[a] = cells_.index(a, centre[a] - radius), high[a] = cells_.index(a, centre[a] + radius);
  for (std::int64_t z = low[2]; z <= high[2]; ++z) {
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      const std::int64_t row = cells_.along(0) * (y + cells_.along(1) * z);
      for (std::int32_t n = order_.start[row + low[0]]; n < order_.start[row + high[0] + 1]; ++n) {
        const int i = order_.order[n];
        if (const Vec3 r = cloud_.x[i] - centre; dot(r, r) <= radius * radius) visit(i);
      }
    }
  }
}

void CellSampler::add(int i, CellSamples& out) const {
  out.point.push_back(i);
  if (cloud_.lattice) {
    add_boxes(i, 1, out.x);
  } else {
    std::vector<Vec3> places;
    SampleCubes cubes;
    of(i, 1, places, cubes);
    out.x.insert(out.x.end(), places.begin(), places.end());
  }
  const std::int64_t begin = out.row.back(), count = static_cast<std::int64_t>(out.x.size()) - begin;
  for (const double share : weights_of(cloud_, std::span(out.x).subspan(begin)))
    out.weight.push_back(cloud_.volume[i] * share);
  out.row.push_back(begin + count);
}

void CellSampler::of(int i, int finer, std::vector<Vec3>& out) const {
  SampleCubes cubes;
  out.clear();
  cloud_.lattice ? add_boxes(i, finer, out) : of(i, finer, out, cubes);
}

void CellSampler::add_boxes(int i, int finer, std::vector<Vec3>& out) const {
  const Lattice& lattice = *cloud_.lattice;
  const LatticeIndex index = lattice.index(cloud_.id[i]);
  std::array<int, 3> n = {1, 1, 1};
  Vec3 low, step;
  for (int a = 0; a < cloud_.dimension; ++a) {
    const auto [begin, end] = lattice.cell(a, index[a]);
    const bool half = lattice.box().on_walls && (lattice.lowest(index, a) || lattice.highest(index, a));
    n[a] = finer * per_spacing(cloud_.dimension) / (half ? 2 : 1);
    low[a] = begin, step[a] = (end - begin) / n[a];
  }
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x)
        out.push_back(low + Vec3{(x + 0.5) * step.x, (y + 0.5) * step.y, (z + 0.5) * step.z});
}

/// Nearest first, so that most places outside the cell are told by the first few.
std::vector<Rival> CellSampler::rivals(int i) const {
  std::vector<Rival> near;
  const Sides* sides = sides_of(cloud_);
  const Vec3& x = cloud_.x[i];
  const double d = cloud_.spacing[i];
  visit_within(x, std::min(2 * farthest * d, cloud_.halo_width), [&](int j) {
    const double square = dot(cloud_.x[j] - x, cloud_.x[j] - x);
    const double limit = cloud_.halo_support.radius(0.5 * (d + cloud_.spacing[j]));
    if (j != i && square <= limit * limit && !(sides && sides->separate(i, j)) && cloud_.sees(i, j))
      near.push_back({cloud_.x[j], square, cloud_.id[j], cloud_.area[j], cloud_.on_faces[j]});
  });
  std::ranges::sort(near, [](const Rival& a, const Rival& b) {
    return a.square < b.square || (a.square == b.square && a.id < b.id);
  });
  return near;
}

double CellSampler::farthest_in_cell(int i) const {
  return is_beside_contact(cloud_, i) ? farthest_at_contacts : farthest;
}

void CellSampler::of(int i, int finer, std::vector<Vec3>& out, SampleCubes& cubes) const {
  const std::vector<Rival> near = rivals(i);
  const auto first = cloud_.facets.begin();
  NearestCell cell(cloud_, i, {first + patches_of_[i], first + patches_of_[i + 1]}, near, farthest_in_cell(i));
  out.clear();
  for (int level = 0, n = finer * per_spacing(cloud_.dimension); level < most_refinements && out.size() < least_samples;
       ++level, n *= 2) {
    cell.sample(level, n, finer, out, cubes);
    if (is_beside_contact(cloud_, i)) remove_beyond_contacts(cloud_, i, out, cubes);
  }
  if (out.empty()) out.push_back(cloud_.x[i]), cubes = {{{0, 0, 0}}, {0, 1}};
}

void CellSampler::beside_facet(int n, std::vector<Vec3>& out) const {
  const Facet& facet = cloud_.facets[n];
  out.clear();
  double nearest = 0;
  for (const Rival& j : rivals(facet.point)) {
    if (!(j.on_faces >> facet.face & 1)) continue;
    if (out.empty()) nearest = j.square;
    if (j.square <= 2.5 * nearest) out.push_back(j.x);
  }
}

std::array<Vec3, 3> CellSampler::ends_of_facet(int n) const {
  const Facet& facet = cloud_.facets[n];
  const Vec3 middle = place_on_wall(cloud_, facet);
  const Vec3 along = {-facet.normal.y, facet.normal.x, 0};
  std::array<double, 2> reach = {};  // towards either side, half way to the neighbour there
  std::array<Vec3, 2> way = {-along, along};
  for (const int side : {0, 1}) {
    for (const Rival& j : rivals(facet.point)) {
      const Vec3 r = j.x - cloud_.x[facet.point];
      if (!(j.on_faces >> facet.face & 1) || dot(r, way[side]) < 0.5 * std::sqrt(j.square)) continue;
      reach[side] = 0.5 * std::sqrt(j.square);
      if (cloud_.points_on_walls) way[side] = 1 / std::sqrt(j.square) * r;
      break;  // the nearest
    }
  }
  if (cloud_.axisymmetric) return {middle + reach[0] * way[0], middle, middle + reach[1] * way[1]};
  // At its end the wall reaches as far as is left.
  const double length = facet.area / cloud_.cross_section;
  for (const int side : {0, 1})
    if (reach[side] == 0) reach[side] = std::max(0.0, length - (reach[1 - side] == 0 ? 0.5 * length : reach[1 - side]));
  const double scale = length / (reach[0] + reach[1]);
  return {middle + scale * reach[0] * way[0], middle, middle + scale * reach[1] * way[1]};
}

void CellSampler::of_facet(int n, int finer, std::vector<Vec3>& out) const {
  const Facet& facet = cloud_.facets[n];
  const int i = facet.point;
  const Vec3 x = cloud_.x[i], away = wall_distance(cloud_, facet) * facet.normal;
  const Vec3 least = std::abs(facet.normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Vec3 u = cross(facet.normal, least);
  u *= 1 / norm(u);
  const Vec3 v = cross(facet.normal, u);
  std::vector<Vec3> same;  // to the neighbours on the face, in its plane
  for (const Rival& j : rivals(i)) {
    const Vec3 r = j.x - x;
    if (j.on_faces >> facet.face & 1) same.push_back(r - dot(r, facet.normal) * facet.normal);
  }
  const double d = cloud_.spacing[i];
  const int per = 8 * finer, half = static_cast<int>(std::ceil(farthest * per));
  std::uint64_t place = 0;
  out.clear();
  for (int su = -half; su < half; ++su) {
    for (int sv = -half; sv < half; ++sv, ++place) {
      const Vec3 random = hashed_uniform(facet.face, (static_cast<std::uint64_t>(cloud_.id[i]) << 24) + place);
      const Vec3 p = d / per * ((su + random.x) * u + (sv + random.y) * v);
      const double square = dot(p, p);
      const bool nearest = std::ranges::all_of(same, [&](const Vec3& r) { return dot(p - r, p - r) >= square; });
      bool is_beyond = square > farthest * farthest * d * d;  // another face of the same point ends this one
      for (int k = patches_of_[i]; k < patches_of_[i + 1]; ++k)
        is_beyond = is_beyond || (dot(cloud_.facets[k].normal, facet.normal) < 0.9 &&
                                  dot(p, cloud_.facets[k].normal) > wall_distance(cloud_, cloud_.facets[k]));
      if (nearest && !is_beyond) out.push_back(x + away + p);
    }
  }
  if (is_beside_contact(cloud_, i)) {
    SampleCubes all{{{}}, {0, static_cast<std::int32_t>(out.size())}};
    remove_beyond_contacts(cloud_, i, out, all);
  }
  if (out.empty()) out.push_back(x + away);
}

}  // namespace calor
