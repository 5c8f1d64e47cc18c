#pragma once
// Points that somebody else placed in a body of any shape: where they lie on it, and how far apart they are.
#include <cstdint>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "cloud/body_points.hpp"

namespace calor {

/// Points of a CSV file, on every rank all of them.
struct GivenPoints {
  std::string file;
  std::vector<Vec3> x;    ///< m
  std::vector<int> line;  ///< of the file
  double least = 0;       ///< distance of two points, m
};
/// The file that key `points` names; columns x [m], y [m] and, in space, z [m]. Throws Error.
GivenPoints read_given_points(const Table& cloud);

/// The points as those of a body, first those on its surface, and their places in the file. Refuses points outside the
/// body, and walls on which no point lies. Throws Error(bad_case).
struct PlacedPoints {
  BodyPoints points;
  std::vector<std::int64_t> id;
};
PlacedPoints place_given(const Body& body, const GivenPoints& given);

/// The spacing of the point next to a place. The points must outlive it.
SpacingField spacing_of_nearest(const BodyPoints& points);

}  // namespace calor
