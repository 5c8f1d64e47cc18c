#pragma once
// Vertices that are one but for rounding.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

/// Finds places near others. Cells are larger than the tolerance, so that a place near no border looks into one.
class HashGrid {
 public:
  /// `size`: largest coordinate, m: of cells much smaller than its round-off there would be too many to count.
  HashGrid(double tolerance, double size)
      : tolerance_(tolerance), cell_(std::max({8 * tolerance, 1e-12 * size, 1e-300})) {}

  /// Index of the nearest place that is no farther than the tolerance, or of the new one.
  std::int32_t find_or_add(const Vec3& x) {
    std::int32_t best = -1;
    double least = tolerance_ * tolerance_;
    const Vec3 margin{tolerance_, tolerance_, tolerance_};
    const auto low = cell_of(x - margin), high = cell_of(x + margin);
    for (std::int64_t i = low[0]; i <= high[0]; ++i)
      for (std::int64_t j = low[1]; j <= high[1]; ++j)
        for (std::int64_t k = low[2]; k <= high[2]; ++k) {
          const auto found = last_.find(key(i, j, k));
          for (std::int32_t n = found == last_.end() ? -1 : found->second; n >= 0; n = before_[n]) {
            const Vec3 d = places_[n] - x;
            // Of places equally near the first one, in whatever order they are looked at.
            if (const double r2 = dot(d, d); r2 < least || (r2 == least && (best < 0 || n < best)))
              best = n, least = r2;
          }
        }
    if (best >= 0) return best;
    const auto [i, j, k] = cell_of(x);
    const auto mine = static_cast<std::int32_t>(places_.size());
    const auto [entry, is_first] = last_.try_emplace(key(i, j, k), mine);
    before_.push_back(is_first ? -1 : entry->second);
    entry->second = mine;
    places_.push_back(x);
    return mine;
  }
  std::vector<Vec3> places() && { return std::move(places_); }

 private:
  std::array<std::int64_t, 3> cell_of(const Vec3& x) const {
    const auto index = [&](double c) { return static_cast<std::int64_t>(std::floor(c / cell_)); };
    return {index(x.x), index(x.y), index(x.z)};
  }
  /// Different cells may share a key; the distance decides.
  static std::uint64_t key(std::int64_t i, std::int64_t j, std::int64_t k) {
    std::uint64_t h = 0;
    for (const std::int64_t n : {i, j, k}) h = (h ^ static_cast<std::uint64_t>(n)) * 0x9e3779b97f4a7c15U, h ^= h >> 29;
    return h;
  }

  double tolerance_, cell_;
  std::vector<Vec3> places_;
  std::vector<std::int32_t> before_;                      ///< place of the same key before this one, or -1
  std::unordered_map<std::uint64_t, std::int32_t> last_;  ///< place of a key
};

}  // namespace calor
