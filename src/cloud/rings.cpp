// Discs and cylinders, whole, halves and quarters, by concentric rings.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "cloud/shapes.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

/// What a point of the plane lattice of rings owns.
struct RingPoint {
  double x, y;
  double area, full_area;                 ///< of its sector of a ring, inside the body and uncut
  double arc = 0;                         ///< length on the side
  Vec3 arc_vector = {}, arc_normal = {};  ///< integral of the normal over the arc; its direction
  double cut1 = 0, cut2 = 0;              ///< lengths on the cuts
};

class RingLattice {
 public:
  explicit RingLattice(const Rings& r) : rings_(r), dr_(r.radius / r.rings) {
    first_.push_back(0);
    first_.push_back(1);
    for (int m = 1; m <= r.rings; ++m) first_.push_back(first_.back() + points_on(m));
  }

  double dr() const { return dr_; }
  double angle() const { return rings_.sector == Sector::full ? 2 * pi : rings_.sector == Sector::half ? pi : pi / 2; }
  std::int64_t count() const { return first_.back(); }

  RingPoint point(std::int64_t index) const {
    const int m = static_cast<int>(std::upper_bound(first_.begin(), first_.end(), index) - first_.begin()) - 1;
    return m == 0 ? centre() : on_ring(m, index - first_[m]);
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
    RingPoint p{.x = 0, .y = 0, .area = angle() / 2 * r * r, .full_area = pi * r * r};
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
                .full_area = step * (uncut * uncut - inner * inner) / 2};
    if (start) p.x = r, p.y = 0;
    if (end && rings_.sector == Sector::half) p.x = -r, p.y = 0;
    if (end && rings_.sector == Sector::quarter) p.x = 0, p.y = r;
    if (start || end) add_cut(p, start, outer - inner);
    if (outermost) {
      const double from = start ? theta : theta - step / 2, to = end ? theta : theta + step / 2;
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

Rings rings_from(const Table& cloud) {
  Rings r;
  r.radius = cloud.number("radius");
  if (!(r.radius > 0))
    cloud.refuse("radius", fmt::format("a radius of {} m is not positive", r.radius), "give a positive one");
  if (cloud.has("rings") == cloud.has("spacing"))
    cloud.refuse(cloud.has("rings") ? "spacing" : "",
                 cloud.has("rings") ? "both rings and spacing were given" : "neither rings nor spacing was given",
                 "give one of the two");
  if (cloud.has("rings") && cloud.integer("rings") < 1)
    cloud.refuse("rings", fmt::format("{} rings", cloud.integer("rings")), "give at least 1");
  r.rings = static_cast<int>(cloud.has("rings") ? cloud.integer("rings")
                                                : intervals(cloud, r.radius, cloud.number("spacing")));
  const std::string sector = cloud.text("sector");
  r.sector = sector == "full" ? Sector::full : sector == "half" ? Sector::half : Sector::quarter;
  return r;
}

}  // namespace

Points make_rings(MPI_Comm comm, const Rings& rings) {
  refuse_too_many(comm, std::pow(rings.rings, 2.0) * std::max(1, rings.levels));  // at least that many
  const RingLattice lattice(rings);
  const bool solid = rings.levels > 0;
  const int levels = solid ? rings.levels : 1;
  const double dz = solid ? rings.height / (levels - 1) : rings.thickness;

  Points out;
  out.dimension = solid ? 3 : 2;
  out.nearest_volumes = false;
  out.section = solid ? 1 : rings.thickness;
  out.exact.volume = lattice.angle() / 2 * rings.radius * rings.radius * (solid ? rings.height : rings.thickness);
  out.faces = {"side"};
  if (solid) out.faces.insert(out.faces.end(), {"bottom", "top"});
  const int bottom = 1, top = 2, cut1 = static_cast<int>(out.faces.size()), cut2 = cut1 + 1;
  if (rings.sector != Sector::full) out.faces.push_back("cut1");
  if (rings.sector == Sector::quarter) out.faces.push_back("cut2");

  const Slice mine = slice(comm, lattice.count() * levels);
  out.points.reserve(mine.end - mine.begin);
  for (std::int64_t id = mine.begin; id < mine.end; ++id) {
    const std::int64_t level = id / lattice.count();
    const RingPoint p = lattice.point(id % lattice.count());
    const bool lowest = solid && level == 0, highest = solid && level == levels - 1;
    const double height = lowest || highest ? dz / 2 : dz;
    const double z = !solid ? 0 : highest ? rings.height : static_cast<double>(level) * dz;
    out.points.push_back({.id = id,
                          .x = {p.x, p.y, z},
                          .volume = p.area * height,
                          .full_volume = p.full_area * dz,
                          .spacing = solid ? std::max(lattice.dr(), dz) : lattice.dr()});
    if (p.arc > 0) out.add_patch(0, p.arc * height, p.arc_normal, height * p.arc_vector);
    if (lowest) out.add_patch(bottom, p.area, {0, 0, -1});
    if (highest) out.add_patch(top, p.area, {0, 0, 1});
    if (p.cut1 > 0) out.add_patch(cut1, p.cut1 * height, {0, -1, 0});
    if (p.cut2 > 0) out.add_patch(cut2, p.cut2 * height, {-1, 0, 0});
  }
  return out;
}

namespace {

Points disc_from(MPI_Comm comm, const Table& cloud) {
  Rings r = rings_from(cloud);
  r.thickness = section_of(cloud, 2);
  return make_rings(comm, r);
}

Points cylinder_from(MPI_Comm comm, const Table& cloud) {
  Rings r = rings_from(cloud);
  section_of(cloud, 3);
  r.height = cloud.number("height");
  if (!(r.height > 0))
    cloud.refuse("height", fmt::format("a height of {} m is not positive", r.height), "give a positive one");
  if (!cloud.has("levels") && !cloud.has("spacing"))
    cloud.refuse("", "the levels of points over the height are missing",
                 "give levels, or spacing instead of rings and levels");
  r.levels = static_cast<int>(cloud.has("levels") ? cloud.integer("levels")
                                                  : intervals(cloud, r.height, cloud.number("spacing")) + 1);
  if (r.levels < 2) cloud.refuse("levels", fmt::format("{} levels", r.levels), "give at least 2: bottom and top");
  return make_rings(comm, r);
}

/// Of a disc; a cylinder has more.
std::vector<Key> disc_keys() {
  return {{"radius", Kind::quantity, "m", required, "Radius."},
          {"rings", Kind::integer, "", optional,
           "Rings of points around the centre, 6 m points on ring m; the last lies on the side."},
          {"spacing", Kind::quantity, "m", optional, "Distance of the rings, instead of their number."},
          {"sector",
           Kind::choice,
           "",
           "full",
           "The whole, or a part of it with points on the cuts (planes of symmetry).",
           {"full", "half", "quarter"}}};
}

std::vector<Key> cylinder_keys() {
  std::vector<Key> keys = disc_keys();
  keys.push_back({"height", Kind::quantity, "m", required, "Height, from z = 0 (bottom) up."});
  keys.push_back({"levels", Kind::integer, "", optional,
                  "Layers of points over the height, bottom and top included; from spacing if absent."});
  return keys;
}

}  // namespace

CloudShape disc_shape() {
  return {.name = "disc",
          .sentence =
              "A disc of concentric rings around the origin. Faces: side; of sectors also cut1 (y = 0) and cut2 "
              "(x = 0)",
          .keys = disc_keys(),
          .make = disc_from};
}

CloudShape cylinder_shape() {
  return {.name = "cylinder",
          .sentence =
              "A cylinder around the z axis by rings. Faces: side, bottom, top; of sectors also cut1 (y = 0) "
              "and cut2 (x = 0)",
          .keys = cylinder_keys(),
          .make = cylinder_from};
}

}  // namespace calor
