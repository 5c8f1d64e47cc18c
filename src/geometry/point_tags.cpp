#include "geometry/point_tags.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/point_tree.hpp"

namespace calor {

PointTags::PointTags(const Cloud& cloud, std::span<const int> tag) {
  struct Tagged {
    Vec3 x;
    int tag;
  };
  for (int a = 0; a < 3 && !cloud.isotropic; ++a) {
    std::vector<double> spacings;
    for (int i = 0; i < cloud.owned; ++i) spacings.push_back(cloud.metric[i][a]);
    size_[a] = sum(cloud.comm, spacings) / static_cast<double>(cloud.count);
  }
  std::vector<Tagged> points;
  for (int i = 0; i < cloud.owned; ++i) points.push_back({cloud.x[i], tag[i]});
  for (const Tagged& p : gather(cloud.comm, points)) x_.push_back(quotient(p.x, size_)), tag_.push_back(p.tag);
  tree_ = std::make_unique<const PointTree>(x_);
}

PointTags::~PointTags() = default;

std::vector<TagPiece> PointTags::along(const Vec3& a, const Vec3& b) const {
  const Vec3 from = quotient(a, size_), to = quotient(b, size_);
  std::vector<TagPiece> pieces;
  divide(from, to, {tree_->nearest(from), 0}, {tree_->nearest(to), 1}, pieces);
  pieces.push_back({tag_[tree_->nearest(to)], 1});
  return pieces;
}

/// Appends what ends between two places whose nearest points are known.
void PointTags::divide(const Vec3& a, const Vec3& b, const End& from, const End& to,
                       std::vector<TagPiece>& pieces) const {
  constexpr double round_off = 1e-9;
  if (from.point == to.point) return;
  // |a + s e - x|^2 is the same for both points at s.
  const Vec3 e = b - a, r_from = x_[from.point] - a, r_to = x_[to.point] - a;
  const double slope = 2 * dot(e, r_to - r_from), offset = dot(r_to, r_to) - dot(r_from, r_from);
  const double s = slope > 0 ? std::clamp(offset / slope, from.s, to.s) : to.s;
  const auto square = [&](std::size_t point) {
    const Vec3 r = s * e - (x_[point] - a);
    return dot(r, r);
  };
  const std::size_t between = tree_->nearest(a + s * e);
  if (square(between) < (1 - round_off) * std::min(square(from.point), square(to.point))) {
    divide(a, b, from, {between, s}, pieces);
    divide(a, b, {between, s}, to, pieces);
  } else if (tag_[from.point] != tag_[to.point]) {
    pieces.push_back({tag_[from.point], s});
  }
}

Vec3 PointTags::normal_at(const Vec3& x) const {
  constexpr double equal = 1 + 1e-6;  // of squares: at corners of cells several points are the nearest
  std::array<std::uint32_t, 64> index;
  std::array<double, 64> square;
  const std::size_t found = tree_->nearest(quotient(x, size_), index, square);
  const auto is_other = [&](std::uint32_t point) { return tag_[point] != tag_[index[0]]; };
  const auto first_other =
      static_cast<std::size_t>(std::find_if(index.begin(), index.begin() + found, is_other) - index.begin());
  // Of the points on both sides those that face each other.
  Vec3 normal;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < found && square[i] <= equal * square[0]; ++i) {
    for (std::size_t j = first_other; j < found && square[j] <= equal * square[first_other]; ++j) {
      const Vec3 r = x_[index[j]] - x_[index[i]];
      if (is_other(index[i]) || !is_other(index[j]) || dot(r, r) >= least) continue;
      least = dot(r, r);
      normal = quotient(r, size_);
    }
  }
  return (1 / norm(normal)) * normal;
}

}  // namespace calor
