#include "surface/surface_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "surface/facet_queries.hpp"

namespace calor {
namespace {

constexpr int leaf_size = 4;  ///< facets
/// Levels that are split as the heuristic says; below them halves, so that no tree is deeper than the stack of a query.
constexpr int heuristic_levels = 60, stack_size = heuristic_levels + 36;
/// A box of the hierarchy counts as a dipole from so many of its radii.
constexpr double beta = 2.6;

/// Lowest and highest coordinates.
struct Extent {
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};

  void add(const Vec3& x) {
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  }
  void add(const Extent& other) { add(other.low), add(other.high); }
  /// Chance that a line meets the box, up to a factor: half its surface, in the plane half its perimeter.
  double measure(int dimension) const {
    const Vec3 d = high - low;
    if (!(d.x >= 0)) return 0;
    return dimension == 2 ? d.x + d.y : d.x * d.y + d.y * d.z + d.z * d.x;
  }
};

struct Box {
  Vec3 centre, half;

  /// Square of the distance of a place.
  double gap2(const Vec3& x) const {
    // The positive part of d is (d + |d|) / 2: without a branch, that processors would often guess wrong.
    const Vec3 d{std::abs(x.x - centre.x) - half.x, std::abs(x.y - centre.y) - half.y,
                 std::abs(x.z - centre.z) - half.z};
    const Vec3 twice{d.x + std::abs(d.x), d.y + std::abs(d.y), d.z + std::abs(d.z)};
    return 0.25 * dot(twice, twice);
  }
  bool overlaps(const Box& other) const {
    const Vec3 d = other.centre - centre;
    return std::abs(d.x) <= half.x + other.half.x && std::abs(d.y) <= half.y + other.half.y &&
           std::abs(d.z) <= half.z + other.half.z;
  }
  /// Does the segment of this middle and half length along every axis meet the box? By separating axes: there is
  /// nothing to divide by.
  bool meets(const Vec3& middle, const Vec3& along, const Vec3& reach) const {
    const Vec3 m = middle - centre;
    if (std::abs(m.x) > half.x + reach.x || std::abs(m.y) > half.y + reach.y || std::abs(m.z) > half.z + reach.z)
      return false;
    const Vec3 n = cross(along, m);
    return std::abs(n.x) <= half.y * reach.z + half.z * reach.y &&
           std::abs(n.y) <= half.z * reach.x + half.x * reach.z && std::abs(n.z) <= half.x * reach.y + half.y * reach.x;
  }
};

/// Nodes stand in the order of a walk that takes the left child first, so the left child of n is n + 1.
struct alignas(64) Node {  // one line of the cache
  Box box;
  std::int32_t next;          ///< the node after all below this one
  std::int32_t right;         ///< right child
  std::int32_t first, count;  ///< facets of a leaf; count = 0: no leaf
};

/// What a node is from far away.
struct Dipole {
  Vec3 centre, area;
  double near2;  ///< square of the distance within which it is no dipole, m^2
};

}  // namespace

class SurfaceTree::Impl {
 public:
  explicit Impl(const Surface& surface) : dimension_(surface.dimension), facet_(surface.facets.size()) {
    Extent all;
    std::vector<Vec3> centroid(facet_.size());
    for (std::size_t f = 0; f < facet_.size(); ++f) {
      centroid[f] = surface.centroid(static_cast<int>(f));
      for (const Vec3& x : corners_of(surface, static_cast<int>(f))) all.add(x);
    }
    if (facet_.empty()) return;
    std::iota(facet_.begin(), facet_.end(), 0);
    // Boxes are wider than their facets by more than the round-off of the questions to them.
    padding_ = 1e-14 * (norm(all.high - all.low) + norm(all.high) + norm(all.low));
    build(surface, centroid, 0, static_cast<std::int32_t>(facet_.size()), 0);
    corners_.reserve(facet_.size());
    for (const std::int32_t f : facet_) corners_.push_back(corners_of(surface, f));
  }

  double winding_number(const Vec3& x) const {
    double sum = 0;
    const auto count = static_cast<std::int32_t>(nodes_.size());
    for (std::int32_t n = 0; n < count;) {
      const Dipole& dipole = dipoles_[n];
      const Vec3 d = dipole.centre - x;
      const double r2 = dot(d, d);
      if (r2 > dipole.near2) {
        sum += dot(dipole.area, d) / (dimension_ == 2 ? r2 : r2 * std::sqrt(r2));
        n = nodes_[n].next;
        continue;
      }
      const Node& node = nodes_[n++];
      for (std::int32_t k = node.first; k < node.first + node.count; ++k)
        sum += dimension_ == 2 ? angle(corners_[k], x) : solid_angle(corners_[k], x);
    }
    return sum / (dimension_ == 2 ? 2 * std::numbers::pi : 4 * std::numbers::pi);
  }

