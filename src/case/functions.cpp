// Functions of place, time and temperature as a case writes them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "base/csv.hpp"
#include "base/units.hpp"
#include "case/case.hpp"
#include "case/function_table.hpp"

namespace calor {
namespace {

const Key length_unit{"length", Kind::text, "", "m", "Unit of x, y, z and r in the formula."};
const Key time_unit{"time", Kind::text, "", "s", "Unit of the times."};
const Key temperature_unit{"temperature", Kind::text, "", "K", "Unit of the temperatures."};
const Key argument_key{"of", Kind::choice, "", optional, "What a table goes by.", {"temperature", "time"}};
const Key interpolation_key{"interpolation", Kind::choice, "", "linear", "Between rows.", {"linear", "cubic"}};
const Key breaks_key{
    "breaks", Kind::quantities, "s", optional,
    "Times at which the formula jumps or has a kink; without them jumps are looked for, at 10,000 times of the run."};
const Key along_key{"along", Kind::choice, "", required, "Axis across the layers.", {"x", "y", "z"}};
const Key thickness_key{"thickness", Kind::quantities, "m", required, "Of all layers, or one a layer."};
const Key start_key{"start", Kind::quantity, "m", "0 m", "Where the first layer begins."};
const Key coordinate_key{"along", Kind::choice, "", required, "Coordinate the value goes by.", {"x", "y", "z", "r"}};
const Key from_key{"from", Kind::quantity, "m", required, "Coordinate of the first value."};
const Key to_key{"to", Kind::quantity, "m", required, "Coordinate of the last value."};
const Key values_key{"values", Kind::numbers, "", "[0, 1]", "The first and the last value."};
const Key power_key{"power", Kind::number, "", required, "M in s^M."};
const Key exponential_key{"exponential", Kind::number, "", required, "B in (e^(B s) - 1)/(e^B - 1)."};
const Key factor_key{"factor", Kind::number, "", required, "A in A s^n (1 - s)^z."};
const Key hump_key{"hump", Kind::numbers, "", required, "n and z in s^n (1 - s)^z."};

Function read_formula(const FunctionTable& parts, const Context& context) {
  const Value text = *parts.table().find("formula");
  if (text.is_number()) refuse_value(text, "'formula' cannot be " + text.described(), "write it in quotes");
  if (text.type != Value::Type::text)
    refuse_value(text, "'formula' cannot be " + text.described(), explained(parts.owner()));
  const std::string& expression = text.text;
  const FormulaUnits units{.value = parts.value_unit(),
                           .si = parts.owner().unit,
                           .length = parts.unit(length_unit, "m"),
                           .time = parts.unit(time_unit, "s"),
                           .temperature = parts.unit(temperature_unit, "K")};
  const Value* events = parts.find(breaks_key);
  return Function::formula(context.expanded(expression), units, context.parameters, text.location,
                           events ? read_numbers(*events, breaks_key) : std::vector<double>{}, context.lengths,
                           context.course);
}

/// Rows of a table in SI; `locations`: where they stand.
struct Rows {
  std::vector<double> x, y;
  std::vector<SourceLocation> locations;
};

/// What a table goes by.
struct Argument {
  std::string name, si;
  Key unit;
};
const Argument temperature{"temperature", "K", temperature_unit}, time_of_run{"time", "s", time_unit};

/// What a table goes by, as it says itself, by `along`, `of` or the unit of its arguments. Otherwise temperatures go by
/// time and properties by temperature; for heat flows both make sense, and only a file's header may tell.
Argument argument_of(const FunctionTable& parts) {
  const Value *of = parts.find(argument_key), *along = parts.find(coordinate_key);
  if (of && along) refuse_value(*along, "a table goes by one thing, this one has 'of' and 'along'", "leave one out");
  if (along) return {read_text(*along, coordinate_key), "m", length_unit};
  std::optional<bool> by_temperature;
  if (of) by_temperature = read_text(*of, argument_key) == "temperature";
  for (const Key* unit : {&temperature_unit, &time_unit}) {
    const Value* written = parts.find(*unit);
    if (!written) continue;
    const bool says = unit == &temperature_unit;
    if (by_temperature && *by_temperature != says)
      refuse_value(*written,
                   fmt::format("'{}' does not go with a table of {}", unit->name, says ? "time" : "temperature"),
                   "leave it out");
    by_temperature = says;
  }
  if (by_temperature) return *by_temperature ? temperature : time_of_run;
  const std::string& unit = parts.owner().unit;
  const bool may_be_both = unit == "W/m^2" || unit == "W/(m^2 K)" || unit == "W/m^3";
  if (may_be_both && !parts.table().find("file"))
    refuse_value(parts.table(), fmt::format("the table of {} does not say what it goes by", parts.owner().name),
                 "add of = \"time\" or of = \"temperature\"");
  return unit == "K" || unit == "W" ? time_of_run : temperature;
}

Rows written_rows(const FunctionTable& parts, const Argument& argument) {
  const Value& list = *parts.table().find("table");
  if (list.type != Value::Type::list)
    refuse_value(list, "'table' cannot be " + list.described(),
                 "write a list of pairs: [[300, 20.1], [400, 18]]; a file goes by file = \"k.csv\"");
  const std::string unit = parts.value_unit();
  const std::string argument_unit = parts.unit(argument.unit, argument.si);
  Rows rows;
  for (const Value& row : list.list) {
    const bool is_pair = row.type == Value::Type::list && row.list.size() == 2 && row.list[0].is_number() &&
                         row.list[1].is_number() && std::isfinite(row.list[0].number) &&
                         std::isfinite(row.list[1].number);
    if (!is_pair)
      refuse_value(
          row, fmt::format("row {} of the table is not a pair of finite numbers", rows.x.size() + 1),
          fmt::format("write [{}, value], the units go into '{}' and 'unit'", argument.name, argument.unit.name));
    rows.x.push_back(to_si(row.list[0].number, argument_unit, argument.si));
    rows.y.push_back(above_absolute_zero(to_si(row.list[1].number, unit, parts.owner().unit), row, parts.owner()));
    rows.locations.push_back(row.location);
  }
  return rows;
}

/// A file of two columns; their units are in its header.
Rows file_rows(const FunctionTable& parts, Argument& argument, const Context& context) {
  const Value& name = *parts.table().find("file");
  const std::string file = read_text(name, {"file", Kind::text, "", required, ""});
  CsvReader csv(context.path_of(file), name.location);
  if (csv.columns().size() != 2)
    throw Error(Fault::bad_case, {.file = csv.path(), .line = 1},
                fmt::format("the file has {} columns", csv.columns().size()),
                fmt::format("a table has two, with the header T [K],{} [{}]", parts.owner().name, parts.owner().unit));
  if (!parts.find(argument_key) && !parts.find(coordinate_key)) {  // the header knows
    const std::string& unit = csv.columns()[0].unit;
    try {
      to_si(1, unit, "s");
      argument = time_of_run;
    } catch (const std::invalid_argument&) {
      argument = temperature;
    }
  }
  const int x = csv.require(csv.columns()[0].name, argument.si);
  const int y = csv.require(csv.columns()[1].name, parts.owner().unit);
  Rows rows;
  while (csv.next()) {
    rows.x.push_back(csv.number(x));
    rows.y.push_back(csv.number(y));
    rows.locations.push_back(csv.location());
  }
  return rows;
}

/// Moves the second of two equal times by a few units in the last place: the slope in between is steep, and no step
/// looks at it.
void separate_jumps(std::vector<double>& times) {
  const double span = times.back() - times.front();
  for (std::size_t n = 1; n < times.size(); ++n)
    if (times[n] == times[n - 1])
      times[n] += 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(times[n]), 1e-3 * span);
}

Function read_table(const FunctionTable& parts, const Context& context) {
  Argument argument = argument_of(parts);
  const bool from_file = parts.table().find("file") != nullptr;
  Rows rows = from_file ? file_rows(parts, argument, context) : written_rows(parts, argument);
  const Value& at = from_file ? *parts.table().find("file") : *parts.table().find("table");
  if (rows.x.size() < 2)
    refuse_value(at, rows.x.empty() ? "the table has no rows" : "the table has one row",
                 "a table needs at least two; write a single value as a number with its unit");
  const std::string how = read_text(parts.get(interpolation_key), interpolation_key);
  const bool may_jump = argument.si == "s" && how == "linear";
  for (std::size_t n = 1; n < rows.x.size(); ++n) {
    // Two rows of one time are a jump: steps land on it and look at the data on either side.
    const bool jumps = may_jump && rows.x[n] == rows.x[n - 1] && (n < 2 || rows.x[n - 2] < rows.x[n - 1]);
    if (!jumps && !(rows.x[n] > rows.x[n - 1]))
      throw Error(Fault::bad_case, rows.locations[n],
                  fmt::format("row {} of the table is not above row {}: {} after {} {}", n + 1, n, rows.x[n],
                              rows.x[n - 1], argument.si),
                  fmt::format("sort the rows by {}, each once{}", argument.name,
                              may_jump ? ", or twice where the table jumps" : ""));
  }
  separate_jumps(rows.x);
  Curve curve = Curve::through(rows.x, rows.y, how == "cubic" ? Interpolation::cubic : Interpolation::linear);
  if (argument.si == "m")
    return Function::of_coordinate(argument.name[0], curve_profile(std::move(curve)), at.location);
  if (argument.si == "K") return Function::of_temperature(std::move(curve), at.location);
  const Function f = Function::of_time(std::move(curve), at.location);
  return how == "cubic" ? f.with_breaks(std::move(rows.x)) : f;  // smooth, but what it does is between its rows
}

Function read_layers(const FunctionTable& parts) {
  const Value& list = *parts.table().find("layers");
  if (list.type != Value::Type::list || list.list.empty())
    refuse_value(list, "'layers' cannot be " + list.described(), "write one value a layer: [0.2, 0.15]");
  std::vector<double> values;
  for (const Value& v : list.list) values.push_back(parts.value(v, "layers"));

  const std::string along = read_text(parts.get(along_key), along_key);
  const Value written = parts.get(thickness_key);
  std::vector<double> thickness = read_numbers(written, thickness_key);
  if (thickness.size() == 1) thickness.assign(values.size(), thickness[0]);
  if (thickness.size() != values.size())
    refuse_value(written, fmt::format("{} thicknesses for {} layers", thickness.size(), values.size()),
                 "give one for all layers, or one a layer");
  if (std::ranges::any_of(thickness, [](double d) { return !(d > 0); }))
    refuse_value(written, "a layer's thickness is not positive", "write a thickness above 0 m");
  return Function::layers(along[0] - 'x', read_number(parts.get(start_key), start_key), thickness, std::move(values),
                          parts.table().location);
}

/// { power | exponential | hump = ..., along, from, to, ... }: laws of s = (coordinate - from)/(to - from).
Function read_law(const FunctionTable& parts, const Key& form) {
  const std::string along = read_text(parts.get(coordinate_key), coordinate_key);
  const Interval interval{read_number(parts.get(from_key), from_key), read_number(parts.get(to_key), to_key)};
  if (interval.from == interval.to)
    refuse_value(parts.get(to_key), "'from' and 'to' are the same place",
                 "give the value two places to change between");
  const auto pair = [&](const Value& list, const std::string& cure) {
    if (list.type != Value::Type::list || list.list.size() != 2)
      refuse_value(list, fmt::format("{} = {{ ... }} takes two numbers, not {}", form.name, list.described()), cure);
    return std::pair(list.list[0], list.list[1]);
  };
  const Value& law = *parts.table().find(form.name);
  const auto made = [&](Profile profile) {
    return Function::of_coordinate(along[0], std::move(profile), law.location);
  };

  if (form.name == hump_key.name) {
    const auto [n, z] = pair(law, "write hump = [n, z] for factor s^n (1 - s)^z");
    const std::vector<double> powers = read_numbers(law, hump_key);
    if (powers[0] < 0 || powers[1] < 0)
      refuse_value(powers[0] < 0 ? n : z, "a power of the hump is negative", "write numbers from 0 on");
    const Value* factor = parts.find(factor_key);
    if (!factor) refuse_value(parts.table(), "hump = { ... } needs 'factor'", "add factor = the A in A s^n (1 - s)^z");
    return made(hump_profile(interval, parts.value(*factor, "factor"), powers[0], powers[1]));
  }
  if (!parts.find(values_key) && !parts.owner().unit.empty())
    refuse_value(parts.table(), fmt::format("{} = {{ ... }} needs 'values'", parts.owner().name),
                 fmt::format("add values = [\"... {0}\", \"... {0}\"], at 'from' and at 'to'", parts.owner().unit));
  const auto [first, last] = pair(parts.get(values_key), "write values = [the one at 'from', the one at 'to']");
  const double f0 = parts.value(first, "values"), f1 = parts.value(last, "values"), number = read_number(law, form);
  if (form.name == exponential_key.name) return made(exponential_profile(interval, number, f0, f1));
  if (!(number > 0)) refuse_value(law, fmt::format("the power is {}", number), "write a power above 0");
  return made(power_profile(interval, number, f0, f1));
}

Function read_callback(const FunctionTable& parts, const Context& context) {
  const Value& written = *parts.table().find("callback");
  const std::string name = read_text(written, {"callback", Kind::text, "", required, ""});
  const auto found = context.callbacks.find(name);
  if (found != context.callbacks.end()) return Function::callback(found->second, written.location);
  std::vector<std::string> known;
  for (const auto& [other, callback] : context.callbacks) known.push_back(other);
  refuse_value(written, fmt::format("there is no callback '{}'", name),
               known.empty() ? "callbacks are functions of a program that reads the case, such as one in Python by "
                               "calor.core: the command has none"
                             : fmt::format("the program gives {}", fmt::join(known, ", ")));
}

}  // namespace

