#pragma once
// The points nearest to a place, however far they are (nanoflann's k-d tree).
#include <cstdint>
#include <nanoflann.hpp>
#include <span>

#include "base/vec3.hpp"

namespace calor {

class PointTree {
 public:
  /// The points must outlive this.
  explicit PointTree(std::span<const Vec3> x) : coordinates_{x}, tree_(3, coordinates_) {}

  /// Fills `index` and squares of distances, ascending; returns how many points there are, at most as asked for.
  std::size_t nearest(const Vec3& y, std::span<std::uint32_t> index, std::span<double> square) const {
    return tree_.knnSearch(&y.x, index.size(), index.data(), square.data());
  }
  std::size_t nearest(const Vec3& y) const {
    std::uint32_t index = 0;
    double square = 0;
    nearest(y, {&index, 1}, {&square, 1});
    return index;
  }

 private:
  struct Coordinates {
    std::span<const Vec3> x;
    std::size_t kdtree_get_point_count() const { return x.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const { return x[i][static_cast<int>(axis)]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };

  Coordinates coordinates_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Coordinates>, Coordinates, 3, std::uint32_t>
      tree_;
};

}  // namespace calor
