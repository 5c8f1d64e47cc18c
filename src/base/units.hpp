#pragma once
// Units by udunits2; SI inside.
#include <string>

namespace calor {

/// value [unit] in `si_unit`, e.g. to_si(20, "degC", "K") = 293.15. Affine units are absolute.
/// Throws std::invalid_argument with a sentence when `unit` is unknown or of another dimension.
double to_si(double value, const std::string& unit, const std::string& si_unit);

/// The same for a difference: 1 degC is 1 K.
double difference_to_si(double value, const std::string& unit, const std::string& si_unit);

/// Splits "350 W/(m^2 K)" into number and unit. Throws std::invalid_argument when there is no number in front.
struct NumberWithUnit {
  double value;
  std::string unit;  ///< empty when there is none
};
NumberWithUnit split_quantity(const std::string& text);

}  // namespace calor