Function read_function(const Value& value, const Key& key, const Context& context) {
  if (!value.is_table()) {
    Key quantity = key;
    quantity.kind = Kind::quantity;
    if (value.type == Value::Type::list || value.type == Value::Type::flag || value.type == Value::Type::date)
      refuse_value(value, fmt::format("'{}' cannot be {}", key.name, value.described()), explained(key));
    return Function::constant(read_number(value, quantity), value.location);
  }
  for (const std::string& form : key.choices)
    if (const Value* other = value.find(form)) {  // its owner reads it; here it is only checked
      const FunctionTable only(value, key, form, {});
      read_text(*other, {form, Kind::text, "", required, ""});
      return Function();
    }
  const std::vector<std::string> table_keys{"of", "along", "unit", "temperature", "time", "length", "interpolation"};
  if (value.find("formula"))
    return read_formula({value, key, "formula", {"unit", "length", "time", "temperature", "breaks"}}, context);
  for (const Key* law : {&power_key, &exponential_key})
    if (value.find(law->name))
      return read_law({value, key, law->name, {"along", "from", "to", "values", "unit"}}, *law);
  if (value.find("hump")) return read_law({value, key, "hump", {"along", "from", "to", "factor", "unit"}}, hump_key);
  if (value.find("table")) return read_table({value, key, "table", table_keys}, context);
  if (value.find("file")) return read_table({value, key, "file", {"of", "along", "interpolation"}}, context);
  if (value.find("layers")) return read_layers({value, key, "layers", {"along", "thickness", "start", "unit"}});
  if (value.find("callback")) return read_callback({value, key, "callback", {}}, context);
  if (value.find("grid")) return read_grid({value, key, "grid", {"along", "from", "to", "unit"}});
  refuse_value(
      value,
      fmt::format("'{}' is a table without formula, table, file, layers, grid, power, exponential or hump", key.name),
      explained(key));
}

}  // namespace calor
