#pragma once
// The profile of a moving source where the source is at one time.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/vec3.hpp"
#include "source/path.hpp"
#include "source/source_profile.hpp"

namespace calor {

/// In the axes of the coordinates. The profile must outlive it.
class PosedProfile {
 public:
  PosedProfile(const SourceProfile& profile, const Pose& pose, int dimension)
      : profile_(profile), x0_(pose.place), dimension_(dimension) {
    Vec3 normal;
    normal[profile.axis] = profile.into;
    // Motion along the normal, as over a curved face, does not tilt the source.
    along_ = pose.direction - dot(pose.direction, normal) * normal;
    if (norm(along_) < 1e-6) along_ = Vec3{}, along_[(profile.axis + 1) % 3] = 1;
    along_ *= 1 / norm(along_);
    across_ = cross(normal, along_);
  }

  /// Is the density a product over the axes of the coordinates?
  bool is_product() const {
    return profile_.is_round || std::max({std::abs(along_.x), std::abs(along_.y), std::abs(along_.z)}) > 1 - 1e-12;
  }
  /// Integral between two coordinates of one factor of the product.
  double between(int axis, double low, double high) const {
    const bool forward = factor_sign(axis) > 0;
    const double a = forward ? low - x0_[axis] : x0_[axis] - high, b = forward ? high - x0_[axis] : x0_[axis] - low;
    const AxisProfile& p = factor(axis);
    return p.below(b) - p.below(a);
  }
  const AxisProfile& factor(int axis) const {
    if (axis == profile_.axis) return profile_.depth;
    return profile_.is_round || std::abs(along_[axis]) > 0.5 ? profile_.along : profile_.across;
  }

  /// One factor of the product, 1/m.
  double density(int axis, double x) const { return factor(axis).density(factor_sign(axis) * (x - x0_[axis])); }
  /// Per m^d; `even` profiles count as 1.
  double density(const Vec3& x) const {
    const Vec3 r = x - x0_;
    double density = profile_.along.density(dot(r, along_));
    if (dimension_ > 1 && density > 0) density *= profile_.across.density(dot(r, across_));
    if (dimension_ > 2 && density > 0 && !profile_.depth.is_even() && !profile_.face)
      density *= profile_.depth.density(profile_.into * r[profile_.axis]);
    return density;
  }
  const Vec3& location() const { return x0_; }
  /// Does the density change along this axis?
  bool varies(int axis) const { return axis < dimension_ && profile_.varies(axis); }
  std::array<bool, 3> varies() const { return {varies(0), varies(1), varies(2)}; }
  /// Along an axis; a profile that is no product over the axes may be turned in any way.
  double reach(int axis) const {
    return axis == profile_.axis ? profile_.depth.reach() : std::max(profile_.along.reach(), profile_.across.reach());
  }

 private:
  double factor_sign(int axis) const {
    if (axis == profile_.axis) return profile_.into;
    return profile_.is_round || along_[axis] > -0.5 ? 1 : -1;
  }

  const SourceProfile& profile_;
  Vec3 x0_, along_, across_;
  int dimension_;
};

}  // namespace calor
