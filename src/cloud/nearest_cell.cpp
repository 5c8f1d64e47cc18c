#include "cloud/nearest_cell.hpp"

#include <algorithm>
#include <cmath>

#include "cloud/cell_samples.hpp"
#include "cloud/lattice.hpp"
#include "surface/body.hpp"

namespace calor {

bool NearestCell::Walls::has_outside(const Vec3& x) const {
  const auto beyond = [&](const Plane& p) { return p.has_outside(x); };
  return std::ranges::any_of(planes, beyond) || (!reentrant.empty() && std::ranges::all_of(reentrant, beyond));
}

NearestCell::NearestCell(const Cloud& cloud, int i, std::span<const Facet> facets, std::span<const Rival> rivals,
                         double farthest)
    : cloud_(cloud), i_(i), x_(cloud.x[i]), d_(cloud.spacing[i]), farthest_(farthest), rivals_(rivals) {
  for (const Facet& facet : facets) {
    const Plane plane{place_on_wall(cloud, facet), facet.normal};
    const bool reentrant = std::ranges::any_of(
        rivals, [&](const Rival& j) { return j.square < 4 * d_ * d_ && plane.has_outside(j.x, 0.25 * d_); });
    (reentrant ? walls_.reentrant : walls_.planes).push_back(plane);
  }
  near_wall_ = cloud.points_on_walls && facets.empty() &&
               std::ranges::any_of(rivals, [](const Rival& j) { return !(j.area == Vec3{}); });
}

/// The cell of a point near a wall may stick out between the points of the wall.
bool NearestCell::is_beyond_near_wall(const Vec3& p) const {
  const Rival* wall = nullptr;
  double square = 0;
  for (const Rival& j : rivals_) {
    if (j.area == Vec3{}) continue;
    const double s = dot(j.x - p, j.x - p);
    if (!wall || s < square) wall = &j, square = s;
  }
  return wall && Plane{wall->x, wall->area}.has_outside(p);
}

bool NearestCell::is_outside(const Vec3& p) const {
  if (cloud_.body) return !sees_all_ && !cloud_.is_seen_from(p, i_);
  return walls_.has_outside(p) || (near_wall_ && is_beyond_near_wall(p));
}

bool NearestCell::is_in_cell(const Vec3& p) const {
  const double square = dot(p - x_, p - x_);
  if (square > farthest_ * farthest_ * d_ * d_ || (cloud_.axisymmetric && p.x <= 0)) return false;
  for (const Rival* j : active_) {
    if (j->square >= 4 * square) break;
    if (dot(p - j->x, p - j->x) < square) return false;
  }
  return !is_outside(p);
}

/// Does the cube hold places of the cell? Sets what is to be asked of its places.
bool NearestCell::may_hold(const Cube& cube) {
  const Vec3 way = cube.centre - x_, away{std::abs(way.x), std::abs(way.y), std::abs(way.z)};
  const Vec3 gap{std::max(0.0, away.x - cube.half.x), std::max(0.0, away.y - cube.half.y),
                 std::max(0.0, away.z - cube.half.z)};
  if (norm(gap) > farthest_ * d_) return false;
  const double farthest_place = norm(away + cube.half);
  active_.clear();
  for (const Rival& j : rivals_) {
    if (j.square >= 4 * farthest_place * farthest_place) break;
    const Vec3 r = j.x - x_;
    const double beyond = dot(way, r) - 0.5 * j.square;  // of the plane between both, times the distance
    const double reach = cube.half.x * std::abs(r.x) + cube.half.y * std::abs(r.y) + cube.half.z * std::abs(r.z);
    if (beyond > reach) return false;
    if (beyond >= -reach) active_.push_back(&j);
  }
  if (!cloud_.body) return true;
  sees_all_ = farthest_place < cloud_.clearance[i_];
  if (sees_all_ || cloud_.body->tree().closest(cube.centre, norm(cube.half))) return true;
  return sees_all_ =
             cloud_.is_seen_from(cube.centre, i_);  // no wall in the cube: what holds of its middle holds of all
}

void NearestCell::sample(int level, int n, int per_cube, std::vector<Vec3>& out, SampleCubes& cubes) {
  const int D = cloud_.dimension, half = static_cast<int>(std::ceil(farthest_ * n)), side = 2 * half;
  const int per_side = (side + per_cube - 1) / per_cube;
  const double size = d_ / n;
  out.clear(), cubes.index.clear(), cubes.begin.assign(1, 0);
  if (per_cube == 1) {
    active_.clear(), sees_all_ = false;
    for (const Rival& j : rivals_) active_.push_back(&j);
  }
  for (int cube = 0; cube < static_cast<int>(std::pow(per_side, D)); ++cube) {
    const std::array<int, 3> index = {cube % per_side, cube / per_side % per_side, cube / (per_side * per_side)};
    std::array<int, 3> first = {0, 0, 0}, end = {1, 1, 1};  // sub-cells, from the lowest
    Cube box{x_, {}};
    for (int a = 0; a < D; ++a) {
      first[a] = index[a] * per_cube, end[a] = std::min(first[a] + per_cube, side);
      box.centre[a] += (0.5 * (first[a] + end[a]) - half) * size, box.half[a] = 0.5 * (end[a] - first[a]) * size;
    }
    if (per_cube > 1 && !may_hold(box)) continue;
    std::array<int, 3> sub = first;
    for (sub[2] = first[2]; sub[2] < end[2]; ++sub[2])
      for (sub[1] = first[1]; sub[1] < end[1]; ++sub[1])
        for (sub[0] = first[0]; sub[0] < end[0]; ++sub[0]) {
          const std::int64_t place = sub[0] + static_cast<std::int64_t>(side) * (sub[1] + side * sub[2]);
          const Vec3 u = hashed_uniform(level, (static_cast<std::uint64_t>(cloud_.id[i_]) << 24) + place);
          Vec3 p = x_;
          for (int a = 0; a < D; ++a) p[a] += (sub[a] - half + u[a]) * size;
          if (is_in_cell(p)) out.push_back(p);
        }
    const auto count = static_cast<std::int32_t>(out.size());
    if (count == cubes.begin.back()) continue;
    cubes.index.push_back(index), cubes.begin.push_back(count);
  }
}

}  // namespace calor
