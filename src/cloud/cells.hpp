#pragma once
// A regular grid of search cells over a set of points.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

struct Bounds {
  Vec3 low, high;
};
/// Smallest box around the points; low > high for none.
Bounds bounds_of(std::span<const Vec3> x);

/// Cells numbered along x first, then y, then z. Lattice points of the cell size lie in the middle of cells.
class Cells {
 public:
  /// Covers the points with cells of about `size`, enlarged where that would make many more cells than points.
  Cells(std::span<const Vec3> x, double size) : Cells(x, Vec3{size, size, size}) {}
  /// The same with a size along every axis.
  Cells(std::span<const Vec3> x, const Vec3& size);

  /// Cells along an axis.
  std::int64_t along(int axis) const { return along_[axis]; }
  std::int64_t count() const { return along_[0] * along_[1] * along_[2]; }
  /// Index along one axis, limited to the grid; never decreases with the coordinate.
  std::int64_t index(int axis, double coordinate) const {
    const double c = (coordinate - low_[axis]) * inverse_[axis] + 0.5;
    return c <= 0 ? 0 : c >= last_[axis] ? along_[axis] - 1 : static_cast<std::int64_t>(c);
  }
  std::int64_t cell(const Vec3& x) const {
    return index(0, x.x) + along_[0] * (index(1, x.y) + along_[1] * index(2, x.z));
  }

 private:
  Vec3 low_, inverse_ = {1, 1, 1};
  std::array<std::int64_t, 3> along_ = {1, 1, 1};
  std::array<double, 3> last_ = {0, 0, 0};
};

/// Points in the order of their cells: those of cell c are order[start[c]] .. order[start[c+1]]. Within a cell they
/// keep the order of `first`, or of the points where that is empty.
struct CellOrder {
  std::vector<std::int32_t> start, order;
};
CellOrder order_by_cells(const Cells& cells, std::span<const Vec3> x, std::span<const std::int32_t> first = {});

}  // namespace calor
