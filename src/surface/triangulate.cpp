#include "surface/triangulate.hpp"

#include <algorithm>
#include <numeric>

#include "surface/plane.hpp"

namespace calor {
namespace {

/// One polygon of corners, counter-clockwise, from which ears are cut. A corner at the end of a bridge comes twice.
class Loop {
 public:
  explicit Loop(const Outline& outline) {
    for (const Contour& contour : outline.contours) {
      std::vector<int>& corners = holes_.emplace_back(contour.corner.size());
      std::iota(corners.begin(), corners.end(), static_cast<int>(at_.size()));
      at_.insert(at_.end(), contour.corner.begin(), contour.corner.end());
    }
    loop_ = holes_.front();
    holes_.erase(holes_.begin());
    // The hole that reaches farthest goes first: nothing but the loop lies beyond it.
    const auto farthest = [&](const std::vector<int>& hole) { return at_[hole.front()].x; };
    for (std::vector<int>& hole : holes_)
      std::rotate(hole.begin(), std::ranges::max_element(hole, {}, [&](int corner) { return at_[corner].x; }),
                  hole.end());
    std::ranges::stable_sort(holes_, std::greater(), farthest);
  }

  std::vector<std::array<int, 3>> triangles() {
    for (std::size_t n = 0; n < holes_.size(); ++n) bridge(n);
    std::vector<std::array<int, 3>> out;
    out.reserve(loop_.size());
    std::size_t place = 0, refused = 0;
    // Rounding may hide all ears of a polygon that nearly touches itself; then looser ones are cut. Whatever is cut,
    // the triangles close the polygon and their areas add up to its own.
    for (Ear ear = Ear::proper; loop_.size() > 3;) {
      place %= loop_.size();
      if (is_ear(place, ear)) {
        out.push_back(triangle(place));
        loop_.erase(loop_.begin() + static_cast<std::ptrdiff_t>(place));
        ++place;  // ears side by side would make a fan of slivers
        refused = 0, ear = Ear::proper;
      } else if (++place, ++refused == loop_.size()) {
        ear = ear == Ear::proper ? Ear::flat : Ear::any;
        refused = 0;
      }
    }
    out.push_back(triangle(1));
    return out;
  }

 private:
  enum class Ear { proper, flat, any };

  int corner(std::size_t place) const { return loop_[place % loop_.size()]; }
  std::array<int, 3> triangle(std::size_t place) const {
    return {corner(place + loop_.size() - 1), corner(place), corner(place + 1)};
  }

  /// Can the corner be cut off? Proper ears have an area and no corner of the loop within or on their edges.
  bool is_ear(std::size_t place, Ear kind) const {
    if (kind == Ear::any) return true;
    const auto [p, q, r] = triangle(place);
    const Vec3 &a = at_[p], &b = at_[q], &c = at_[r];
    const double area = orientation(a, b, c);
    if (kind == Ear::proper ? !(area > 0) : !(area >= 0)) return false;
    const double low = std::min({a.x, b.x, c.x}), high = std::max({a.x, b.x, c.x});
    for (const int other : loop_) {
      const Vec3& x = at_[other];
      if (x.x < low || x.x > high || other == p || other == q || other == r) continue;
      const double least = std::min({orientation(a, b, x), orientation(b, c, x), orientation(c, a, x)});
      if (kind == Ear::proper ? least >= 0 : least > 0) return false;
    }
    return true;
  }

  /// Does the way from the corner before `b` over b to the one after it leave x on the inner side, as seen from b?
  bool looks_inwards(int before, int b, int after, const Vec3& x) const {
    const Vec3 &p = at_[before], &q = at_[b], &r = at_[after];
    if (orientation(p, q, r) > 0) return orientation(p, q, x) > 0 && orientation(q, r, x) > 0;
    return !(orientation(p, q, x) <= 0 && orientation(q, r, x) <= 0);
  }

  /// Does the segment between the corners m and v meet the polygon elsewhere?
  bool is_blocked(int m, int v, const std::vector<int>& polygon) const {
    for (std::size_t n = 0; n < polygon.size(); ++n) {
      const int a = polygon[n], b = polygon[(n + 1) % polygon.size()];
      const auto lies_on_it = [&](int other) {
        return other != m && other != v && orientation(at_[m], at_[v], at_[other]) == 0 &&
               is_between(at_[m], at_[v], at_[other]);
      };
      const bool shares_an_end = a == m || a == v || b == m || b == v;
      if (shares_an_end ? lies_on_it(a) || lies_on_it(b) : segments_meet(at_[m], at_[v], at_[a], at_[b])) return true;
    }
    return false;
  }

  bool is_visible(std::size_t hole, std::size_t place) const {
    const int m = holes_[hole].front(), v = loop_[place];
    const auto [before, at, after] = triangle(place);
    if (!looks_inwards(before, at, after, at_[m]) || is_blocked(m, v, loop_)) return false;
    for (std::size_t n = hole; n < holes_.size(); ++n)
      if (is_blocked(m, v, holes_[n])) return false;
    return true;
  }

  /// Joins the hole to the loop by an edge there and back, from its first corner to the nearest one that it sees.
  void bridge(std::size_t hole) {
    const std::vector<int>& corners = holes_[hole];
    std::vector<std::size_t> places(loop_.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    std::ranges::stable_sort(places, {}, [&](std::size_t n) { return norm(at_[loop_[n]] - at_[corners.front()]); });
    const auto seen = std::ranges::find_if(places, [&](std::size_t n) { return is_visible(hole, n); });
    const std::size_t place = seen == places.end() ? places.front() : *seen;
    std::vector<int> way = corners;
    way.push_back(corners.front());
    way.push_back(loop_[place]);
    loop_.insert(loop_.begin() + static_cast<std::ptrdiff_t>(place) + 1, way.begin(), way.end());
  }

  std::vector<Vec3> at_;
  std::vector<int> loop_;
  std::vector<std::vector<int>> holes_;
};

}  // namespace

std::vector<std::array<int, 3>> triangulate(const Outline& outline) { return Loop(outline).triangles(); }

}  // namespace calor
