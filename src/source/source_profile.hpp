#pragma once
// How a moving source spreads its heat: profiles along single axes, and their products in space. A new profile is a new
// file and its name in source_profile.cpp.
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "case/lengths.hpp"
#include "case/registry.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// A density of integral 1 along an axis, from the position of the source.
class AxisProfile {
 public:
  /// exp(-s^2 / (2 sigma^2)) with one sigma ahead (s > 0) and one behind, and a part of the whole ahead.
  static AxisProfile gaussian(double ahead, double behind, double part_ahead) {
    return {Kind::gaussian, ahead, behind, part_ahead};
  }
  static AxisProfile gaussian(double sigma) { return gaussian(sigma, sigma, 0.5); }
  /// The same density over a width, with the source in the middle.
  static AxisProfile box(double width) { return {Kind::box, width, width, 0.5}; }
  /// The same density throughout the body.
  static AxisProfile even() { return {Kind::even, 0, 0, 0}; }

  double below(double s) const;  ///< integral up to s; not of `even`
  double reach() const;          ///< farther away there is nothing, m
  /// The density is peak(s) exp(-fall(s)), 1/m; not of `even`.
  double peak(double s) const { return s < 0 ? peak_behind_ : peak_ahead_; }
  double fall(double s) const {
    if (kind_ == Kind::box) return std::abs(s) <= 0.5 * ahead_ ? 0 : std::numeric_limits<double>::infinity();
    const double u = s / (s < 0 ? behind_ : ahead_);
    return 0.5 * u * u;
  }
  bool is_even() const { return kind_ == Kind::even; }

 private:
  enum class Kind { gaussian, box, even };
  AxisProfile(Kind kind, double ahead, double behind, double part_ahead);

  Kind kind_;
  double ahead_, behind_, part_ahead_;
  double peak_ahead_ = 0, peak_behind_ = 0;
};

/// A product of densities along the motion, across, and along an axis normal to both (bodies of fewer dimensions leave
/// out the last ones).
struct SourceProfile {
  AxisProfile along, across;
  bool is_round = false;  ///< the same in all directions normal to the axis
  int axis = 2;
  double into = 1;  ///< sign of the direction along the axis in which `depth` counts
  AxisProfile depth = AxisProfile::even();
  /// Heat enters by this face of the cloud alone; `depth` is not used.
  std::optional<int> face = {};
  /// The face is no plane normal to `axis`: what counts is the distance in space, on the side that the source is on.
  bool is_curved = false;
  double radius = 0;  ///< within which most of the heat goes in, m; 0: as small as the spacing allows
  double sigma = 0;   ///< of its shortest side along the motion, m: steps in time resolve it

  /// Does the density change along an axis of the coordinates?
  bool varies(int along_axis) const { return is_curved || along_axis != axis || !(face || depth.is_even()); }
};

/// [source.NAME.PROFILE]
struct SourceProfileKind {
  std::string name, sentence;
  std::vector<Key> keys;
  /// From the table [source.NAME.PROFILE]. Collective; throws Error on all ranks, or, before anything collective, on
  /// some.
  SourceProfile (*make)(const Table& table, const Cloud& cloud);
};
Registry<SourceProfileKind>& source_profiles();

/// sigma of a Gaussian from the keys `sigma` or `radius` (= sqrt(6) sigma, where exp(-3 r^2 / radius^2) has fallen to
/// 5 %) of a table; exactly one must be given.
double sigma_of(const Table& table);
/// The two keys, before others.
std::vector<Key> sigma_keys(const std::vector<Key>& others);
/// Axis of a line or column from the key `along`: z in a body of two dimensions or one, the normal of its plane.
int axis_through(const Table& table, int dimension);

}  // namespace calor
