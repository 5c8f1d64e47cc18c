#include "case/numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "base/units.hpp"
#include "case/entries.hpp"
#include "case/keys.hpp"

namespace calor {
namespace {

/// The number of a value and its unit; nothing where it is none.
std::optional<NumberWithUnit> number_of(const Value& v) {
  if (v.is_number()) return NumberWithUnit{v.number, ""};
  if (v.type != Value::Type::text) return std::nullopt;
  try {
    return split_quantity(v.text);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// Calls f(number, its unit, its path) for all numbers of a value, in order; f may change the number. False where
/// something else is among them.
template <class Use>
bool for_numbers(Value& v, const std::string& path, const Use& f) {
  if (v.type == Value::Type::list) {
    for (std::size_t n = 0; n < v.list.size(); ++n)
      if (!for_numbers(v.list[n], fmt::format("{}[{}]", path, n), f)) return false;
    return !v.list.empty();
  }
  auto number = number_of(v);
  if (!number) return false;
  const double before = number->value;
  f(number->value, path);
  if (number->value == before) return true;
  if (number->unit.empty())
    v.type = Value::Type::number, v.number = number->value;
  else
    v.text = fmt::format("{} {}", number->value, number->unit);
  return true;
}

/// The value below `root`; null where there is none.
Value* find(Value& root, std::span<const std::string> keys) {
  Value* at = &root;
  for (const std::string& key : keys)
    if (at) at = find_at(*at, key);
  return at;
}

}  // namespace

CaseNumbers::CaseNumbers(const Case& c, const std::string& path, const SourceLocation& asked_at) : case_(c) {
  const auto refuse = [&](const std::string& problem) {
    throw Error(Fault::bad_case, asked_at, problem,
                "name a number as it stands in the case, such as material.steel.conductivity or source.arc.power");
  };
  try {
    keys_ = split_path(path);
  } catch (const Error&) {
    refuse(fmt::format("'{}' is no path of a key", path));
  }
  Value root = *c.root().node().root;
  Value* at = find(root, keys_);
  if (!at) refuse(fmt::format("the case has no '{}'", path));
  const bool are_numbers = for_numbers(*at, path, [&](double value, const std::string& name) {
    values_.push_back(value);
    names_.push_back(name);
  });
  if (!are_numbers) refuse(fmt::format("'{}' is no number", path));
}

Case CaseNumbers::with(std::span<const double> values) const {
  Value root = *case_.root().node().root;
  auto next = values.begin();
  for_numbers(*find(root, keys_), "", [&](double& value, const std::string&) { value = *next++; });
  for (const char* unread :
       {"fit", "study", "optimise", "expect", "variant"})  // a run takes no notice of them, or does not change
    std::erase_if(root.entries, [&](const Entry& entry) { return entry.key == unread; });
  const Table::Node& node = case_.root().node();
  return Case::parse(toml_of(root), case_.path(), *node.schema, {}, node.context->callbacks);
}

}  // namespace calor
