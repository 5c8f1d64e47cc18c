#include "case/keys.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "case/case.hpp"
#include "case/values.hpp"

namespace calor {
namespace {

/// What the table chooses for a key, written or by default; "" for nothing.
std::string choice(const std::vector<const Key*>& keys, const std::string& name, const Value* table) {
  if (const Value* v = table ? table->find(name) : nullptr) return v->type == Value::Type::text ? v->text : "";
  const auto key = std::ranges::find(keys, name, &Key::name);
  if (key != keys.end() && table)  // a key named like a choice makes it
    for (const std::string& chosen : (*key)->choices)
      if (table->find(chosen)) return chosen;
  return key != keys.end() && has_fallback(**key) ? fallback_value(**key, {}).text : "";
}

/// Says which choice a key of another one goes with.
std::string goes_with(const TableKeys& known, const std::string& key, const std::string& chosen) {
  std::vector<std::string> values;
  std::string when;
  for (const auto& [section, other] : known.others) {
    if (other->name != key) continue;
    when = section->when_key;
    if (!section->when_value.empty()) values.push_back('"' + section->when_value + '"');
  }
  if (values.empty()) return fmt::format("'{}' goes with '{}'", key, when);
  return fmt::format("'{}' goes with {} = {}{}", key, when, fmt::join(values, " or "),
                     chosen.empty() ? "" : fmt::format(", not \"{}\"", chosen));
}

class Checker {
 public:
  Checker(const Schema& schema, const Context& context) : schema_(schema), context_(context) {}

  /// `header`: the table in messages, "[material.steel]".
  void table(const Value& value, const std::string& schema_path, const std::string& path, const std::string& header) {
    const TableKeys known = keys_of(schema_, schema_path, &value);
    for (const Entry& entry : value.entries) {
      const Key* key = known.find(entry.key);
      if (!key && known.goes_elsewhere(entry.key))
        refuse_unknown(entry, known, value, header);
      else if (std::ranges::count(known.lists, entry.key))
        list(entry, schema_path, path);
      else if (std::ranges::count(known.tables, entry.key) || (!key && known.is_named_table(entry.key)))
        sub_table(entry, schema_path, path, std::ranges::count(known.tables, entry.key) ? entry.key : "*");
      else if (key)
        check_value(entry.value, named(*key, entry.key), context_);
      else
        refuse_unknown(entry, known, value, header);
    }
    for (const Key* key : known.keys)
      if (key->fallback == required && !value.find(key->name))
        throw Error(Fault::bad_case, value.location, fmt::format("{} needs '{}'", header, key->name),
                    key->kind == Kind::table ? fmt::format("add {}", wanted(*key))
                                             : fmt::format("add {} = {}", key->name, wanted(*key)));
  }

 private:
  void sub_table(const Entry& entry, const std::string& schema_path, const std::string& path,
                 const std::string& schema_name) {
    const std::string here = join(path, entry.key);
    if (!entry.value.is_table()) {
      const bool is_named = schema_name == "*";
      throw Error(Fault::bad_case, is_named ? entry.key_location : entry.value.location,
                  fmt::format("'{}' cannot be {}", entry.key, entry.value.described()),
                  is_named
                      ? fmt::format("[{0}] holds tables with names of your choice: write [{0}.NAME] above it", path)
                      : fmt::format("write a table: [{}]", here));
    }
    table(entry.value, join(schema_path, schema_name), here, "[" + here + "]");
  }

  void list(const Entry& entry, const std::string& schema_path, const std::string& path) {
    const std::string here = join(path, entry.key), header = "[[" + here + "]]";
    const bool is_list =
        entry.value.type == Value::Type::list && std::ranges::all_of(entry.value.list, &Value::is_table);
    if (!is_list)
      throw Error(Fault::bad_case, entry.value.location,
                  fmt::format("'{}' cannot be {}", entry.key, entry.value.described()),
                  fmt::format("there can be several: write {}", header));
    for (const Value& element : entry.value.list) table(element, join(schema_path, entry.key + "[]"), here, header);
  }

