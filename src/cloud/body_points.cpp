#include "cloud/body_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cloud/cells.hpp"
#include "cloud/lattice.hpp"

namespace calor {
namespace {

/// Points nearer than this, in spacings, become one.
constexpr double merged = 0.4;
/// Least distances of points thrown at random, in spacings, at which they stand for one spacing each once no more find
/// room: 1.44 r^2 on a surface and 1.37 r^3 in space (random sequential packing leaves 45 % and 62 % empty).
constexpr double apart_on_surface = 0.83, apart_in_space = 0.9;
/// Lattice points keep this distance from the surface.
constexpr double margin = 0.55;
/// Throws for every point that is expected.
constexpr int throws = 16;

class Placer {
 public:
  Placer(const Body& body, const SpacingField& spacing, std::uint64_t seed, const Vec3& low)
      : body_(body),
        surface_(body.facets()),
        features_(body.features()),
        spacing_(spacing),
        seed_(seed),
        low_(low),
        out_{PointGrid(low), {}, {}} {}

  void place_corners() {
    for (const auto& corner : features_.corners) add_to_line(surface_.vertices[corner.vertex], corner.facets);
  }

  void place_along_lines() {
    for (const auto& line : features_.lines) place_along(line);
  }

  /// Nodes of the lattice that lie on a patch.
  void place_nodes(const std::vector<Box>& boxes) {
    if (!spacing_.is_uniform || surface_.dimension == 2) return;
    for (const Box& box : boxes) {
      if (!box.is_cut && !body_.has_interfaces()) continue;
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 x = box.low + box.size * Vec3{double(corner & 1), double(corner >> 1 & 1), double(corner >> 2)};
        if (const auto near = body_.facet_tree().closest(x, 1e-6 * box.size)) add_to_patch(x, near->facet, 0.7);
      }
    }
  }

  void throw_on_patches() {
    if (surface_.dimension == 2) return;
    std::vector<std::vector<int>> facets(features_.count);
    for (std::size_t f = 0; f < features_.patch.size(); ++f) facets[features_.patch[f]].push_back(static_cast<int>(f));
    for (const auto& of_patch : facets) throw_on(of_patch);
  }

  /// Nodes of the lattice inside the body, off the surface.
  void fill_with_lattice(const std::vector<Box>& boxes) {
    for (const Box& box : boxes) {
      const Vec3& x = box.low;
      if (body_.facet_tree().closest(x, margin * box.size) || (box.is_cut && !body_.tree().is_inside(x))) continue;
      add_inside(x, box.size, margin, true);
    }
  }

  void throw_inside(const std::vector<Box>& boxes) {
    const int D = surface_.dimension, tries = D == 3 ? 2 * throws : throws;
    const double apart = D == 3 ? apart_in_space : apart_on_surface;
    std::uint64_t counter = 0;
    for (int round = 0; round < tries; ++round) {
      for (const Box& box : boxes) {
        Vec3 x = box.low;
        const Vec3 random = hashed_uniform(seed_ + 1, counter++);
        for (int a = 0; a < D; ++a) x[a] += box.size * random[a];
        const double d = spacing_.at(x);
        if (body_.facet_tree().closest(x, margin * d) || (box.is_cut && !body_.tree().is_inside(x))) continue;
        add_inside(x, d, apart, false);
      }
    }
  }

  /// Lets the points inside push each other apart, so that their distances become more alike. Those on the surface
  /// stay, and so does the lattice away from it.
  void relax() {
    constexpr int sweeps = 20;
    constexpr double beside_walls = 2;  // in spacings
    std::vector<char> moves(out_.grid.count(), 0);
    for (int i = out_.on_surface(); i < out_.grid.count(); ++i)
      moves[i] = !out_.is_lattice[i] || body_.facet_tree().closest(out_.grid.x(i), beside_walls * out_.grid.spacing(i));
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      PointGrid moved(low_);
      for (int i = 0; i < out_.grid.count(); ++i) {
        const Vec3 x = moves[i] ? pushed(i) : out_.grid.x(i);
        const bool has_moved = norm(x - out_.grid.x(i)) > 1e-9 * out_.grid.spacing(i);
        if (has_moved) out_.is_lattice[i] = 0;
        moved.add(has_moved ? x : out_.grid.x(i), has_moved ? spacing_.at(x) : out_.grid.spacing(i));
      }
      out_.grid = std::move(moved);
    }
  }

  BodyPoints take() { return std::move(out_); }

 private:
  /// Adds a point of a corner or line, which lies on the patches of some facets. Where another of one of them is near
  /// and no void between them, that one lies on all these patches.
  void add_to_line(const Vec3& x, const std::vector<int>& facets) {
    const double d = spacing_.at(x);
    int near = -1;
    double least = merged * d * merged * d;
    out_.grid.for_each_within(x, merged, [&](int j, double square) {
      if (square < least && are_beside(j, facets) && are_connected(x, out_.grid.x(j), d)) least = square, near = j;
    });
    if (near < 0) near = add(x, d);
    for (const int f : facets) put_on(near, f);
  }

