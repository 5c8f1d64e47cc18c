#pragma once
// Sources on faces that are no planes of the coordinates.
#include "base/vec3.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// Where a source that may stand beside the surface, such as a torch above it, meets a face.
struct Foot {
  Vec3 x;       ///< on the plane through the nearest point of the face, m
  Vec3 normal;  ///< outward unit normal there
};
/// The same on any number of ranks. Collective.
Foot foot_on_face(const Cloud& cloud, int face, const Vec3& place);

}  // namespace calor
