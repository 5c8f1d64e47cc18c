// Functions of place, time and temperature as a case writes them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "base/csv.hpp"
#include "base/units.hpp"
#include "case/case.hpp"
#include "case/values.hpp"

namespace calor {
namespace {

const Key length_unit{"length", Kind::text, "", "m", "Unit of x, y, z and r in the formula."};
const Key time_unit{"time", Kind::text, "", "s", "Unit of the times."};
const Key temperature_unit{"temperature", Kind::text, "", "K", "Unit of the temperatures."};
const Key unit_key{"unit", Kind::text, "", required, "Unit of the values."};
const Key argument_key{"of", Kind::choice, "", optional, "What a table goes by.", {"temperature", "time"}};
const Key interpolation_key{"interpolation", Kind::choice, "", "linear", "Between rows.", {"linear", "cubic"}};
const Key breaks_key{"breaks", Kind::quantities, "s", optional, "Times at which the formula jumps or has a kink."};
const Key along_key{"along", Kind::choice, "", required, "Axis across the layers.", {"x", "y", "z"}};
const Key thickness_key{"thickness", Kind::quantities, "m", required, "Of all layers, or one a layer."};
const Key start_key{"start", Kind::quantity, "m", "0 m", "Where the first layer begins."};

/// The sub-keys of one function value: { formula = ..., unit = ... }.
class Parts {
 public:
  Parts(const Value& table, const Key& owner, const std::string& form, const std::vector<std::string>& others)
      : table_(table), owner_(owner) {
    std::vector<std::string> known{form};
    known.insert(known.end(), others.begin(), others.end());
    for (const Entry& entry : table.entries) {
      if (std::ranges::count(known, entry.key)) continue;
      const std::string near = nearest(entry.key, known);
      throw Error(Fault::bad_case, entry.key_place,
                  fmt::format("'{}' is not a key of {} = {{ {} = ... }}", entry.key, owner.name, form),
                  near.empty() ? fmt::format("its keys are {}", fmt::join(known, ", "))
                               : fmt::format("did you mean '{}'?", near));
    }
  }

  const Value* find(const Key& key) const { return table_.find(key.name); }

  /// The value, or the default; refuses where there is none.
  Value get(const Key& key) const {
    if (const Value* v = find(key)) return *v;
    if (!has_fallback(key))
      refuse_value(table_, fmt::format("{} = {{ ... }} needs '{}'", owner_.name, key.name),
                   fmt::format("add {} = {}", key.name, wanted(key)));
    return fallback_value(key, table_.place);
  }

  /// A unit that converts to `si_unit`.
  std::string unit(const Key& key, const std::string& si_unit) const {
    const Value v = get(key);
    const std::string unit = read_text(v, key);
    try {
      to_si(1, unit, si_unit);
    } catch (const std::invalid_argument& e) {
      refuse_value(
          v, fmt::format("'{}' of {}: {}", key.name, owner_.name, e.what()),
          si_unit.empty() ? "leave the unit out" : fmt::format("write {}, or a unit that converts to it", si_unit));
    }
    return unit;
  }

  /// The unit of the values: required unless the key has no dimension.
  std::string value_unit() const {
    if (!find(unit_key)) {
      if (owner_.unit.empty()) return "";
      refuse_value(table_, fmt::format("{} = {{ ... }} has no unit", owner_.name),
                   fmt::format("it needs a unit, e.g. unit = \"{}\"", owner_.unit));
    }
    return unit(unit_key, owner_.unit);
  }

  const Value& table() const { return table_; }
  const Key& owner() const { return owner_; }

