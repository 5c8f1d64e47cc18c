#pragma once
// The unit in which people read temperatures: on the terminal and in run.log. Files of numbers keep to SI.
#include <string>

#include "case/case.hpp"

namespace calor {

class TemperatureUnit {
 public:
  TemperatureUnit() = default;  ///< K
  /// [output] temperature. Throws Error(bad_case) at the key for what is no unit of temperature.
  static TemperatureUnit of(const Case& c);

  double value(double kelvin) const;       ///< a temperature in this unit
  double difference(double kelvin) const;  ///< a difference in `difference_name`
  const std::string& name() const { return name_; }
  const std::string& difference_name() const { return difference_name_; }

 private:
  std::string name_ = "K", difference_name_ = "K";
};

}  // namespace calor
