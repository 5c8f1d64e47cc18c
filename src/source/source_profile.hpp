#pragma once
// How the heat of a concentrated source is spread along one axis.

namespace calor {

/// A density of integral 1 along an axis, from the place of the source.
class SourceProfile {
 public:
  /// exp(-s^2 / (2 sigma^2)) with one sigma ahead (s > 0) and one behind, and a part of the whole ahead.
  static SourceProfile gaussian(double ahead, double behind, double part_ahead) {
    return {Kind::gaussian, ahead, behind, part_ahead};
  }
  static SourceProfile gaussian(double sigma) { return gaussian(sigma, sigma, 0.5); }
  /// The same density over a width, with the source in the middle.
  static SourceProfile box(double width) { return {Kind::box, width, width, 0.5}; }
  /// The same density throughout the body.
  static SourceProfile even() { return {Kind::even, 0, 0, 0}; }

  double below(double s) const;    ///< integral up to s; not of `even`
  double density(double s) const;  ///< 1/m; not of `even`
  double reach() const;            ///< farther away there is nothing, m
  bool is_even() const { return kind_ == Kind::even; }

 private:
  enum class Kind { gaussian, box, even };
  SourceProfile(Kind kind, double ahead, double behind, double part_ahead)
      : kind_(kind), ahead_(ahead), behind_(behind), part_ahead_(part_ahead) {}

  Kind kind_;
  double ahead_, behind_, part_ahead_;
};

}  // namespace calor