 private:
  const Value& table_;
  const Key& owner_;
};

Function read_formula(const Parts& parts, const Context& context) {
  const Value text = *parts.table().find("formula");
  if (text.is_number()) refuse_value(text, "'formula' cannot be " + text.described(), "write it in quotes");
  const std::string expression = read_text(text, {"formula", Kind::text, "", required, ""});
  const FormulaUnits units{.value = parts.value_unit(),
                           .si = parts.owner().unit,
                           .length = parts.unit(length_unit, "m"),
                           .time = parts.unit(time_unit, "s"),
                           .temperature = parts.unit(temperature_unit, "K")};
  const Value* breaks = parts.find(breaks_key);
  return Function::formula(expression, units, context.parameters, text.place,
                           breaks ? read_numbers(*breaks, breaks_key) : std::vector<double>{});
}

/// Rows of a table in SI; `places` where they stand.
struct Rows {
  std::vector<double> x, y;
  std::vector<Place> places;
};

bool by_temperature(const Parts& parts) {
  if (const Value* of = parts.find(argument_key)) return read_text(*of, argument_key) == "temperature";
  return parts.owner().unit != "K";  // a temperature that depends on the temperature makes no sense
}

Rows written_rows(const Parts& parts, bool of_temperature) {
  const Value& list = *parts.table().find("table");
  if (list.type != Value::Type::list)
    refuse_value(list, "'table' cannot be " + list.described(),
                 "write a list of pairs: [[300, 20.1], [400, 18]]; a file goes by file = \"k.csv\"");
  const std::string unit = parts.value_unit();
  const std::string argument_unit = of_temperature ? parts.unit(temperature_unit, "K") : parts.unit(time_unit, "s");
  Rows rows;
  for (const Value& row : list.list) {
    const bool is_pair = row.type == Value::Type::list && row.list.size() == 2 && row.list[0].is_number() &&
                         row.list[1].is_number() && std::isfinite(row.list[0].number) &&
                         std::isfinite(row.list[1].number);
    if (!is_pair)
      refuse_value(row, fmt::format("row {} of the table is not a pair of finite numbers", rows.x.size() + 1),
                   fmt::format("write [{}, value], the units go into '{}' and 'unit'",
                               of_temperature ? "temperature" : "time", of_temperature ? "temperature" : "time"));
    rows.x.push_back(to_si(row.list[0].number, argument_unit, of_temperature ? "K" : "s"));
    rows.y.push_back(to_si(row.list[1].number, unit, parts.owner().unit));
    rows.places.push_back(row.place);
  }
  return rows;
}

/// A file of two columns; their units are in its header.
Rows file_rows(const Parts& parts, bool& of_temperature, const Context& context) {
  const Value& name = *parts.table().find("file");
  const std::string file = read_text(name, {"file", Kind::text, "", required, ""});
  std::optional<CsvReader> csv;
  try {
    csv.emplace(context.path_of(file));
  } catch (const Error& e) {
    if (e.fault() != Fault::file) throw;
    throw Error(Fault::file, name.place, fmt::format("the file \"{}\" {}", context.path_of(file), e.problem()),
                e.cure());
  }
  if (csv->columns().size() != 2)
    throw Error(Fault::bad_case, {.file = csv->path(), .line = 1},
                fmt::format("the file has {} columns", csv->columns().size()),
                fmt::format("a table has two, with the header T [K],{} [{}]", parts.owner().name, parts.owner().unit));
  if (!parts.find(argument_key)) {  // the header knows
    const std::string& unit = csv->columns()[0].unit;
    try {
      to_si(1, unit, "s");
      of_temperature = false;
    } catch (const std::invalid_argument&) {
      of_temperature = true;
    }
  }
  const int x = csv->require(csv->columns()[0].name, of_temperature ? "K" : "s");
  const int y = csv->require(csv->columns()[1].name, parts.owner().unit);
  Rows rows;
  while (csv->next()) {
    rows.x.push_back(csv->number(x));
    rows.y.push_back(csv->number(y));
    rows.places.push_back(csv->place());
  }
  return rows;
}

Function read_table(const Parts& parts, const Context& context) {
  bool of_temperature = by_temperature(parts);
  const bool from_file = parts.table().find("file") != nullptr;
  const Rows rows = from_file ? file_rows(parts, of_temperature, context) : written_rows(parts, of_temperature);
  const Value& at = from_file ? *parts.table().find("file") : *parts.table().find("table");
  if (rows.x.size() < 2)
    refuse_value(at, rows.x.empty() ? "the table has no rows" : "the table has one row",
                 "a table needs at least two; write a single value as a number with its unit");
  for (std::size_t n = 1; n < rows.x.size(); ++n)
    if (!(rows.x[n] > rows.x[n - 1]))
      throw Error(Fault::bad_case, rows.places[n],
                  fmt::format("row {} of the table is not above row {}: {} after {} {}", n + 1, n, rows.x[n],
                              rows.x[n - 1], of_temperature ? "K" : "s"),
                  fmt::format("sort the rows by {}, each once", of_temperature ? "temperature" : "time"));
  const std::string how = read_text(parts.get(interpolation_key), interpolation_key);
  Curve curve = Curve::through(rows.x, rows.y, how == "cubic" ? Interpolation::cubic : Interpolation::linear);
  return of_temperature ? Function::of_temperature(std::move(curve), at.place)
                        : Function::of_time(std::move(curve), at.place);
}

Function read_layers(const Parts& parts) {
  const Value& list = *parts.table().find("layers");
  Key value_key = parts.owner();
  value_key.kind = Kind::quantity;
  value_key.name = "layers";
  if (list.type != Value::Type::list || list.list.empty())
    refuse_value(list, "'layers' cannot be " + list.described(), "write one value a layer: [0.2, 0.15]");
  std::vector<double> values;
  for (const Value& v : list.list)
    values.push_back(v.is_number() ? to_si(v.number, parts.value_unit(), parts.owner().unit)
                                   : read_number(v, value_key));
  for (std::size_t n = 0; n < values.size(); ++n)
    if (!std::isfinite(values[n])) refuse_value(list.list[n], "a layer's value is not finite", "write a finite number");

  const std::string along = read_text(parts.get(along_key), along_key);
  const Value written = parts.get(thickness_key);
  std::vector<double> thickness = read_numbers(written, thickness_key);
  if (thickness.size() == 1) thickness.assign(values.size(), thickness[0]);
  if (thickness.size() != values.size())
    refuse_value(written, fmt::format("{} thicknesses for {} layers", thickness.size(), values.size()),
                 "give one for all layers, or one a layer");
  if (std::ranges::any_of(thickness, [](double d) { return !(d > 0); }))
    refuse_value(written, "a layer's thickness is not positive", "write a thickness above 0 m");
  return Function::layers(along[0] - 'x', read_number(parts.get(start_key), start_key), std::move(thickness),
                          std::move(values), parts.table().place);
}

}  // namespace

Function read_function(const Value& value, const Key& key, const Context& context) {
  if (!value.is_table()) {
    Key quantity = key;
    quantity.kind = Kind::quantity;
    if (value.type == Value::Type::list || value.type == Value::Type::flag || value.type == Value::Type::date)
      refuse_value(value, fmt::format("'{}' cannot be {}", key.name, value.described()), "write " + wanted(key));
    return Function::constant(read_number(value, quantity), value.place);
  }
  for (const std::string& form : key.choices)
    if (const Value* other = value.find(form)) {  // its owner reads it; here it is only checked
      const Parts only(value, key, form, {});
      read_text(*other, {form, Kind::text, "", required, ""});
      return Function();
    }
  const std::vector<std::string> table_keys{"of", "unit", "temperature", "time", "interpolation"};
  if (value.find("formula"))
    return read_formula({value, key, "formula", {"unit", "length", "time", "temperature", "breaks"}}, context);
  if (value.find("table")) return read_table({value, key, "table", table_keys}, context);
  if (value.find("file")) return read_table({value, key, "file", {"of", "interpolation"}}, context);
  if (value.find("layers")) return read_layers({value, key, "layers", {"along", "thickness", "start", "unit"}});
  refuse_value(value, fmt::format("'{}' is a table without formula, table, file or layers", key.name),
               "write " + wanted(key));
}

}  // namespace calor
