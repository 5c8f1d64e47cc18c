#include "case/values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include "base/units.hpp"
#include "case/case.hpp"

namespace calor {
namespace {

[[noreturn]] void refuse_type(const Value& value, const Key& key) {
  refuse_value(value, fmt::format("'{}' cannot be {}", key.name, value.described()),
               fmt::format("write {}", wanted(key)));
}

/// The elements of a list; a single value counts as a list of one.
std::vector<Value> elements(const Value& value, const Key& key) {
  if (value.type != Value::Type::list) return {value};
  if (value.list.empty()) refuse_value(value, fmt::format("'{}' is an empty list", key.name), "write " + wanted(key));
  return value.list;
}

double finite(double number, const Value& value, const Key& key) {
  if (!std::isfinite(number))
    refuse_value(value, fmt::format("'{}' is not finite: {}", key.name, value.described()), "write a finite number");
  return number;
}

NumberWithUnit split(const Value& value, const Key& key) {
  try {
    NumberWithUnit q = split_quantity(value.text);
    finite(q.value, value, key);
    return q;
  } catch (const std::invalid_argument&) {
    refuse_type(value, key);
  }
}

/// Refuses an SI value that nothing physical has: such numbers only make others overflow, or steps vanish.
double plausible(double si, const Value& value, const Key& key) {
  constexpr double largest = 1e25, smallest = 1e-40;
  if (si != 0 && !(std::abs(si) <= largest && std::abs(si) >= smallest))
    refuse_value(value, fmt::format("'{}' is {:.3g} {}, which is no physical size", key.name, si, key.unit),
                 fmt::format("give a number between {:.0e} and {:.0e} {}, or 0", smallest, largest, key.unit));
  // Conditions say by themselves whose ambient it is.
  return key.name == "ambient" ? si : above_absolute_zero(si, value, key);
}

double read_quantity(const Value& value, const Key& key) {
  if (value.is_number()) {
    if (!key.unit.empty())
      refuse_value(value, fmt::format("{} has no unit", value.number),
                   fmt::format("'{}' needs a unit, e.g. \"{} {}\"", key.name, value.number, key.unit));
    return finite(value.number, value, key);
  }
  if (value.type != Value::Type::text) refuse_type(value, key);
  const NumberWithUnit q = split(value, key);
  if (q.unit.empty() && !key.unit.empty())
    refuse_value(value, fmt::format("\"{}\" has no unit", value.text),
                 fmt::format("'{}' needs a unit, e.g. \"{} {}\"", key.name, q.value, key.unit));
  try {
    const double si =
        key.kind == Kind::difference ? difference_to_si(q.value, q.unit, key.unit) : to_si(q.value, q.unit, key.unit);
    return key.unit.empty() ? si : plausible(si, value, key);
  } catch (const std::invalid_argument& e) {
    refuse_value(value, fmt::format("'{}' = \"{}\": {}", key.name, value.text, e.what()),
                 key.unit.empty() ? "write a number without unit"
                                  : fmt::format("write it in {}, or in a unit that converts to that", key.unit));
  }
}

Key single(Key key) {
  if (key.kind == Kind::quantities) key.kind = Kind::quantity;
  if (key.kind == Kind::numbers) key.kind = Kind::number;
  if (key.kind == Kind::integers) key.kind = Kind::integer;
  return key;
}

}  // namespace

double above_absolute_zero(double si, const Value& value, const Key& key) {
  if (key.unit == "K" && key.kind != Kind::difference && si < 0)
    refuse_value(value, fmt::format("'{}' is {:.6g} K, below absolute zero", key.name, si),
                 "check the number and its unit");
  return si;
}

std::string Context::path_of(const std::string& file) const {
  return (std::filesystem::path(folder) / file).lexically_normal().string();
}

std::string Context::expanded(const std::string& formula) const {
  const auto is_part = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.'; };  // of a name or number
  std::string text;
  for (auto at = formula.begin(); at != formula.end();) {
    const auto end = std::find_if_not(at, formula.end(), is_part);
    const std::string word(at, end);
    const auto named = formulas.find(word);
    text += named == formulas.end() ? word : named->second;
    at = end;
    if (at != formula.end()) text += *at++;
  }
  return text;
}

void refuse_value(const Value& value, const std::string& what, const std::string& cure) {
  throw Error(Fault::bad_case, value.location, what, cure);
}

std::string read_text(const Value& value, const Key& key) {
  if (value.type != Value::Type::text) refuse_type(value, key);
  if (key.kind == Kind::choice && !std::ranges::count(key.choices, value.text)) {
    const std::string near = nearest(value.text, key.choices);
    refuse_value(value, fmt::format("'{}' cannot be \"{}\"", key.name, value.text),
                 (near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near)) +
                     fmt::format("It is one of \"{}\"", fmt::join(key.choices, "\", \"")));
  }
  return value.text;
}

bool read_flag(const Value& value, const Key& key) {
  if (value.type != Value::Type::flag) refuse_type(value, key);
  return value.flag;
}

