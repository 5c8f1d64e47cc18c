#pragma once
// What a [[cloud.part]] may be: a file or a shape, as plain functions that make closed surfaces and as entries of a
// registry.
#include <string>
#include <vector>

#include "case/registry.hpp"
#include "surface/surface.hpp"

namespace calor {

/// A value of [[cloud.part]] shape. A new one is a new file and its name in solid_shapes.cpp.
struct SolidShape {
  std::string name, sentence;
  std::vector<Key> keys;  ///< in [[cloud.part]]
  /// `chord`: how long facets on curved faces may be, m. The surface is closed, its facets point outwards; it lies
  /// where the shape has its origin, and place() of part_keys.hpp moves it. Throws Error(bad_case).
  Surface (*make)(const Table& part, double chord);
};
Registry<SolidShape>& solid_shapes();

}  // namespace calor