  /// Does the point lie on the patch of one of the facets, on the same side of it?
  bool are_beside(int point, const std::vector<int>& facets) const {
    return std::ranges::any_of(facets, [&](int f) {
      return std::ranges::any_of(out_.on[point], [&](const BodyPoints::OnPatch& on) {
        return on.patch == features_.patch[f] && dot(on.normal, features_.normal[f]) > 0;
      });
    });
  }

  /// Does the straight way between two places on walls run through the body? One patch may lie on both sides of a slot.
  /// A void less deep than points that merge are apart is a detail that they lose.
  bool are_connected(const Vec3& a, const Vec3& b, double spacing) const {
    return std::ranges::any_of(std::array{Body::skin, merged}, [&](double depth) {
      return body_.sees(body_.moved_inside(a, depth * spacing), body_.moved_inside(b, depth * spacing));
    });
  }

  /// Where the points around push point i to, not nearer to the surface than lattice points are.
  Vec3 pushed(int i) const {
    constexpr double reach = 1.4, step = 0.3, farthest = 0.15;  // in spacings; the lattice stays as it is
    const Vec3 x = out_.grid.x(i);
    const double d = out_.grid.spacing(i);
    Vec3 push;
    out_.grid.for_each_within(x, 1.5 * reach, [&](int j, double square) {
      const double q = std::sqrt(square) / (0.5 * (d + out_.grid.spacing(j)));
      if (q < reach && j != i) push += (1 - q / reach) * (1 - q / reach) / std::sqrt(square) * (x - out_.grid.x(j));
    });
    if (norm(push) == 0) return x;
    const Vec3 to = x + (d * std::min(step, farthest / norm(push))) * push;
    return body_.facet_tree().closest(to, margin * d) ? x : to;
  }

  int add(const Vec3& x, double spacing) {
    out_.on.emplace_back();
    out_.is_lattice.push_back(0);
    return out_.grid.add(x, spacing);
  }

  /// At the tip of a cone a point lies on several sides of one patch.
  void put_on(int point, int facet) {
    constexpr double same_side = 0.866;  // cosine of 30 degrees
    auto& on = out_.on[point];
    const int patch = features_.patch[facet];
    const Vec3& normal = features_.normal[facet];
    const auto is_there = [&](const BodyPoints::OnPatch& p) {
      return p.patch == patch && dot(p.normal, normal) > same_side;
    };
    if (std::ranges::none_of(on, is_there)) on.push_back({patch, normal});
  }

  void place_along(const Features::Line& line) {
    const int sides = static_cast<int>(line.facets.size() / (line.vertices.size() - 1));
    // Places at fine steps, with the number of spacings up to them.
    struct Place {
      Vec3 x;
      double spacings;
      std::size_t step;
    };
    std::vector<Place> places;
    double sum = 0;
    for (std::size_t s = 0; s + 1 < line.vertices.size(); ++s) {
      const Vec3 a = surface_.vertices[line.vertices[s]], ab = surface_.vertices[line.vertices[s + 1]] - a;
      const double length = norm(ab);
      const int parts = std::max(1, static_cast<int>(std::ceil(2 * length / spacing_.at(a + 0.5 * ab))));
      for (int p = 0; p < parts; ++p) {
        places.push_back({a + (double(p) / parts) * ab, sum, s});
        sum += length / parts / spacing_.at(a + ((p + 0.5) / parts) * ab);
      }
    }
    places.push_back({surface_.vertices[line.vertices.back()], sum, line.vertices.size() - 2});
    const bool is_closed = line.vertices.front() == line.vertices.back();
    const int count = std::max(is_closed ? 3 : 1, static_cast<int>(std::lround(sum)));
    std::size_t at = 0;
    for (int n = is_closed ? 0 : 1; n < count; ++n) {
      const double wanted = sum * n / count;
      while (at + 2 < places.size() && places[at + 1].spacings <= wanted) ++at;
      const Place &a = places[at], &b = places[at + 1];
      const double part = b.spacings > a.spacings ? (wanted - a.spacings) / (b.spacings - a.spacings) : 0;
      const auto first = line.facets.begin() + static_cast<std::ptrdiff_t>(sides * a.step);
      add_to_line(a.x + part * (b.x - a.x), {first, first + sides});
    }
  }

