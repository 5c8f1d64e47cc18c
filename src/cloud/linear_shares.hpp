#pragma once
// How the surroundings of a place are shared among the points around it: shape functions of moving least squares with
// linear basis. They add up to 1 and their points, so shared, to the place, so that what is integrated with them is a
// quadrature at the points that is exact for linear functions.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

class LinearShares {
 public:
  /// Radius of the supports in spacings: wider ones take from the walls, narrower ones see too little.
  static constexpr double radius = 1.8;
  /// Where there are too few points, they are looked for this much farther, again and again.
  static constexpr double farther = 1.15;
  static constexpr int most_steps = 10;

  void clear() { ids.clear(), value.clear(), way_.clear(); }
  /// A point at `way` from the place along the axes that are shared over, in spacings, and its whole distance from it
  /// squared, in radii over LinearShares::radius. Points beyond the radius are left out.
  void add(std::int64_t id, const Vec3& way, double square);
  /// The values for the points added. False, with none, where they do not tell a linear function of D axes: too few,
  /// or on one line or plane.
  bool solve(int D);

  /// Sums over the points of their weights times 1, x, y, z, xx, xy, xz, yy, yz, zz of the ways to them.
  static constexpr int moments = 10;
  /// c for which weight (c0 + c1 x + c2 y + c3 z) is the value; none where solve would have none.
  static std::optional<std::array<double, 4>> coefficients(const std::array<double, moments>& sums, int D);

  std::vector<std::int64_t> ids;
  std::vector<double> value;

 private:
  std::vector<Vec3> way_;
};

}  // namespace calor
