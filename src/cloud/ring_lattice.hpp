#pragma once
// Where the points of concentric rings lie and what they own.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "base/vec3.hpp"
#include "cloud/shapes.hpp"

namespace calor {

/// What a point of the plane lattice of rings owns.
struct RingPoint {
  double x, y;
  double area, full_area;                 ///< of its sector of a ring, inside the body and uncut
  double arc = 0;                         ///< length on the side
  Vec3 arc_vector = {}, arc_normal = {};  ///< integral of the normal over the arc; its direction
  double cut1 = 0, cut2 = 0;              ///< lengths on the cuts
  std::array<double, 2> radii, angles;    ///< between which the sector lies
};

/// Numbers the points of a disc, or of a level of a cylinder, from the centre outwards.
class RingLattice {
 public:
  explicit RingLattice(const Rings& r) : rings_(r), dr_(r.radius / r.rings) {
    first_.push_back(0);
    first_.push_back(1);
    for (int m = 1; m <= r.rings; ++m) first_.push_back(first_.back() + points_on(m));
  }

  double dr() const { return dr_; }
  double angle() const {
    return std::numbers::pi * (rings_.sector == Sector::full ? 2 : rings_.sector == Sector::half ? 1 : 0.5);
  }
  std::int64_t count() const { return first_.back(); }

  RingPoint point(std::int64_t index) const {
    const int m = static_cast<int>(std::upper_bound(first_.begin(), first_.end(), index) - first_.begin()) - 1;
    return m == 0 ? centre() : on_ring(m, index - first_[m]);
  }

  /// The cell of a point of the cloud between two corners in r, theta and z; z is 0 in a disc.
  std::pair<Vec3, Vec3> cell(std::int64_t id) const {
    const RingPoint p = point(id % count());
    Vec3 low{p.radii[0], p.angles[0], 0}, high{p.radii[1], p.angles[1], 0};
    if (rings_.levels > 0) {
      const std::int64_t level = id / count(), top = rings_.levels - 1;
      const double dz = rings_.height / static_cast<double>(top), middle = static_cast<double>(level) * dz;
      low.z = level == 0 ? 0 : middle - 0.5 * dz;
      high.z = level == top ? rings_.height : middle + 0.5 * dz;
    }
    return {low, high};
  }

  /// See Cloud::off_walls.
  Vec3 off_walls(Vec3 x, double depth) const {
    if (rings_.levels > 0) x.z = std::clamp(x.z, depth, rings_.height - depth);
    if (rings_.sector == Sector::quarter) x.x = std::max(x.x, depth);
    if (!whole()) x.y = std::max(x.y, depth);
    const double r = std::hypot(x.x, x.y), most = rings_.radius - depth;
    if (r > most) x.x *= most / r, x.y *= most / r;
    return x;
  }

 private:
  bool whole() const { return rings_.sector == Sector::full; }
  std::int64_t intervals_on(int m) const {
    if (whole()) return 6 * m;
    if (rings_.sector == Sector::half) return 3 * m;
    return std::max<std::int64_t>(2, std::lrint(1.5 * m));  // halves go to even numbers, in turn up and down
  }
  std::int64_t points_on(int m) const { return intervals_on(m) + (whole() ? 0 : 1); }

  /// Length on the cut at angle 0 or at the end of the sector; the two cuts of a half lie in one plane.
  void add_cut(RingPoint& p, bool start, double length) const {
    (start || rings_.sector == Sector::half ? p.cut1 : p.cut2) += length;
  }

  RingPoint centre() const {
    const double r = dr_ / 2;
    RingPoint p{.x = 0,
                .y = 0,
                .area = angle() / 2 * r * r,
                .full_area = std::numbers::pi * r * r,
                .radii = {0, r},
                .angles = {0, angle()}};
    if (!whole()) add_cut(p, true, r), add_cut(p, false, r);
    return p;
  }

  RingPoint on_ring(int m, std::int64_t i) const {
    const std::int64_t n = intervals_on(m);
    const double step = angle() / static_cast<double>(n), theta = step * static_cast<double>(i);
    const bool start = !whole() && i == 0, end = !whole() && i == n;
    const bool outermost = m == rings_.rings;
    const double r = outermost ? rings_.radius : m * dr_;
    const double inner = r - dr_ / 2, uncut = r + dr_ / 2, outer = outermost ? rings_.radius : uncut;
    const double share = start || end ? 0.5 : 1;

    RingPoint p{.x = r * std::cos(theta),
                .y = r * std::sin(theta),
                .area = share * step * (outer * outer - inner * inner) / 2,
                .full_area = step * (uncut * uncut - inner * inner) / 2,
                .radii = {inner, outer},
                .angles = {start ? theta : theta - step / 2, end ? theta : theta + step / 2}};
    if (start) p.x = r, p.y = 0;
    if (end && rings_.sector == Sector::half) p.x = -r, p.y = 0;
    if (end && rings_.sector == Sector::quarter) p.x = 0, p.y = r;
    if (start || end) add_cut(p, start, outer - inner);
    if (outermost) {
      const auto [from, to] = p.angles;
      p.arc = r * (to - from);
      // Chord times its normal: the integral of n over the arc; so the vectors of the closed surface add up to zero.
      const double middle = (from + to) / 2;
      p.arc_normal = {std::cos(middle), std::sin(middle), 0};
      p.arc_vector = 2 * r * std::sin((to - from) / 2) * p.arc_normal;
    }
    return p;
  }

  Rings rings_;
  double dr_;
  std::vector<std::int64_t> first_;  // index of the first point of every ring, and the end
};

}  // namespace calor
