#include "surface/solids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace calor {

Solids::Solid::Solid(Surface s, int tag) : surface(std::move(s)), tree(surface), tag(tag) {
  constexpr double larger = 1e-6, roundoff = 1e-11;
  low = high = surface.vertices.front();
  for (const Vec3& x : surface.vertices)
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  const double margin = larger * norm(high - low);
  on = roundoff * norm(high - low);
  low -= {margin, margin, margin}, high += {margin, margin, margin};
}

Solids::Interfaces::Interfaces(Surface s) : surface(std::move(s)), tree(surface) {}

Solids::Solids(std::vector<Surface> surfaces, std::vector<int> tags, Surface interfaces) {
  for (std::size_t n = 0; n < surfaces.size(); ++n)
    solids_.push_back(std::make_shared<const Solid>(std::move(surfaces[n]), tags[n]));
  const auto found = std::make_shared<Interfaces>(std::move(interfaces));
  if (!found->surface.facets.empty()) find_pieces(*found);
  interfaces_ = found;
}

void Solids::find_pieces(Interfaces& interfaces) const {
  const Surface& surface = interfaces.surface;
  std::vector<int>& piece = interfaces.piece;
  std::vector<double>& curved_areas = interfaces.curved_areas;
  constexpr double smooth = 0.5236, plane = 1e-6, beside = 1e-4;  // rad; off a cosine of 1; of the facet
  const std::vector<int> patch = smooth_patches(surface, smooth);
  std::map<std::array<int, 3>, int> number;
  std::vector<Vec3> first;
  for (int f = 0; f < static_cast<int>(patch.size()); ++f) {
    const Vec3 area = surface.area(f), x = surface.centroid(f);
    const double size = norm(area);
    const Vec3 n = size > 0 ? (1 / size) * area : Vec3{};
    const double step = beside * (surface.dimension == 2 ? size : std::sqrt(size));
    const auto [found, is_new] =
        number.try_emplace({patch[f], tag_at(x - step * n), tag_at(x + step * n)}, static_cast<int>(first.size()));
    piece.push_back(found->second);
    if (is_new) first.push_back(n), curved_areas.push_back(0);
  }
  std::vector<char> is_curved(first.size());
  for (std::size_t f = 0; f < patch.size(); ++f) {
    const Vec3 area = surface.area(static_cast<int>(f));
    curved_areas[piece[f]] += norm(area);
    if (dot(area, first[piece[f]]) < (1 - plane) * norm(area)) is_curved[piece[f]] = 1;
  }
  for (std::size_t p = 0; p < first.size(); ++p)
    if (!is_curved[p]) curved_areas[p] = 0;
}

Solids::Found Solids::find(const Vec3& x) const {
  constexpr double inside = 0.5;  // of winding numbers, 0 or 1 but for a thousandth
  for (int s = 0; s < static_cast<int>(solids_.size()); ++s) {
    const Solid& solid = *solids_[s];
    bool is_near = true;
    for (int a = 0; a < 3; ++a) is_near = is_near && x[a] >= solid.low[a] && x[a] <= solid.high[a];
    if (!is_near) continue;
    if (solid.tree.closest(x, solid.on)) return {s, false};
    if (solid.tree.winding_number(x) > inside) return {s, true};
  }
  return {-1, false};
}

std::optional<Solids::Interface> Solids::interface_at(const Vec3& x, double bound) const {
  if (!interfaces_) return std::nullopt;
  const auto near = interfaces_->tree.closest(x, bound);
  if (!near) return std::nullopt;
  const Vec3 area = interfaces_->surface.area(near->facet);
  return Interface{interfaces_->piece[near->facet], (1 / norm(area)) * area};
}

int Solids::tag_at(const Vec3& x) const {
  const int s = find(x).solid;
  return s < 0 ? -1 : solids_[s]->tag;
}

/// The solid that surely holds the place, by what is known of others; -1: not known.
int Solids::find_from(const Vec3& x, std::vector<Known>& known) const {
  for (std::size_t s = 0; s < solids_.size(); ++s)
    if (known[s].clearance > norm(x - known[s].x)) return static_cast<int>(s);
  // A way that crosses no wall costs a tenth of a winding number.
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    const Solid& solid = *solids_[s];
    if (known[s].clearance < 0 || solid.tree.is_crossed(known[s].x, x)) continue;
    const double bound = solid.on + 2 * norm(x - known[s].x);
    const auto near = solid.tree.closest(x, bound);
    if (near && near->distance <= solid.on) continue;
    known[s] = {x, near ? near->distance : bound};
    return static_cast<int>(s);
  }
  return -1;
}

void Solids::tags_at(std::span<const Vec3> x, std::span<int> tags, std::vector<Known>& known) const {
  known.resize(solids_.size());
  for (std::size_t n = 0; n < x.size(); ++n) {
    int solid = find_from(x[n], known);
    if (solid < 0) {
      const Found found = find(x[n]);
      solid = found.solid;
      if (found.is_inside) known[solid] = {x[n], 0};
    }
    tags[n] = solid < 0 ? -1 : solids_[solid]->tag;
  }
}

}  // namespace calor
