#pragma once
// The spacings that a case asks for in a body of any shape.
#include "base/function.hpp"
#include "case/case.hpp"
#include "cloud/body_points.hpp"
#include "surface/surface.hpp"

namespace calor {

/// The spacing at a place, m; refuses one that is not positive.
double positive_spacing(const Function& spacing, const Vec3& x);

/// The spacing that the case gives everywhere, by place.
Function spacing_everywhere(const Table& cloud);

/// The same with the finer points of [[cloud.near]].
SpacingField spacing_field(const Table& cloud, const Function& everywhere, const Surface& body);

}  // namespace calor
