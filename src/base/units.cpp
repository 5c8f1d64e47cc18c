#include "base/units.hpp"

#include <udunits2.h>

#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <regex>
#include <sstream>
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
    // It knows a degree and ° only.
    const Unit degree(ut_parse(read.get(), "degree", UT_UTF8));
    ut_map_name_to_unit("deg", UT_UTF8, degree.get());
    return read;
  }();
  return system.get();
}

/// Does it say more than a unit? udunits2 takes 'K @ 5' and 'K from 5' for a unit with another origin, 'K 5' and
/// 'K^2.5' for ones five times as large.
bool says_more(const std::string& name) {
  if (name.find('@') != name.npos) return true;
  static const std::regex broken_power(R"([A-Za-z^][-+]?[0-9]*\.[0-9])");
  if (std::regex_search(name, broken_power)) return true;
  std::istringstream words(name);
  for (std::string word; words >> word;) {
    for (const char* origin : {"from", "since", "after", "ref"})
      if (word == origin) return true;
    if (word[0] >= '0' && word[0] <= '9' && word != name) return true;
  }
  return false;
}

/// The unit that was meant, if it can be told: 'C' is a coulomb, 'mK' a millikelvin.
std::string hint(const std::string& name, const std::string& wanted) {
  const auto letters = [](const std::string& unit) {
    std::string bare;
    for (const char c : unit)
      if (std::string(" ()^*.").find(c) == std::string::npos) bare += c;
    return bare;
  };
  std::string meant;
  if (trimmed(name) == "C" || trimmed(name) == "F") meant = "deg" + trimmed(name);
  if (letters(name) == letters(wanted)) meant = wanted;
  return meant.empty() || meant == trimmed(name) ? "" : " (did you mean '" + meant + "'?)";
}

Unit parse(const std::string& name, const std::string& wanted = {}) {
  Unit unit(says_more(name) ? nullptr : ut_parse(units(), trimmed(name).c_str(), UT_UTF8));
  if (!unit) {
    const std::string meant = hint(name, wanted);
    throw std::invalid_argument("'" + name + "' is not a unit" +
                                (meant.empty() ? "; units look like 'W/(m K)', 'J/(kg K)', 'mm' or 'degC'" : meant));
  }
  return unit;
}

using Converter = std::unique_ptr<cv_converter, Free>;

const cv_converter* converter(const std::string& from, const std::string& to) {
  static std::map<std::pair<std::string, std::string>, Converter> known;
  Converter& entry = known[{from, to}];
  if (!entry) {
    const Unit a = parse(from, to), b = parse(to);
    entry.reset(ut_get_converter(a.get(), b.get()));
  }
  if (!entry) {
    if (trimmed(from).empty()) throw std::invalid_argument("the unit is missing; one like '" + to + "' is needed");
    if (trimmed(to).empty() || trimmed(to) == "1") {
      throw std::invalid_argument("'" + from + "' is a unit, but a number without unit is needed");
    }
    throw std::invalid_argument("'" + from + "' cannot be converted to '" + to + "'" + hint(from, to));
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
  const bool is_reciprocal = unit.starts_with("1/");  // "2e-5 1/K"
  if (!unit.empty() && !is_reciprocal && std::string(".,+0123456789").find(unit[0]) != std::string::npos) {
    throw std::invalid_argument("'" + text + "' is not one number and a unit; decimals follow a point");
  }
  return {value, unit};
}

}  // namespace calor