  std::optional<Closest> closest(const Vec3& x, double bound) const {
    struct Waiting {
      std::int32_t node;
      double gap2;
    };
    std::array<Waiting, stack_size> stack;
    int waiting = 0;
    double least = bound * bound;
    std::int32_t facet = -1;
    Vec3 place;
    if (!nodes_.empty()) stack[waiting++] = {0, nodes_[0].box.gap2(x)};
    while (waiting > 0) {
      const Waiting now = stack[--waiting];
      if (!(now.gap2 < least)) continue;
      const Node& node = nodes_[now.node];
      for (std::int32_t k = node.first; k < node.first + node.count; ++k) {
        const Vec3 p = dimension_ == 2 ? closest_on_segment(corners_[k][0], corners_[k][1], x)
                                       : closest_on_triangle(corners_[k], x);
        if (const double r2 = dot(p - x, p - x); r2 < least) least = r2, facet = facet_[k], place = p;
      }
      if (node.count > 0) continue;
      Waiting near{now.node + 1, nodes_[now.node + 1].box.gap2(x)}, far{node.right, nodes_[node.right].box.gap2(x)};
      if (far.gap2 < near.gap2) std::swap(near, far);
      if (far.gap2 < least) stack[waiting++] = far;
      if (near.gap2 < least) stack[waiting++] = near;
    }
    if (facet < 0) return std::nullopt;
    return Closest{facet, place, std::sqrt(least)};
  }

  /// Whether `finds` (of a facet by its place in the leaves) holds of a facet that the segment crosses.
  template <class Finds>
  bool any_crossed(const Vec3& a, const Vec3& b, const Finds& finds) const {
    const Vec3 middle = 0.5 * (a + b), along = 0.5 * (b - a);
    const Vec3 reach{std::abs(along.x), std::abs(along.y), std::abs(along.z)};
    return any_facet([&](const Box& box) { return box.meets(middle, along, reach); },
                     [&](std::int32_t k) {
                       const Corners& c = corners_[k];
                       return (dimension_ == 2 ? segment_crossed(c[0], c[1], a, b) : triangle_crossed(c, a, b)) &&
                              finds(k);
                     });
  }

  bool is_crossed(const Vec3& a, const Vec3& b) const {
    return any_crossed(a, b, [](std::int32_t) { return true; });
  }

  std::vector<double> crossings(const Vec3& a, const Vec3& b) const {
    std::vector<double> found;
    any_crossed(a, b,
                [&](std::int32_t k) { return found.push_back(crossing_of(corners_[k], dimension_, a, b)), false; });
    return found;
  }

  bool touches(const Vec3& low, const Vec3& high) const {
    return any_facet_in(low, high, [](std::int32_t) { return true; });
  }

  std::vector<int> facets_in(const Vec3& low, const Vec3& high) const {
    std::vector<int> found;
    any_facet_in(low, high, [&](std::int32_t k) { return found.push_back(facet_[k]), false; });
    std::ranges::sort(found);
    return found;
  }

 private:
  /// Whether a facet (by its place in the leaves) is found in the boxes that `enters` lets through.
  template <class Enters, class Finds>
  bool any_facet(const Enters& enters, const Finds& finds) const {
    const auto count = static_cast<std::int32_t>(nodes_.size());
    for (std::int32_t n = 0; n < count;) {
      const Node& node = nodes_[n];
      if (!enters(node.box)) {
        n = node.next;
        continue;
      }
      for (std::int32_t k = node.first; k < node.first + node.count; ++k)
        if (finds(k)) return true;
      ++n;
    }
    return false;
  }

  /// The same among the facets whose boxes overlap a box.
  template <class Finds>
  bool any_facet_in(const Vec3& low, const Vec3& high, const Finds& finds) const {
    const Box asked{0.5 * (low + high), 0.5 * (high - low)};
    return any_facet([&](const Box& box) { return box.overlaps(asked); },
                     [&](std::int32_t k) {
                       Extent extent;
                       for (const Vec3& x : corners_[k]) extent.add(x);
                       return box_around(extent).overlaps(asked) && finds(k);
                     });
  }

  Box box_around(const Extent& extent) const {
    const Vec3 wider = 0.5 * (extent.high - extent.low) + Vec3{padding_, padding_, padding_};
    return {0.5 * (extent.low + extent.high), wider};
  }

  static Corners corners_of(const Surface& surface, int facet) {
    const auto& vertex = surface.facets[facet].vertex;
    return {surface.vertices[vertex[0]], surface.vertices[vertex[1]],
            surface.vertices[vertex[surface.dimension == 2 ? 1 : 2]]};
  }