  /// Adds a point on a facet unless another of its patch is nearer than `apart` spacings.
  void add_to_patch(const Vec3& x, int facet, double apart) {
    const int patch = features_.patch[facet];
    const double d = spacing_.at(x);
    bool has_room = true;
    out_.grid.for_each_within(x, 1.5 * apart, [&](int j, double square) {
      const double limit = apart * 0.5 * (d + out_.grid.spacing(j));
      if (square < limit * limit &&
          std::ranges::find(out_.on[j], patch, &BodyPoints::OnPatch::patch) != out_.on[j].end())
        has_room = false;
    });
    if (has_room) put_on(add(x, d), facet);
  }

  void throw_on(const std::vector<int>& facets) {
    std::vector<double> expected;  // points up to every facet, summed
    double sum = 0;
    for (const int f : facets) {
      const double d = spacing_.at(surface_.centroid(f));
      expected.push_back(sum += norm(surface_.area(f)) / (d * d));
    }
    const auto count = static_cast<std::int64_t>(std::ceil(throws * sum));
    for (std::int64_t n = 0; n < count; ++n) {
      const Vec3 random = hashed_uniform(seed_, counter_++);
      const auto found = std::ranges::upper_bound(expected, random.x * sum);
      const int f = facets[std::min<std::size_t>(found - expected.begin(), facets.size() - 1)];
      double u = random.y, v = random.z;
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const auto& vertex = surface_.facets[f].vertex;
      const Vec3& a = surface_.vertices[vertex[0]];
      add_to_patch(a + u * (surface_.vertices[vertex[1]] - a) + v * (surface_.vertices[vertex[2]] - a), f,
                   apart_on_surface);
    }
  }

  /// Adds a point inside the body unless another is nearer than `apart` spacings.
  void add_inside(const Vec3& x, double d, double apart, bool is_lattice) {
    bool has_room = true;
    out_.grid.for_each_within(x, 1.5 * apart, [&](int j, double square) {
      if (is_lattice && j >= out_.on_surface()) return;
      const double limit = apart * 0.5 * (d + out_.grid.spacing(j));
      if (square < limit * limit) has_room = false;
    });
    if (!has_room) return;
    out_.grid.add(x, d);
    out_.is_lattice.push_back(is_lattice);
  }

  const Body& body_;
  const Surface& surface_;
  const Features& features_;
  const SpacingField& spacing_;
  const std::uint64_t seed_;
  const Vec3 low_;
  std::uint64_t counter_ = 0;
  BodyPoints out_;
};

/// Splits a cube into boxes no longer than the spacing.
void split(const Body& body, const SpacingField& spacing, const Box& box, std::vector<Box>& out) {
  const int D = body.surface().dimension;
  Vec3 middle = box.low, high = box.low;
  for (int a = 0; a < D; ++a) middle[a] += 0.5 * box.size, high[a] += box.size;
  Box here = box;
  if (box.is_cut && !body.tree().touches(box.low, high)) {
    if (!body.tree().is_inside(middle)) return;
    here.is_cut = false;
  }
  if (box.size <= (1 + 1e-9) * spacing.at(middle)) {
    out.push_back(here);
    return;
  }
  for (int child = 0; child < 1 << D; ++child) {
    Box part{.low = box.low, .size = 0.5 * box.size, .is_cut = here.is_cut};
    for (int a = 0; a < D; ++a) part.low[a] += (child >> a & 1) * part.size;
    split(body, spacing, part, out);
  }
}

}  // namespace

std::vector<Box> cover(const Body& body, const SpacingField& spacing) {
  const Bounds bounds = bounds_of(body.surface().vertices);
  const Vec3 extent = bounds.high - bounds.low, middle = 0.5 * (bounds.low + bounds.high);
  const int D = body.surface().dimension;
  const double longest = std::max({extent.x, extent.y, extent.z});
  double size = longest;
  Vec3 low = bounds.low;
  if (spacing.is_uniform) {
    const double d = spacing.at(middle);
    int levels = 0;
    while (d * (1 << levels) < longest * (1 - 1e-9)) ++levels;
    size = d * (1 << levels);
    for (int a = 0; a < D; ++a) {
      const double cells = std::ceil(extent[a] / d - 1e-6);
      low[a] = middle[a] - 0.5 * cells * d;
    }
  }
  std::vector<Box> boxes;
  split(body, spacing, {.low = low, .size = size, .is_cut = true}, boxes);
  return boxes;
}

BodyPoints make_points(const Body& body, const SpacingField& spacing, const std::vector<Box>& boxes,
                       std::uint64_t seed) {
  Placer placer(body, spacing, seed, bounds_of(body.surface().vertices).low);
  placer.place_corners();
  placer.place_along_lines();
  placer.place_nodes(boxes);
  placer.throw_on_patches();
  if (spacing.is_uniform)
    placer.fill_with_lattice(boxes);
  else
    placer.throw_inside(boxes);
  placer.relax();
  return placer.take();
}

}  // namespace calor
