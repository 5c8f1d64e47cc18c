#include "case/function_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/units.hpp"

namespace calor {
namespace {

const Key unit_key{"unit", Kind::text, "", required, "Unit of the values."};

}  // namespace

FunctionTable::FunctionTable(const Value& table, const Key& owner, const std::string& form,
                             const std::vector<std::string>& others)
    : table_(table), owner_(owner) {
  std::vector<std::string> known{form};
  known.insert(known.end(), others.begin(), others.end());
  for (const Entry& entry : table.entries) {
    if (std::ranges::count(known, entry.key)) continue;
    const std::string near = nearest(entry.key, known);
    throw Error(Fault::bad_case, entry.key_location,
                fmt::format("'{}' is not a key of {} = {{ {} = ... }}", entry.key, owner.name, form),
                near.empty() ? fmt::format("its keys are {}", fmt::join(known, ", "))
                             : fmt::format("did you mean '{}'?", near));
  }
}

Value FunctionTable::get(const Key& key) const {
  if (const Value* v = find(key)) return *v;
  if (!has_fallback(key))
    refuse_value(table_, fmt::format("{} = {{ ... }} needs '{}'", owner_.name, key.name),
                 fmt::format("add {} = {}", key.name, wanted(key)));
  return fallback_value(key, table_.location);
}

std::string FunctionTable::unit(const Key& key, const std::string& si_unit) const {
  const Value v = get(key);
  std::string unit = read_text(v, key);
  try {
    to_si(1, unit, si_unit);
  } catch (const std::invalid_argument& e) {
    refuse_value(
        v, fmt::format("'{}' of {}: {}", key.name, owner_.name, e.what()),
        si_unit.empty() ? "leave the unit out" : fmt::format("write {}, or a unit that converts to it", si_unit));
  }
  return unit;
}

std::string FunctionTable::value_unit() const {
  if (!find(unit_key)) {
    if (owner_.unit.empty()) return "";
    refuse_value(table_, fmt::format("{} = {{ ... }} has no unit", owner_.name),
                 fmt::format("it needs a unit, e.g. unit = \"{}\"", owner_.unit));
  }
  return unit(unit_key, owner_.unit);
}

double FunctionTable::value(const Value& v, const std::string& name) const {
  if (v.is_number()) {
    if (!std::isfinite(v.number))
      refuse_value(v, fmt::format("'{}' holds a value that is not finite", name), "write a finite number");
    return to_si(v.number, value_unit(), owner_.unit);
  }
  Key key = owner_;
  key.kind = Kind::quantity;
  key.name = name;
  return read_number(v, key);
}

std::string explained(const Key& key) {
  return fmt::format("write {}{}{}", wanted(key), key.sentence.empty() ? "" : ". ", key.sentence);
}

}  // namespace calor
