#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "base/units.hpp"
#include "case/json.hpp"
#include "case/keys.hpp"

namespace calor {

Key Table::Node::key(const std::string& name) const {
  for (const Key& form : forms)
    if (form.name == name) return form;
  if (const Key* found = known.find(name)) return found->name == "*" ? named(*found, name) : *found;
  for (const auto& [section, other] : known.others)
    if (other->name == name) return *other;
  throw std::logic_error(fmt::format("'{}' of [{}] is not declared in the schema", name, schema_path));
}

Value Table::Node::get(const std::string& name) const {
  const Key declared = key(name);
  if (const Value* v = written(name)) return *v;
  if (has_fallback(declared)) return fallback_value(declared, location);
  throw Error(Fault::bad_case, location,
              fmt::format("{} needs '{}'", path.empty() ? "the case" : "[" + path + "]", name),
              fmt::format("add {} = {}", name, wanted(declared)));
}

std::shared_ptr<Table::Node> Table::Node::child(const std::string& name, const std::string& schema_name,
                                                const Value* child_value) const {
  auto node = std::make_shared<Node>();
  node->root = root;
  node->context = context;
  node->schema = schema;
  node->path = join(path, name);
  node->schema_path = join(schema_path, schema_name);
  node->value = child_value;
  node->location = child_value ? child_value->location : location;
  node->known = keys_of(*schema, node->schema_path, child_value);
  return node;
}

bool Table::has(const std::string& key) const { return node_->written(key) != nullptr; }

bool Table::given(const std::string& key) const { return has(key) || has_fallback(node_->key(key)); }

std::string Table::text(const std::string& key) const { return read_text(node_->get(key), node_->key(key)); }

bool Table::flag(const std::string& key) const { return read_flag(node_->get(key), node_->key(key)); }

long Table::integer(const std::string& key) const { return read_integer(node_->get(key), node_->key(key)); }

double Table::number(const std::string& key) const { return read_number(node_->get(key), node_->key(key)); }

Function Table::function(const std::string& key) const {
  return read_function(node_->get(key), node_->key(key), *node_->context);
}

std::vector<std::string> Table::texts(const std::string& key) const {
  return read_texts(node_->get(key), node_->key(key));
}

std::vector<long> Table::integers(const std::string& key) const {
  return read_integers(node_->get(key), node_->key(key));
}

std::vector<double> Table::numbers(const std::string& key) const {
  return read_numbers(node_->get(key), node_->key(key));
}

std::vector<std::pair<double, std::string>> Table::quantities_with_units(const std::string& key) const {
  return read_raw_quantities(node_->get(key), node_->key(key));
}

double Table::in_si(const std::string& key, const std::pair<double, std::string>& written, const std::string& si,
                    const std::string& what, const std::string& cure) const {
  const auto& [value, unit] = written;
  try {
    return difference_to_si(value, unit, si);
  } catch (const std::invalid_argument& e) {
    refuse(key, fmt::format("\"{} {}\" is no {}: {}", value, unit, what, e.what()), cure);
  }
}

Table Table::sub(const std::string& key) const {
  const Value* value = node_->written(key);
  if (value && !value->is_table()) value = nullptr;
  const bool is_declared = std::ranges::count(node_->known.tables, key) > 0;
  auto child = node_->child(key, !is_declared && node_->known.named_tables ? "*" : key, value);
  if (const Key* function = node_->known.find(key))
    for (const std::string& form : function->kind == Kind::function ? function->choices : std::vector<std::string>{})
      child->forms.push_back({form, Kind::text, "", optional, ""});
  return Table(child);
}

std::vector<std::pair<std::string, Table>> Table::children() const {
  std::vector<std::pair<std::string, Table>> out;
  if (!node_->value) return out;
  for (const Entry& entry : node_->value->entries)
    if (entry.value.is_table()) out.emplace_back(entry.key, sub(entry.key));
  return out;
}

std::vector<std::string> Table::keys() const {
  std::vector<std::string> out;
  if (node_->value)
    for (const Entry& entry : node_->value->entries) out.push_back(entry.key);
  return out;
}

std::vector<Function> Table::functions() const {
  std::vector<Function> out;
  for (const std::string& name : keys()) {
    const Key* key = node_->known.find(name);
    const auto is_written = [&](const std::string& form) { return sub(name).has(form); };
    if (key && key->kind == Kind::function) {
      if (std::ranges::none_of(key->choices, is_written)) out.push_back(function(name));
    } else if (node_->written(name)->is_table()) {
      std::ranges::copy(sub(name).functions(), std::back_inserter(out));
    } else if (std::ranges::any_of(node_->written(name)->list, &Value::is_table)) {
      for (const Table& of_list : list(name)) std::ranges::copy(of_list.functions(), std::back_inserter(out));
    }
  }
  return out;
}

std::vector<Table> Table::list(const std::string& key) const {
  std::vector<Table> out;
  const Value* value = node_->written(key);
  if (!value) return out;
  for (const Value& element : value->list)
    out.emplace_back(node_->child(fmt::format("{}[{}]", key, out.size() + 1), key + "[]", &element));
  return out;
}

SourceLocation Table::location(const std::string& key) const {
  const Value* value = key.empty() ? nullptr : node_->written(key);
  return value ? value->location : node_->location;
}

const std::string& Table::path() const { return node_->path; }

std::string Table::file(const std::string& key) const { return node_->context->path_of(text(key)); }

LengthOfPlace& Table::length_of_place(const std::string& name) const { return *node_->context->lengths.at(name); }

void Table::refuse(const std::string& key, const std::string& what, const std::string& cure) const {
  throw Error(Fault::bad_case, location(key), what, cure);
}

namespace {

std::string json_of(const Value& value);

void append(std::string& members, const std::string& key, const std::string& value) {
  members += fmt::format("{}{}: {}", members.empty() ? "" : ", ", json_string(key), value);
}

std::string json_of(const Value& value) {
  std::string out;
  switch (value.type) {
    case Value::Type::text:
      return json_string(value.text);
    case Value::Type::flag:
      return value.flag ? "true" : "false";
    case Value::Type::integer:
      return fmt::format("{}", value.integer);
    case Value::Type::number:
      return json_number(value.number);
    case Value::Type::list:
      for (const Value& v : value.list) out += (out.empty() ? "" : ", ") + json_of(v);
      return "[" + out + "]";
    case Value::Type::table:
      for (const Entry& entry : value.entries) append(out, entry.key, json_of(entry.value));
      return "{" + out + "}";
    case Value::Type::date:
      break;
  }
  return "null";
}

/// An absent table whose defaults hold all the same: one that needs nothing, and whose absence says nothing.
bool stands_by_default(const Table::Node& parent, const Table::Node& child, const std::string& name) {
  const Key* key = parent.known.find(name);
  if (key && key->kind == Kind::table && key->fallback == optional) return false;
  return std::ranges::none_of(child.known.keys, [](const Key* k) { return k->fallback == required; });
}

std::string json_of(const Table::Node& node) {
  std::string out;
  const auto is_in = [](const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::count(names, name) > 0;
  };
  for (const Entry& entry : node.value ? node.value->entries : std::vector<Entry>{}) {
    if (node.path.empty() && entry.key == "variant") continue;  // another case
    const bool is_section = is_in(node.known.tables, entry.key);
    const bool is_named = !node.known.find(entry.key) && node.known.named_tables;
    if (entry.value.is_table() && (is_section || is_named)) {
      append(out, entry.key, json_of(*node.child(entry.key, is_section ? entry.key : "*", &entry.value)));
    } else if (is_in(node.known.lists, entry.key)) {
      std::string elements;
      for (const Value& v : entry.value.list)
        elements += (elements.empty() ? "" : ", ") + json_of(*node.child(entry.key, entry.key + "[]", &v));
      append(out, entry.key, "[" + elements + "]");
    } else {
      append(out, entry.key, json_of(entry.value));
    }
  }
  std::vector<std::string> done;
  for (const Key* key : node.known.keys)
    if (has_fallback(*key) && !node.written(key->name) && !is_in(done, key->name)) {
      const auto by_its_key =
          std::ranges::find_if(key->choices, [&](const auto& c) { return node.written(c) != nullptr; });
      const bool is_chosen = key->kind == Kind::choice && by_its_key != key->choices.end();
      append(out, key->name, json_of(is_chosen ? Value::of_text(*by_its_key, {}) : fallback_value(*key, {})));
      done.push_back(key->name);
    }
  for (const std::string& name : node.known.tables) {
    if (node.written(name)) continue;
    const auto child = node.child(name, name, nullptr);
    const std::string defaults = stands_by_default(node, *child, name) ? json_of(*child) : "{}";
    if (defaults != "{}") append(out, name, defaults);
  }
  return "{" + out + "}";
}

}  // namespace

std::string Case::json() const { return json_of(root_.node()); }

}  // namespace calor
