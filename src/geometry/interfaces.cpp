// What lies between two places of a body of several parts: the pieces of a segment, the planes it meets, and the normal
// of the interface it crosses.
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/parts.hpp"
#include "geometry/point_tags.hpp"
#include "surface/body.hpp"

namespace calor {

std::vector<TagPiece> Parts::tags_along(const Segment& segment) const {
  if (point_tags_) return point_tags_->along(segment.a, segment.b);
  return {{segment.tag_a, 0.5}, {segment.tag_b, 1}};
}

/// Where a segment meets interfaces that are known, sorted.
std::vector<double> Parts::crossings(const Segment& segment) const {
  std::vector<double> at;
  if (knows_interfaces() && !regions_.empty()) at = cloud_.solids->crossings(segment.a, segment.b);
  const int axis = layers_.axis;
  if (axis >= 0 && segment.a[axis] != segment.b[axis]) {
    for (std::size_t n = 0; n + 1 < layers_.top.size(); ++n) {
      const double plane = layers_.start + layers_.top[n];
      const double s = (plane - segment.a[axis]) / (segment.b[axis] - segment.a[axis]);
      if (s > 0 && s < 1) at.push_back(s);
    }
  }
  std::ranges::sort(at);
  return at;
}

/// Places that tell the parts along a segment: its ends, and between its crossings; of interfaces that are not known
/// those that are wider than an eighth of a spacing are found.
std::vector<double> Parts::samples(const Segment& segment, std::span<const TagPiece> tags,
                                   std::span<const double> crossings) const {
  std::vector<double> s = {0, 1};
  const auto add_middle = [&](double begin, double end) { s.push_back(0.5 * (begin + end)); };
  for (std::size_t n = 0; n <= crossings.size(); ++n)
    add_middle(n == 0 ? 0 : crossings[n - 1], n < crossings.size() ? crossings[n] : 1);
  if (may_be_thin() && !knows_interfaces()) {
    const int equal_parts = 8 * segment.spacings;
    for (int n = 0; n < equal_parts; ++n) s.push_back((n + 0.5) / equal_parts);
  }
  if (point_tags_)
    for (double begin = 0; const TagPiece& piece : tags) add_middle(begin, piece.end), begin = piece.end;
  std::ranges::sort(s);
  return s;
}

/// The only known crossing of a segment between two of its places, or its end that lies on an interface.
std::optional<double> Parts::only_crossing(const Segment& segment, std::span<const double> crossings, double low,
                                           double high) const {
  constexpr double on = 1e-9;  // of the segment
  if (!knows_interfaces()) return std::nullopt;
  const auto first = std::ranges::lower_bound(crossings, low), end = std::ranges::upper_bound(crossings, high);
  if (end - first == 1) return *first;
  const Vec3 way = segment.b - segment.a;
  const auto is_on = [&](const Vec3& x) {
    return has_plane_between(x - on * way, x + on * way) ||
           (!regions_.empty() && cloud_.solids->interface_at(x, on * norm(way)));
  };
  if (first == end && low == 0 && is_on(segment.a)) return 0;
  if (first == end && high == 1 && is_on(segment.b)) return 1;
  return std::nullopt;
}

std::vector<char> Parts::lie_on_walls(std::span<const Segment> segments) const {
  std::vector<char> lie(segments.size(), has_formulas());
  if (!has_formulas() || !cloud_.body) return lie;
  const auto is_on_wall = [&](const Vec3& x) { return cloud_.body->tree().closest(x, skin_).has_value(); };
  for (std::size_t g = 0; g < segments.size(); ++g) lie[g] = is_on_wall(segments[g].a) || is_on_wall(segments[g].b);
  return lie;
}

Parts::Pieces Parts::along(std::span<const Segment> segments) const {
  /// Somewhere between two places of a segment one part ends and another begins.
  struct Change {
    std::size_t segment;
    double low, high;
    int part_low, part_high;
  };
  std::vector<Vec3> x, inside;
  std::vector<int> tags, part;
  std::vector<std::vector<TagPiece>> tags_of;
  const std::vector<char> on_walls = lie_on_walls(segments);
  const auto ask = [&](std::size_t segment, double s) {
    const Segment& g = segments[segment];
    x.push_back(s == 1 ? g.b : g.a + s * (g.b - g.a));
    inside.push_back(on_walls[segment] ? cloud_.off_walls(x.back(), skin_) : x.back());
    tags.push_back(std::ranges::find_if(tags_of[segment], [&](const TagPiece& p) { return s <= p.end; })->tag);
  };
  std::vector<std::vector<double>> places, known;
  for (std::size_t g = 0; g < segments.size(); ++g) {
    const Vec3 half = 0.5 * (segments[g].b - segments[g].a);
    tags_of.push_back(tags_along(segments[g]));
    const bool is_whole = is_one_around(segments[g].a + half, norm(half));
    known.push_back(is_whole ? std::vector<double>() : crossings(segments[g]));
    places.push_back(is_whole ? std::vector<double>{1} : samples(segments[g], tags_of.back(), known.back()));
    for (const double s : places.back()) ask(g, s);
  }
  part.resize(x.size());
  find(x, inside, tags, part);
  std::vector<Change> changes;
  for (std::size_t g = 0, n = 0; g < segments.size(); ++g)
    for (std::size_t k = 0; k < places[g].size(); ++k, ++n)
      if (k > 0 && part[n] != part[n - 1]) changes.push_back({g, places[g][k - 1], places[g][k], part[n - 1], part[n]});
  std::vector<int> last;
  for (std::size_t g = 0, n = 0; g < segments.size(); ++g) n += places[g].size(), last.push_back(part[n - 1]);

  std::vector<Change> exact;  // where a known interface alone can be what is looked for
  std::erase_if(changes, [&](const Change& c) {
    const std::optional<double> at = only_crossing(segments[c.segment], known[c.segment], c.low, c.high);
    if (at) exact.push_back({c.segment, *at, *at, c.part_low, c.part_high});
    return at.has_value();
  });
  for (int halving = 0; halving < 52 && !changes.empty(); ++halving) {
    x.clear(), inside.clear(), tags.clear();
    for (const Change& c : changes) ask(c.segment, 0.5 * (c.low + c.high));
    part.resize(x.size());
    find(x, inside, tags, part);
    for (std::size_t n = 0; n < part.size(); ++n) {
      Change& c = changes[n];
      const double middle = 0.5 * (c.low + c.high);
      if (part[n] == c.part_low) {
        c.low = middle;
        continue;
      }
      const Change rest{c.segment, middle, c.high, part[n], c.part_high};
      c.high = middle, c.part_high = part[n];
      if (part[n] != rest.part_high) changes.push_back(rest);  // a third part lies between (invalidates c)
    }
  }
  changes.insert(changes.end(), exact.begin(), exact.end());
  std::ranges::stable_sort(changes, [](const Change& a, const Change& b) {
    return std::pair(a.segment, a.low) < std::pair(b.segment, b.low);
  });
  Pieces pieces;
  auto change = changes.begin();
  for (std::size_t g = 0; g < segments.size(); ++g) {
    for (; change != changes.end() && change->segment == g; ++change)
      pieces.piece.push_back({change->part_low, 0.5 * (change->low + change->high)});
    pieces.piece.push_back({last[g], 1});
    pieces.row.push_back(static_cast<std::int64_t>(pieces.piece.size()));
  }
  return pieces;
}

bool Parts::has_plane_between(const Vec3& a, const Vec3& b) const {
  if (layers_.axis < 0) return false;
  const auto [low, high] = std::minmax({a[layers_.axis] - layers_.start, b[layers_.axis] - layers_.start});
  const auto above = std::ranges::lower_bound(layers_.top, low);
  return above != layers_.top.end() && *above <= high && above + 1 != layers_.top.end();
}

std::span<const double> Parts::curved_areas() const {
  if (!cloud_.solids || has_formulas()) return {};
  return cloud_.solids->curved_areas();
}

Parts::Interface Parts::interface_at(const Vec3& x, const Vec3& along, int tag, int part, int other,
                                     double size) const {
  const int layer_count = static_cast<int>(layers_.top.size());
  if (part < layer_count && other < layer_count) {
    Interface plane;
    plane.normal[layers_.axis] = 1;
    return plane;
  }
  if (cloud_.solids) {
    constexpr double on = 1e-6;  // of the size: the place was found by halving a segment
    if (const auto found = cloud_.solids->interface_at(x, on * size))
      return {found->normal, curved_areas().empty() ? -1 : found->piece};
  }
  if (point_tags_ && !may_be_thin()) return {point_tags_->normal_at(x)};
  return {normal_of_region(x, along, tag, size)};
}

Vec3 Parts::normal_of_region(const Vec3& x, const Vec3& along, int tag, double size) const {
  const Vec3 direction = (1 / norm(along)) * along;
  if (cloud_.dimension == 1) return direction;
  // Where lines beside the one through x cross the surface.
  const auto crossing = [&](const Vec3& beside) {
    double low = -0.5 * size, high = 0.5 * size;
    std::vector<int> found(2);
    const auto ask = [&](double a, double b) {
      const Vec3 places[] = {x + beside + a * direction, x + beside + b * direction};
      const int tags[] = {tag, tag};
      find(places, off_walls(places), tags, found);
    };
    ask(low, high);
    const int first = found[0];
    if (first == found[1]) return x + beside;
    for (int n = 0; n < 40; ++n) {
      const double middle = 0.5 * (low + high);
      ask(middle, middle);
      (found[0] == first ? low : high) = middle;
    }
    return x + beside + 0.5 * (low + high) * direction;
  };
  const Vec3 aside = std::abs(direction.z) < 0.9 && cloud_.dimension == 3 ? Vec3{0, 0, 1}
                     : cloud_.dimension == 3                              ? Vec3{1, 0, 0}
                                                                          : Vec3{0, 0, 1};
  const Vec3 t = (1 / norm(cross(direction, aside))) * cross(direction, aside);
  const double step = 1e-3 * size;
  const Vec3 on_t = crossing(step * t) - crossing(-step * t);
  if (cloud_.dimension == 2) {
    const Vec3 n{-on_t.y, on_t.x, 0};
    return (1 / norm(n)) * n;
  }
  const Vec3 u = cross(direction, t), on_u = crossing(step * u) - crossing(-step * u), n = cross(on_t, on_u);
  return (1 / norm(n)) * n;
}

}  // namespace calor
