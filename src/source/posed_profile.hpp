#pragma once
// The profile of a moving source where the source is at one time.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

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
    if (profile.is_round) along_ = Vec3{}, along_[profile.axis == 0 ? 1 : 0] = 1;
    along_ *= 1 / norm(along_);
    const Vec3 across = cross(normal, along_);
    const bool is_deep = !profile.depth.is_even() && !profile.face;
    if (is_in_body(along_)) factors_[count_++] = {along_, &profile.along};
    if (is_in_body(across)) factors_[count_++] = {across, &profile.across};
    if (is_deep && is_in_body(normal)) factors_[count_++] = {normal, &profile.depth};
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

  /// Per m^d; `even` profiles count as 1.
  double density(const Vec3& x) const {
    double peak = 1, fall = 0;
    for (const Factor& factor : std::span(factors_).first(count_)) {
      const double s = dot(x - x0_, factor.direction);
      peak *= factor.profile->peak(s), fall += factor.profile->fall(s);
    }
    return fall < nothing ? peak * std::exp(-fall) : 0;
  }
  /// Is there nothing of the source within `around` (m) of a place?
  bool is_far(const Vec3& x, double around) const {
    double fall = 0;
    for (const Factor& factor : std::span(factors_).first(count_)) {
      const double s = dot(x - x0_, factor.direction);
      if (std::abs(s) > around) fall += factor.profile->fall(s < 0 ? s + around : s - around);
    }
    return fall >= nothing;
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
  /// A factor of the density, along a direction of its own.
  struct Factor {
    Vec3 direction;
    const AxisProfile* profile;
  };
  /// At six standard deviations, beyond which lies less than 1e-7 of the heat.
  static constexpr double nothing = 0.5 * 6 * 6;

  /// Bodies of fewer dimensions leave out the last ones.
  bool is_in_body(const Vec3& direction) const {
    double square = 0;
    for (int axis = 0; axis < dimension_; ++axis) square += direction[axis] * direction[axis];
    return square > 0.5;
  }
  double factor_sign(int axis) const {
    if (axis == profile_.axis) return profile_.into;
    return profile_.is_round || along_[axis] > -0.5 ? 1 : -1;
  }

  const SourceProfile& profile_;
  Vec3 x0_, along_;
  int dimension_;
  std::array<Factor, 3> factors_;
  int count_ = 0;
};

}  // namespace calor
