#include "output/temperature_unit.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "base/units.hpp"

namespace calor {

TemperatureUnit TemperatureUnit::of(const Case& c) {
  const Table output = c.section("output");
  TemperatureUnit unit;
  unit.name_ = output.text("temperature");
  try {
    // A degree Celsius of difference is a kelvin, and everybody writes it so.
    unit.difference_name_ = difference_to_si(1, unit.name_, "K") == 1 ? "K" : unit.name_;
  } catch (const std::invalid_argument& e) {
    output.refuse("temperature", fmt::format("'temperature' = \"{}\": {}", unit.name_, e.what()),
                  "write a unit of temperature: K, degC or degF");
  }
  return unit;
}

double TemperatureUnit::value(double kelvin) const { return to_si(kelvin, "K", name_); }

double TemperatureUnit::difference(double kelvin) const { return difference_to_si(kelvin, "K", difference_name_); }

}  // namespace calor
