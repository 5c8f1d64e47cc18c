#pragma once
// Polygons with holes in a case.
#include <string>
#include <vector>

#include "case/case.hpp"
#include "surface/outline.hpp"

namespace calor {

/// The keys of a polygon: the coordinates of its corners along two axes ("xy"; "rz", where the first one is the
/// distance from an axis of revolution), the names of its sides, its holes.
std::vector<Key> polygon_keys(const std::string& axes);

/// Reads them. Corners may run clockwise. A side on the axis of revolution is on no face. `taken`: names that sides
/// cannot have. Throws Error(bad_case).
Outline polygon_from(const Table& part, const std::string& axes, const std::vector<std::string>& taken = {});

/// [[cloud.part.hole]]
void declare_holes(Schema& schema);

}  // namespace calor
