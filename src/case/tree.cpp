#include "case/tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <system_error>

#include "case/entries.hpp"
#include "case/json.hpp"

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

std::string toml_key(const std::string& key) {
  const auto is_bare = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  return !key.empty() && std::ranges::all_of(key, is_bare) ? key : json_string(key);
}

/// A value on one line.
std::string toml_value(const Value& v) {
  std::string inner;
  switch (v.type) {
    case Value::Type::text:
      return json_string(v.text);
    case Value::Type::flag:
      return v.flag ? "true" : "false";
    case Value::Type::integer:
      return fmt::format("{}", v.integer);
    case Value::Type::number:  // the shortest text that is this number, and no integer
      return std::isfinite(v.number) && v.number == std::trunc(v.number) && std::abs(v.number) < 1e15
                 ? fmt::format("{:.1f}", v.number)
                 : fmt::format("{}", v.number);
    case Value::Type::list:
      for (const Value& entry : v.list) inner += (inner.empty() ? "" : ", ") + toml_value(entry);
      return '[' + inner + ']';
    case Value::Type::table:
      for (const Entry& entry : v.entries)
        inner += fmt::format("{} {} = {}", inner.empty() ? "" : ",", toml_key(entry.key), toml_value(entry.value));
      return '{' + inner + " }";
    case Value::Type::date:
      break;  // no key takes one
  }
  return "\"\"";
}

bool is_list_of_tables(const Value& v) {
  return v.type == Value::Type::list && !v.list.empty() && std::ranges::all_of(v.list, &Value::is_table);
}

bool takes_a_section(const Entry& entry) { return entry.value.is_table() || is_list_of_tables(entry.value); }

/// The keys of a table, then its tables as sections; `path` of the table with a dot behind it. What stands before a key
/// stays on a line before it, but for the top of the file: the order is kept.
std::string toml_section(const Value& table, const std::string& path) {
  const auto last_key = std::find_if_not(table.entries.rbegin(), table.entries.rend(), takes_a_section).base();
  std::string keys, sections;
  for (auto entry = table.entries.begin(); entry != table.entries.end(); ++entry) {
    const Value& value = entry->value;
    const std::string name = path + toml_key(entry->key);
    if (!takes_a_section(*entry) || (entry < last_key && !path.empty())) {
      keys += fmt::format("{} = {}\n", toml_key(entry->key), toml_value(value));
    } else if (value.is_table()) {
      const std::string inner = toml_section(value, name + '.');
      const bool holds_sections_alone = inner.starts_with('\n');  // which need no heading above theirs
      sections += holds_sections_alone ? inner : fmt::format("\n[{}]\n{}", name, inner);
    } else {
      for (const Value& one : value.list) sections += fmt::format("\n[[{}]]\n{}", name, toml_section(one, name + '.'));
    }
  }
  return keys + sections;
}

}  // namespace

std::string toml_of(const Value& table) { return toml_section(table, ""); }

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

std::optional<std::size_t> entry_of(const std::string& key) {
  std::size_t n = 0;
  const char *begin = key.data() + 1, *end = key.data() + key.size() - 1;
  if (key.size() < 3 || key.front() != '[' || key.back() != ']') return std::nullopt;
  const auto [last, error] = std::from_chars(begin, end, n);
  if (error != std::errc() || last != end) return std::nullopt;
  return n;
}

Value* find_at(Value& value, const std::string& key) {
  if (value.is_table()) return value.find(key);
  const auto n = entry_of(key);
  return n && value.type == Value::Type::list && *n < value.list.size() ? &value.list[*n] : nullptr;
}

void set_path(Value& root, const std::vector<std::string>& keys, const Value& value) {
  Value* at = &root;
  std::string path;
  for (const std::string& key : keys) {
    if (at->type == Value::Type::list && entry_of(key)) {
      at = find_at(*at, key);
      path += key;
      if (!at)
        throw Error(Fault::bad_case, value.location, fmt::format("the case has no '{}'", path),
                    "entries of lists are counted from 0");
      continue;
    }
    if (entry_of(key))
      throw Error(Fault::bad_case, value.location, fmt::format("the case has no list '{}'", path),
                  "[n] after a key is an entry of a list");
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
