#include "source/source_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "case/lengths.hpp"

namespace calor {

SourceProfileKind line_profile(), column_profile(), surface_profile(), goldak_profile();

Registry<SourceProfileKind>& source_profiles() {
  static Registry<SourceProfileKind> all = {line_profile(), column_profile(), surface_profile(), goldak_profile()};
  return all;
}

AxisProfile::AxisProfile(Kind kind, double ahead, double behind, double part_ahead)
    : kind_(kind), ahead_(ahead), behind_(behind), part_ahead_(part_ahead) {
  if (kind == Kind::even) return;
  const auto peak = [&](double part, double length) {
    return kind == Kind::box ? 1 / length : 2 * part / (std::sqrt(2 * std::numbers::pi) * length);
  };
  peak_ahead_ = peak(part_ahead, ahead), peak_behind_ = peak(1 - part_ahead, behind);
}

double AxisProfile::below(double s) const {
  if (kind_ == Kind::box) return std::clamp(s / ahead_ + 0.5, 0.0, 1.0);
  const double part_behind = 1 - part_ahead_;
  return s < 0 ? part_behind * std::erfc(-s / (std::numbers::sqrt2 * behind_))
               : part_behind + part_ahead_ * std::erf(s / (std::numbers::sqrt2 * ahead_));
}

double AxisProfile::reach() const {
  constexpr double sigmas = 8.5;  // what lies beyond is less than rounding
  return kind_ == Kind::box ? 0.5 * ahead_ : sigmas * std::max(ahead_, behind_);
}

double sigma_of(const Table& table) {
  if (table.has("sigma") == table.has("radius"))
    table.refuse(
        table.has("sigma") ? "radius" : "",
        table.has("sigma") ? "the source has a sigma and a radius" : fmt::format("[{}] has no size", table.path()),
        "give radius = \"5 mm\" or sigma; radius = sqrt(6) sigma");
  const std::string key = table.has("sigma") ? "sigma" : "radius";
  return positive_length(table, key) / (key == "sigma" ? 1 : std::sqrt(6));
}

std::vector<Key> sigma_keys(const std::vector<Key>& others) {
  std::vector<Key> keys = {
      {"sigma", Kind::quantity, "m", optional, "Standard deviation: heat goes as exp(-r^2 / (2 sigma^2))."},
      {"radius", Kind::quantity, "m", optional, "The same as exp(-3 r^2 / radius^2): radius = sqrt(6) sigma."}};
  keys.insert(keys.end(), others.begin(), others.end());
  return keys;
}

int axis_through(const Table& table, int dimension) {
  const int axis = table.text("along")[0] - 'x';
  if (dimension < 3 && axis != 2)
    table.refuse("along", fmt::format("in a body of {}D heat goes in evenly through its thickness", dimension),
                 "leave 'along' out");
  return axis;
}

}  // namespace calor