  /// Adds the node of the facets facet_[begin .. end) and all below it.
  void build(const Surface& surface, const std::vector<Vec3>& centroid, std::int32_t begin, std::int32_t end,
             int level) {
    const auto me = static_cast<std::int32_t>(nodes_.size());
    nodes_.emplace_back();
    dipoles_.push_back(dipole_of(surface, centroid, begin, end));
    Extent extent, centres;
    for (std::int32_t k = begin; k < end; ++k) {
      for (const Vec3& x : corners_of(surface, facet_[k])) extent.add(x);
      centres.add(centroid[facet_[k]]);
    }
    Node node{.box = box_around(extent), .next = 0, .right = 0, .first = begin, .count = end - begin};
    if (node.count > leaf_size) {
      const std::int32_t middle = split(surface, centroid, begin, end, centres, level);
      build(surface, centroid, begin, middle, level + 1);
      node.right = static_cast<std::int32_t>(nodes_.size());
      build(surface, centroid, middle, end, level + 1);
      node.count = 0;
    }
    node.next = static_cast<std::int32_t>(nodes_.size());
    nodes_[me] = node;
  }

  Dipole dipole_of(const Surface& surface, const std::vector<Vec3>& centroid, std::int32_t begin,
                   std::int32_t end) const {
    Vec3 area, moment, mean;
    double total = 0, radius2 = 0;
    for (std::int32_t k = begin; k < end; ++k) {
      const Vec3 A = surface.area(facet_[k]);
      area += A;
      total += norm(A);
      moment += norm(A) * centroid[facet_[k]];
      mean += (1.0 / (end - begin)) * centroid[facet_[k]];
    }
    const Vec3 centre = total > 0 ? (1 / total) * moment : mean;
    for (std::int32_t k = begin; k < end; ++k)
      for (const Vec3& x : corners_of(surface, facet_[k])) radius2 = std::max(radius2, dot(x - centre, x - centre));
    return {centre, area, beta * beta * radius2};
  }

  /// Orders the facets in two parts and returns the first of the second: the parts for which number of facets times
  /// measure of the box is least, among 16 slices along the longest extent of the centroids.
  std::int32_t split(const Surface& surface, const std::vector<Vec3>& centroid, std::int32_t begin, std::int32_t end,
                     const Extent& centres, int level) {
    const Vec3 size = centres.high - centres.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto half = begin + (end - begin) / 2;
    const auto coordinate = [&](std::int32_t f) { return centroid[f][axis]; };
    if (level >= heuristic_levels || !(size[axis] > 0)) {
      std::nth_element(facet_.begin() + begin, facet_.begin() + half, facet_.begin() + end,
                       [&](int f, int g) { return coordinate(f) < coordinate(g); });
      return half;
    }
    constexpr int slices = 16;
    const auto slice = [&](std::int32_t f) {
      return std::min(slices - 1, static_cast<int>(slices * ((coordinate(f) - centres.low[axis]) / size[axis])));
    };
    struct Part {
      Extent extent;
      int count = 0;
      void add(const Part& other) { extent.add(other.extent), count += other.count; }
    };
    std::array<Part, slices> part, below;
    for (std::int32_t k = begin; k < end; ++k) {
      Part& p = part[slice(facet_[k])];
      for (const Vec3& x : corners_of(surface, facet_[k])) p.extent.add(x);
      ++p.count;
    }
    for (int s = 1; s < slices; ++s) {
      below[s] = below[s - 1];
      below[s].add(part[s - 1]);
    }
    int cut = 1;
    double least = std::numeric_limits<double>::infinity();
    Part above;
    const auto cost = [&](const Part& p) { return p.count * p.extent.measure(dimension_); };
    for (int s = slices - 1; s > 0; --s) {
      above.add(part[s]);
      // The first and the last slice have facets, so that neither part is empty.
      if (const double c = cost(below[s]) + cost(above); c < least) least = c, cut = s;
    }
    return static_cast<std::int32_t>(
        std::partition(facet_.begin() + begin, facet_.begin() + end, [&](std::int32_t f) { return slice(f) < cut; }) -
        facet_.begin());
  }

  int dimension_;
  double padding_ = 0;
  std::vector<std::int32_t> facet_;  ///< in the order of the leaves
  std::vector<Corners> corners_;     ///< of these
  std::vector<Node> nodes_;
  std::vector<Dipole> dipoles_;  ///< of the nodes
};

SurfaceTree::SurfaceTree(const Surface& surface) : impl_(std::make_unique<Impl>(surface)) {}
SurfaceTree::~SurfaceTree() = default;

double SurfaceTree::winding_number(const Vec3& x) const { return impl_->winding_number(x); }
std::optional<SurfaceTree::Closest> SurfaceTree::closest(const Vec3& x, double bound) const {
  return impl_->closest(x, bound);
}
bool SurfaceTree::is_crossed(const Vec3& a, const Vec3& b) const { return impl_->is_crossed(a, b); }
std::vector<double> SurfaceTree::crossings(const Vec3& a, const Vec3& b) const { return impl_->crossings(a, b); }
std::vector<int> SurfaceTree::facets_in(const Vec3& low, const Vec3& high) const { return impl_->facets_in(low, high); }
bool SurfaceTree::touches(const Vec3& low, const Vec3& high) const { return impl_->touches(low, high); }

}  // namespace calor
