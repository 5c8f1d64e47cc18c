// What points see of each other: the straight way through the body, where its surface is known.
#include <algorithm>

#include "cloud/cloud.hpp"
#include "cloud/ring_lattice.hpp"
#include "surface/body.hpp"

namespace calor {
namespace {

/// Walls farther than this many spacings hide nothing that a method asks about.
constexpr double farthest = 5;

}  // namespace

void Cloud::open_eyes() {
  if (!body) return;
  for (int i = 0; i < local(); ++i) {
    const double d = spacing[i], far = farthest * d;
    const auto wall = body->tree().closest(x[i], far);
    clearance.push_back(wall ? wall->distance : far);
    inside.push_back(eye_at(x[i], d));
  }
}

Vec3 Cloud::eye_at(const Vec3& place, double d) const {
  return body ? body->moved_inside(place, Body::skin * d) : place;
}

Vec3 Cloud::off_walls(const Vec3& place, double depth) const {
  if (body) return body->moved_inside(place, depth);
  if (disc) return disc->off_walls(place, depth);
  Vec3 inside = place;
  for (std::size_t f = 0; f < walls.size(); ++f) {
    double& x = inside[static_cast<int>(f / 2)];
    x = f % 2 == 0 ? std::max(x, walls[f] + depth) : std::min(x, walls[f] - depth);
  }
  return inside;
}

bool Cloud::sees(int i, int j) const {
  if (!body) return true;
  const auto [first, second] = id[i] < id[j] ? std::pair(i, j) : std::pair(j, i);  // the same answer from both sides
  const Vec3 way = x[i] - x[j];
  const double clear = clearance[i] + clearance[j];
  return dot(way, way) < clear * clear || body->sees(inside[first], inside[second]);
}

bool Cloud::is_seen_from(const Vec3& eye, int j) const {
  if (!body) return true;
  const Vec3 way = x[j] - eye;
  return dot(way, way) < clearance[j] * clearance[j] || body->sees(eye, inside[j]);
}

}  // namespace calor
