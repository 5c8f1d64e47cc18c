#pragma once
// A symmetric tensor.
#include "base/vec3.hpp"

namespace calor {

/// Symmetric D x D matrix of a point, D <= 3; in bodies of one or two dimensions the rest stays zero.
struct Symmetric3 {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  /// Adds w a (x) a.
  void add(double w, const Vec3& a) {
    xx += w * a.x * a.x, yy += w * a.y * a.y, zz += w * a.z * a.z;
    xy += w * a.x * a.y, xz += w * a.x * a.z, yz += w * a.y * a.z;
  }
  Vec3 operator*(const Vec3& a) const {
    return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z, xz * a.x + yz * a.y + zz * a.z};
  }
  bool is_diagonal() const { return xy == 0 && xz == 0 && yz == 0; }
  Vec3 diagonal() const { return {xx, yy, zz}; }
};

}  // namespace calor
