#include "case/tree.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace calor {
namespace {

/// The key that says what kind of function a table is; "" for other tables.
std::string form_of_function(const Value& v) {
  for (const char* form : {"formula", "table", "file", "layers", "grid", "power", "exponential", "hump", "callback"})
    if (v.is_table() && v.find(form)) return form;
  return "";
}

/// Laws of few numbers, of which one may be changed alone.
bool is_law(const std::string& form) { return form == "power" || form == "exponential" || form == "hump"; }

}  // namespace

Value Value::empty_table(const SourceLocation& location) {
  Value v;
  v.location = location;
  return v;
}

Value Value::of_text(std::string text, const SourceLocation& location) {
  Value v;
  v.type = Type::text;
  v.text = std::move(text);
  v.location = location;
  return v;
}

const Value* Value::find(const std::string& key) const {
  const auto found = std::ranges::find(entries, key, &Entry::key);
  return found == entries.end() ? nullptr : &found->value;
}

Value* Value::find(const std::string& key) { return const_cast<Value*>(std::as_const(*this).find(key)); }

std::string Value::described() const {
  switch (type) {
    case Type::text:
      return fmt::format("the text \"{}\"", text);
    case Type::flag:
      return flag ? "true" : "false";
    case Type::integer:
      return fmt::format("the number {}", integer);
    case Type::number:
      return fmt::format("the number {}", number);
    case Type::list:
      return list.empty() ? "an empty list" : "a list";
    case Type::table:
      return "a table";
    case Type::date:
      return "a date";
  }
  return {};
}

void merge(Value& into, const Value& changes) {
  const std::string form = form_of_function(changes);
  const bool is_other_function = !form.empty() && !(is_law(form) && form == form_of_function(into));
  if (!into.is_table() || !changes.is_table() || is_other_function) {
    into = changes;
    return;
  }
  for (const Entry& entry : changes.entries) {
    if (Value* old = into.find(entry.key))
      merge(*old, entry.value);
    else
      into.entries.push_back(entry);
  }
}

void set_path(Value& root, const std::vector<std::string>& keys, const Value& value) {
  Value* at = &root;
  std::string path;
  for (const std::string& key : keys) {
    if (!at->is_table())
      throw Error(Fault::bad_case, value.location, fmt::format("'{}' is {}, not a table", path, at->described()),
                  "a key=value changes whole lists and values: give a new one for " + path);
    path += (path.empty() ? "" : ".") + key;
    Value* next = at->find(key);
    if (!next) {
      at->entries.push_back({.key = key, .key_location = value.location, .value = Value::empty_table(value.location)});
      next = &at->entries.back().value;
    }
    at = next;
  }
  merge(*at, value);
}

}  // namespace calor
