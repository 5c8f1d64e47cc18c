#include "base/units.hpp"

#include <udunits2.h>

#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "base/error.hpp"

namespace calor {
namespace {

struct Free {
  void operator()(ut_system* system) const { ut_free_system(system); }
  void operator()(ut_unit* unit) const { ut_free(unit); }
  void operator()(cv_converter* converter) const { cv_free(converter); }
};
using Unit = std::unique_ptr<ut_unit, Free>;

constexpr const char* blanks = " \t\r\n";

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

ut_system* units() {
  static const std::unique_ptr<ut_system, Free> system = [] {
    ut_set_error_message_handler(ut_ignore);  // what goes wrong is said by our exceptions
    std::unique_ptr<ut_system, Free> read(ut_read_xml(nullptr));
    if (!read) {
      throw Error(Fault::file, "the unit database of udunits2 cannot be read",
                  "install libudunits2-data or set UDUNITS2_XML_PATH");
    }
    return read;
  }();
  return system.get();
}

Unit parse(const std::string& name) {
  Unit unit(ut_parse(units(), trimmed(name).c_str(), UT_UTF8));
  if (!unit) {
    throw std::invalid_argument("'" + name + "' is not a unit; units look like 'W/(m K)', 'J/(kg K)', 'mm' or 'degC'");
  }
  return unit;
}

using Converter = std::unique_ptr<cv_converter, Free>;

const cv_converter* converter(const std::string& from, const std::string& to) {
  static std::map<std::pair<std::string, std::string>, Converter> known;
  Converter& entry = known[{from, to}];
  if (!entry) {
    const Unit a = parse(from), b = parse(to);
    entry.reset(ut_get_converter(a.get(), b.get()));
  }
  if (!entry) {
    if (trimmed(from).empty()) throw std::invalid_argument("the unit is missing; one like '" + to + "' is needed");
    if (trimmed(to).empty() || trimmed(to) == "1") {
      throw std::invalid_argument("'" + from + "' is a unit, but a number without unit is needed");
    }
    throw std::invalid_argument("'" + from + "' cannot be converted to '" + to + "'");
  }
  return entry.get();
}

}  // namespace

double to_si(double value, const std::string& unit, const std::string& si_unit) {
  return cv_convert_double(converter(unit, si_unit), value);
}

double difference_to_si(double value, const std::string& unit, const std::string& si_unit) {
  const bool affine = to_si(0, unit, si_unit) != 0;
  // udunits2 forgets offsets in products: degC s is K s.
  return affine ? to_si(value, "(" + unit + ") s", "(" + si_unit + ") s") : to_si(value, unit, si_unit);
}

NumberWithUnit split_quantity(const std::string& text) {
  const std::string quantity = trimmed(text);
  const char* first = quantity.data();
  const char* const last = first + quantity.size();
  if (first != last && *first == '+') ++first;
  double value = 0;
  const auto [rest, fault] = std::from_chars(first, last, value);
  if (fault == std::errc::result_out_of_range)
    throw std::invalid_argument("the number in '" + text + "' is out of range");
  if (fault != std::errc{} || !std::isfinite(value)) {
    throw std::invalid_argument("'" + text + "' does not start with a number");
  }
  const std::string unit = trimmed(std::string(rest, last));
  if (!unit.empty() && std::string(".,+0123456789").find(unit[0]) != std::string::npos) {
    throw std::invalid_argument("'" + text + "' is not one number and a unit; decimals follow a point");
  }
  return {value, unit};
}

}  // namespace calor
