#pragma once
// Points added one by one, each with a spacing of its own, and found by place.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

/// Points are kept in grids by their spacing, a factor of 2 each, so that a search costs what it finds.
class PointGrid {
 public:
  /// `low`: lowest corner of all places, m.
  explicit PointGrid(const Vec3& low) : low_(low) {}

  /// Returns the number of the point, from 0.
  int add(const Vec3& x, double spacing) {
    const int number = static_cast<int>(x_.size());
    x_.push_back(x), spacing_.push_back(spacing);
    const int level = static_cast<int>(std::ceil(std::log2(spacing)));
    Grid& grid = grids_[level];
    grid.largest = std::max(grid.largest, spacing);
    grid.cells[key(cell(x, std::exp2(level)))].push_back(number);
    return number;
  }

  int count() const { return static_cast<int>(x_.size()); }
  const Vec3& x(int point) const { return x_[point]; }
  double spacing(int point) const { return spacing_[point]; }

  /// Calls use(point, squared distance) for the points nearer to x than `spacings` times their own spacing.
  template <class Use>
  void for_each_within(const Vec3& x, double spacings, const Use& use) const {
    for (const auto& [level, grid] : grids_) {
      const double size = std::exp2(level), reach = spacings * grid.largest;
      const Vec3 r{reach, reach, reach};
      const Index low = cell(x - r, size), high = cell(x + r, size);
      Index c;
      for (c.z = low.z; c.z <= high.z; ++c.z)
        for (c.y = low.y; c.y <= high.y; ++c.y)
          for (c.x = low.x; c.x <= high.x; ++c.x) {
            const auto found = grid.cells.find(key(c));
            if (found == grid.cells.end()) continue;
            for (const int j : found->second) {
              const Vec3 way = x_[j] - x;
              const double square = dot(way, way), limit = spacings * spacing_[j];
              if (square < limit * limit) use(j, square);
            }
          }
    }
  }

 private:
  struct Index {
    std::int64_t x, y, z;
  };
  struct Grid {
    double largest = 0;  // spacing
    std::unordered_map<std::uint64_t, std::vector<int>> cells;
  };

  Index cell(const Vec3& x, double size) const {
    const Vec3 c = (1 / size) * (x - low_);
    return {static_cast<std::int64_t>(std::floor(c.x)), static_cast<std::int64_t>(std::floor(c.y)),
            static_cast<std::int64_t>(std::floor(c.z))};
  }
  /// 21 bits an axis; cells that share a key share a list, and distances tell them apart.
  static std::uint64_t key(const Index& c) {
    constexpr std::uint64_t low_bits = (1u << 21) - 1;
    return (static_cast<std::uint64_t>(c.x) & low_bits) | (static_cast<std::uint64_t>(c.y) & low_bits) << 21 |
           (static_cast<std::uint64_t>(c.z) & low_bits) << 42;
  }

  Vec3 low_;
  std::vector<Vec3> x_;
  std::vector<double> spacing_;
  std::map<int, Grid> grids_;
};

}  // namespace calor
