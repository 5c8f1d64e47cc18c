#pragma once
// Bodies that are their own mirror images: points are made for one half, and the other half is its image.
#include <map>
#include <span>
#include <string>

#include "cloud/body_cloud.hpp"
#include "surface/surface.hpp"

namespace calor {

/// A plane across an axis.
struct MirrorPlane {
  int axis;
  double at;  ///< m

  Vec3 image(Vec3 x) const {
    x[axis] = 2 * at - x[axis];
    return x;
  }
  Vec3 image_of_direction(Vec3 v) const {
    v[axis] = -v[axis];
    return v;
  }
};

/// Name of the face that the cut along a plane gives a half.
constexpr const char* cut_face = "plane of symmetry";

/// What of a closed surface lies above the plane; without facets where nothing does.
Surface upper_half(const Surface& surface, const MirrorPlane& plane);

/// Of the faces above a plane: where their images lie. Others are their own images.
using FaceImages = std::map<std::string, std::string>;

/// Adds those of a surface that is its own image to within `alike`, m. Throws Error(bad_case) where one face would have
/// several.
void add_face_images(const Surface& whole, const MirrorPlane& plane, double alike, FaceImages& images);

/// A half with its image: the cut between them is no wall any more, nor are cuts along other planes.
Surface with_image(const Surface& half, const MirrorPlane& plane, const FaceImages& images);

/// The points of a half with their images; those on the plane belong to both. Pieces of face `cut`, of this plane and
/// all others, are left out. `image_of_face`: of every number of a face that of its image.
MeasuredPoints with_images(const MeasuredPoints& half, const MirrorPlane& plane, int cut,
                           std::span<const int> image_of_face);

}  // namespace calor
