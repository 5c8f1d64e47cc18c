#pragma once
// Where the parts of a body begin and end if only its points know: at every place the tag of the nearest point counts.
#include <memory>
#include <span>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

class PointTree;

/// A piece of a segment from a to b: it lies around points of one tag and ends at `end`, a fraction of the way.
struct TagPiece {
  int tag;
  double end;
};

class PointTags {
 public:
  /// The points of all ranks, as pairs of two ranks must see the same on both; `tag`: of the local ones. Distances are
  /// in mean spacings along each axis, so that flat cells end where they meet. Collective.
  PointTags(const Cloud& cloud, std::span<const int> tag);
  ~PointTags();

  /// What a segment runs through, in order; thin parts are not missed.
  std::vector<TagPiece> along(const Vec3& a, const Vec3& b) const;
  /// Unit normal of the surface midway between the points nearest to x and the nearest ones of another tag.
  Vec3 normal_at(const Vec3& x) const;

 private:
  struct End {
    std::size_t point;  ///< the nearest one
    double s;
  };
  void divide(const Vec3& a, const Vec3& b, const End& from, const End& to, std::vector<TagPiece>& pieces) const;

  Vec3 size_ = {1, 1, 1};  ///< mean spacing along each axis, m
  std::vector<Vec3> x_;    ///< over size_
  std::vector<int> tag_;
  std::unique_ptr<const PointTree> tree_;
};

}  // namespace calor
