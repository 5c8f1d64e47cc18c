#include "surface/facet_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace calor {

Vec3 centroid(const FacetPiece& piece) {
  Vec3 sum;
  for (const Vec3& x : piece.corner) sum += x;
  return (1.0 / static_cast<double>(piece.corner.size())) * sum;
}

Vec3 area(const std::vector<Vec3>& corner) {
  Vec3 sum;
  for (std::size_t n = 1; n + 1 < corner.size(); ++n)
    sum += 0.5 * cross(corner[n] - corner[0], corner[n + 1] - corner[0]);
  return sum;
}

namespace {

/// Splits a polygon by the line through a segment in its plane, where the segment runs through it. `beside`: unit
/// vector in the plane, across the segment. Appends what lies there, and leaves the rest.
void split(FacetPiece& piece, const Vec3& p, const Vec3& q, const Vec3& beside, const Vec3& normal, double tolerance,
           std::vector<FacetPiece>& out) {
  const std::size_t n = piece.corner.size();
  std::vector<double> height;
  double least = 0, most = 0;
  for (const Vec3& x : piece.corner) {
    height.push_back(dot(beside, x - p));
    if (std::abs(height.back()) <= tolerance) height.back() = 0;
    least = std::min(least, height.back()), most = std::max(most, height.back());
  }
  if (least == 0 || most == 0) return;
  double begin = 0, end = 1;  // of the segment, within the polygon
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3& a = piece.corner[k];
    const Vec3 edge = piece.corner[(k + 1) % n] - a, inwards = cross(normal, edge);
    const double at_p = dot(inwards, p - a), at_q = dot(inwards, q - a);
    if (at_p < 0 && at_q < 0) return;
    if (at_p == at_q) continue;
    const double crossing = at_p / (at_p - at_q);
    if (at_p < at_q)
      begin = std::max(begin, crossing);
    else
      end = std::min(end, crossing);
  }
  if ((end - begin) * norm(q - p) <= tolerance) return;
  FacetPiece here{.corner = {}, .face = piece.face}, there = here;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t next = (k + 1) % n;
    if (height[k] <= 0) here.corner.push_back(piece.corner[k]);
    if (height[k] >= 0) there.corner.push_back(piece.corner[k]);
    if (height[k] * height[next] >= 0) continue;
    const double part = height[k] / (height[k] - height[next]);
    const Vec3 crossing = piece.corner[k] + part * (piece.corner[next] - piece.corner[k]);
    here.corner.push_back(crossing), there.corner.push_back(crossing);
  }
  piece = std::move(here);
  out.push_back(std::move(there));
}

/// Cuts facets in space along those of another surface.
class Cutter {
 public:
  Cutter(const FacetPiece& facet, double tolerance) : pieces_{facet}, tolerance_(tolerance) {
    const Vec3 A = area(facet.corner);
    origin_ = facet.corner[0];
    normal_ = (1 / norm(A)) * A;
  }

  void cut_by(const std::array<Vec3, 3>& other) {
    std::array<double, 3> height;
    for (int k = 0; k < 3; ++k) {
      height[k] = dot(normal_, other[k] - origin_);
      if (std::abs(height[k]) <= tolerance_) height[k] = 0;
    }
    if (height[0] == 0 && height[1] == 0 && height[2] == 0) {
      for (int k = 0; k < 3; ++k) cut_along(other[k], other[(k + 1) % 3]);
      return;
    }
    std::vector<Vec3> on;  // where the other facet meets the plane
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if (height[k] == 0) on.push_back(other[k]);
      if (height[k] * height[next] < 0)
        on.push_back(other[k] + height[k] / (height[k] - height[next]) * (other[next] - other[k]));
    }
    if (on.size() == 2) cut_along(on[0], on[1]);
  }

  std::vector<FacetPiece> take() { return std::move(pieces_); }

 private:
  void cut_along(const Vec3& p, const Vec3& q) {
    const double length = norm(q - p);
    if (length <= tolerance_) return;
    const Vec3 beside = (1 / length) * cross(normal_, q - p);
    std::vector<FacetPiece> more;
    for (FacetPiece& piece : pieces_) split(piece, p, q, beside, normal_, tolerance_, more);
    std::ranges::move(more, std::back_inserter(pieces_));
  }

  std::vector<FacetPiece> pieces_;
  double tolerance_;
  Vec3 origin_, normal_;
};

}  // namespace

std::vector<FacetPiece> cut_facet(const FacetPiece& facet, const std::vector<std::array<Vec3, 3>>& others,
                                  double tolerance) {
  if (others.empty() || norm(area(facet.corner)) == 0) return {facet};
  Cutter cutter(facet, tolerance);
  for (const auto& other : others) cutter.cut_by(other);
  return cutter.take();
}

std::vector<FacetPiece> cut_segment(const FacetPiece& facet, const std::vector<std::array<Vec3, 2>>& others,
                                    double tolerance) {
  const Vec3 &a = facet.corner[0], ab = facet.corner[1] - a;
  const double length = norm(ab);
  const Vec3 along = (1 / length) * ab, beside{-along.y, along.x, 0};
  std::vector<double> places = {0, length};
  for (const auto& [c, d] : others) {
    const double high_c = dot(beside, c - a), high_d = dot(beside, d - a);
    if (std::abs(high_c) <= tolerance) places.push_back(dot(along, c - a));
    if (std::abs(high_d) <= tolerance) places.push_back(dot(along, d - a));
    if (std::min(std::abs(high_c), std::abs(high_d)) > tolerance && (high_c < 0) != (high_d < 0))
      places.push_back(dot(along, c - a + high_c / (high_c - high_d) * (d - c)));
  }
  std::ranges::sort(places);
  std::vector<FacetPiece> pieces;
  double from = 0;
  for (const double to : places) {
    if (to <= from + tolerance || to > length) continue;
    const double end = length - to <= tolerance ? length : to;
    pieces.push_back(
        {.corner = {a + from * along, end == length ? facet.corner[1] : a + end * along}, .face = facet.face});
    from = end;
  }
  pieces.front().corner[0] = a;
  return pieces;
}

}  // namespace calor
