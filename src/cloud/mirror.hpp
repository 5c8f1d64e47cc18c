#pragma once
// Reflection across plane walls of a box.
#include <cstdint>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

/// x -> sign x + shift, axis by axis: the reflection across one wall, or across several that meet at an edge or corner.
struct Mirror {
  Vec3 sign = {1, 1, 1}, shift = {};

  Vec3 vector(const Vec3& a) const { return {sign.x * a.x, sign.y * a.y, sign.z * a.z}; }
  Vec3 point(const Vec3& x) const { return vector(x) + shift; }
  /// Image of `to` minus `from`; the same bits, reflected, when the two change places.
  Vec3 displacement(const Vec3& from, const Vec3& to) const { return (vector(to) - from) + shift; }
};

/// Reflection for every set of walls that have no axis in common: bit f of its index is the wall at walls[f], normal to
/// axis f / 2. Other sets hold the identity.
std::vector<Mirror> mirrors_of(const std::vector<double>& walls);

/// Does the set hold two opposite walls?
inline bool has_opposite_walls(std::uint32_t set) { return (set & set >> 1 & 0b010101) != 0; }

}  // namespace calor