  [[noreturn]] void refuse_unknown(const Entry& entry, const TableKeys& known, const Value& table,
                                   const std::string& header) {
    const auto other = std::ranges::find(known.others, entry.key, [](const auto& o) { return o.key->name; });
    if (other != known.others.end()) {
      const std::string chosen = choice(known.keys, other->section->when_key, &table);
      throw Error(Fault::bad_case, entry.key_location, goes_with(known, entry.key, chosen),
                  fmt::format("leave it out, or {} '{}'", chosen.empty() ? "add" : "change", other->section->when_key));
    }
    std::vector<std::string> names;
    for (const Key* key : known.keys)
      if (!std::ranges::count(names, key->name)) names.push_back(key->name);
    for (const auto* more : {&known.tables, &known.lists})
      for (const std::string& name : *more)
        if (!std::ranges::count(names, name)) names.push_back(name);
    const std::string near = nearest(entry.key, names);
    throw Error(Fault::bad_case, entry.key_location, fmt::format("'{}' is not a key of {}", entry.key, header),
                near.empty() ? fmt::format("its keys are {}", fmt::join(names, ", "))
                             : fmt::format("did you mean '{}'?", near));
  }

  const Schema& schema_;
  const Context& context_;
};

}  // namespace

const Key* TableKeys::find(const std::string& name) const {
  const auto found = std::ranges::find(keys, name, &Key::name);
  return found == keys.end() ? any : *found;
}

bool TableKeys::goes_elsewhere(const std::string& name) const {
  return std::ranges::any_of(others, [&](const Other& other) { return other.key->name == name; });
}

bool TableKeys::is_named_table(const std::string& name) const { return named_tables && !goes_elsewhere(name); }

Key named(Key key, const std::string& name) {
  key.name = name;
  return key;
}

std::string join(const std::string& path, const std::string& name) { return path.empty() ? name : path + "." + name; }

TableKeys keys_of(const Schema& schema, const std::string& schema_path, const Value* table) {
  TableKeys known;
  for (const Section& section : schema.sections())
    if (section.path == schema_path && section.when_key.empty())
      for (const Key& key : section.keys) {
        if (key.name == "*")
          known.any = &key;
        else
          known.keys.push_back(&key);
      }
  const std::vector<const Key*> always = known.keys;
  for (const Section& section : schema.sections())
    if (section.path == schema_path && !section.when_key.empty()) {
      const std::string chosen = choice(always, section.when_key, table);
      const bool goes = section.when_value.empty() ? !chosen.empty() : chosen == section.when_value;
      for (const Key& key : section.keys) {
        if (goes)
          known.keys.push_back(&key);
        else
          known.others.push_back({&section, &key});
      }
    }
  const auto goes_already = [&](const TableKeys::Other& o) {
    return std::ranges::count(known.keys, o.key->name, &Key::name) > 0;
  };
  std::erase_if(known.others, goes_already);

  const std::string prefix = schema_path.empty() ? "" : schema_path + ".";
  for (const Section& section : schema.sections()) {
    if (!section.path.starts_with(prefix) || section.path.size() == prefix.size()) continue;
    std::string name = section.path.substr(prefix.size());
    name = name.substr(0, name.find('.'));
    if (name == "*") {
      known.named_tables = true;
      continue;
    }
    const bool is_list = name.ends_with("[]");
    if (is_list) name.resize(name.size() - 2);
    std::vector<std::string>& names = is_list ? known.lists : known.tables;
    if (!std::ranges::count(names, name)) names.push_back(name);
  }
  return known;
}

void check_case_tree(const Schema& schema, const Value& root, const Context& context) {
  Checker(schema, context).table(root, "", "", "the case");
}

}  // namespace calor
