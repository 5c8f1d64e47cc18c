#include "source/source_profile.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace calor {

double SourceProfile::below(double s) const {
  if (kind_ == Kind::box) return std::clamp(s / ahead_ + 0.5, 0.0, 1.0);
  const double part_behind = 1 - part_ahead_;
  return s < 0 ? part_behind * std::erfc(-s / (std::numbers::sqrt2 * behind_))
               : part_behind + part_ahead_ * std::erf(s / (std::numbers::sqrt2 * ahead_));
}

double SourceProfile::density(double s) const {
  if (kind_ == Kind::box) return std::abs(s) <= 0.5 * ahead_ ? 1 / ahead_ : 0;
  const double sigma = s < 0 ? behind_ : ahead_, part = s < 0 ? 1 - part_ahead_ : part_ahead_;
  const double u = s / sigma;
  return 2 * part / (std::sqrt(2 * std::numbers::pi) * sigma) * std::exp(-0.5 * u * u);
}

double SourceProfile::reach() const {
  constexpr double sigmas = 8.5;  // what lies beyond is less than rounding
  return kind_ == Kind::box ? 0.5 * ahead_ : sigmas * std::max(ahead_, behind_);
}

}  // namespace calor