long read_integer(const Value& value, const Key& key) {
  if (value.type != Value::Type::integer) refuse_type(value, key);
  constexpr long most = std::numeric_limits<int>::max();  // nothing counts farther
  if (value.integer > most || value.integer < -most)
    refuse_value(value, fmt::format("'{}' cannot be {}", key.name, value.integer),
                 fmt::format("write a whole number of at most {}", most));
  return value.integer;
}

double read_number(const Value& value, const Key& key) {
  switch (key.kind) {
    case Kind::integer:
      return static_cast<double>(read_integer(value, key));
    case Kind::number:
      if (!value.is_number()) refuse_type(value, key);
      return finite(value.number, value, key);
    case Kind::quantity:
    case Kind::difference:
      return read_quantity(value, key);
    default:
      throw std::logic_error("'" + key.name + "' is not declared as a number");
  }
}

std::vector<std::string> read_texts(const Value& value, const Key& key) {
  std::vector<std::string> out;
  for (const Value& v : elements(value, key)) out.push_back(read_text(v, key));
  return out;
}

std::vector<long> read_integers(const Value& value, const Key& key) {
  std::vector<long> out;
  for (const Value& v : elements(value, key)) out.push_back(read_integer(v, single(key)));
  return out;
}

std::vector<double> read_numbers(const Value& value, const Key& key) {
  std::vector<double> out;
  for (const Value& v : elements(value, key)) out.push_back(read_number(v, single(key)));
  return out;
}

std::vector<std::pair<double, std::string>> read_raw_quantities(const Value& value, const Key& key) {
  std::vector<std::pair<double, std::string>> out;
  for (const Value& v : elements(value, key)) {
    if (v.is_number()) {
      out.emplace_back(finite(v.number, v, key), "");
    } else if (v.type == Value::Type::text) {
      const NumberWithUnit q = split(v, key);
      out.emplace_back(q.value, q.unit);
    } else {
      refuse_type(v, key);
    }
  }
  return out;
}

void check_value(const Value& value, const Key& key, const Context& context) {
  switch (key.kind) {
    case Kind::text:
    case Kind::choice:
      read_text(value, key);
      return;
    case Kind::flag:
      read_flag(value, key);
      return;
    case Kind::integer:
    case Kind::number:
    case Kind::quantity:
    case Kind::difference:
      read_number(value, key);
      return;
    case Kind::function:
      read_function(value, key, context);
      return;
    case Kind::texts:
      read_texts(value, key);
      return;
    case Kind::integers:
      read_integers(value, key);
      return;
    case Kind::numbers:
    case Kind::quantities:
      read_numbers(value, key);
      return;
    case Kind::raw_quantities:
      read_raw_quantities(value, key);
      return;
    case Kind::table:
      if (!value.is_table() && !(value.type == Value::Type::list && std::ranges::all_of(value.list, &Value::is_table)))
        refuse_type(value, key);
      return;
  }
}

bool has_fallback(const Key& key) {
  const bool is_text = key.kind == Kind::text || key.kind == Kind::choice;
  return key.fallback != required && key.fallback != optional && key.kind != Kind::table &&
         (is_text || !key.fallback.empty());
}

Value fallback_value(const Key& key, const SourceLocation& location) {
  if (key.kind == Kind::text || key.kind == Kind::choice) return Value::of_text(key.fallback, location);
  return read_toml_value(key.fallback, location);
}

std::string wanted(const Key& key) {
  const std::string with_unit = key.unit.empty() ? "1" : fmt::format("\"1 {}\"", key.unit);
  switch (key.kind) {
    case Kind::text:
      return "a text in quotes";
    case Kind::choice:
      return fmt::format("one of \"{}\"", fmt::join(key.choices, "\", \""));
    case Kind::flag:
      return "true or false";
    case Kind::integer:
      return "a whole number, e.g. 10";
    case Kind::number:
      return "a number without unit, e.g. 1.5";
    case Kind::quantity:
    case Kind::difference:
      return key.unit.empty() ? "a number" : fmt::format("a number with its unit, e.g. {}", with_unit);
    case Kind::function:
      return fmt::format("{}, or {{ formula = \"...\"{} }}, {{ table = ... }}, {{ layers = ... }}",
                         key.unit.empty() ? "a number" : "a number with its unit, e.g. " + with_unit,
                         key.unit.empty() ? "" : fmt::format(", unit = \"{}\"", key.unit));
    case Kind::texts:
      return "a text in quotes, or a list of texts: [\"a\", \"b\"]";
    case Kind::integers:
      return "a list of whole numbers, e.g. [10, 20]";
    case Kind::numbers:
      return "a list of numbers, e.g. [1.5, 2]";
    case Kind::quantities:
      return fmt::format("a list of numbers with units, e.g. [{0}, {0}]", with_unit);
    case Kind::raw_quantities:
      return "a number with its unit, e.g. \"0.2 K\" or \"0.02 %\", or a list of such";
    case Kind::table:
      return fmt::format("a table: [{0}], or {0} = {{ ... }}", key.name);
  }
  return {};
}

}  // namespace calor
