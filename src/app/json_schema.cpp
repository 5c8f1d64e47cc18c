#include "app/json_schema.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "case/keys.hpp"
#include "case/values.hpp"

namespace calor {
namespace {

using Json = nlohmann::ordered_json;

/// A number, and behind it anything but a number: which units convert is left to the reader.
constexpr const char* number_with_unit = R"(^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*[^\s\d].*$)";
constexpr const char* pure_number = R"(^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*$)";

Json one_or_list(const Json& element) {
  return {{"anyOf", {element, {{"type", "array"}, {"items", element}, {"minItems", 1}}}}};
}

Json quantity(const std::string& unit) {
  if (!unit.empty()) return {{"type", "string"}, {"pattern", number_with_unit}};
  return {{"anyOf", {{{"type", "number"}}, {{"type", "string"}, {"pattern", pure_number}}}}};
}

/// The forms of a function as tables, and those that a key takes besides.
Json function(const Key& key) {
  const Json text = {{"type", "string"}}, any = Json::object();
  const Json pair = {{"type", "array"}, {"minItems", 2}, {"maxItems", 2}};
  struct Form {
    std::string name;
    Json value;
    std::vector<std::string> others;
  };
  const std::vector<Form> forms = {
      {"formula", text, {"unit", "length", "time", "temperature", "breaks"}},
      {"table",
       {{"type", "array"}, {"items", pair}, {"minItems", 2}},
       {"of", "along", "unit", "temperature", "time", "length", "interpolation"}},
      {"file", text, {"of", "along", "interpolation"}},
      {"layers", {{"type", "array"}, {"minItems", 1}}, {"along", "thickness", "start", "unit"}},
      {"grid", {{"type", "array"}, {"minItems", 2}}, {"along", "from", "to", "unit"}},
      {"power", {{"type", "number"}}, {"along", "from", "to", "values", "unit"}},
      {"exponential", {{"type", "number"}}, {"along", "from", "to", "values", "unit"}},
      {"hump", pair, {"along", "from", "to", "factor", "unit"}},
      {"callback", text, {}}};
  Json all = {quantity(key.unit)};
  for (const Form& form : forms) {
    Json properties = {{form.name, form.value}};
    for (const std::string& other : form.others) properties[other] = any;
    Json needed = {form.name};
    if (!key.unit.empty() && (form.name == "formula" || form.name == "table")) needed.push_back("unit");
    all.push_back(
        {{"type", "object"}, {"properties", properties}, {"required", needed}, {"additionalProperties", false}});
  }
  for (const std::string& form : key.choices)
    all.push_back(
        {{"type", "object"}, {"properties", {{form, text}}}, {"required", {form}}, {"additionalProperties", false}});
  return {{"anyOf", all}};
}

Json value_schema(const Key& key) {
  switch (key.kind) {
    case Kind::text:
      return {{"type", "string"}};
    case Kind::choice:
      return {{"enum", key.choices}};
    case Kind::flag:
      return {{"type", "boolean"}};
    case Kind::integer:
      return {{"type", "integer"}};
    case Kind::number:
      return {{"type", "number"}};
    case Kind::quantity:
    case Kind::difference:
      return quantity(key.unit);
    case Kind::function:
      return function(key);
    case Kind::texts:
      return one_or_list({{"type", "string"}});
    case Kind::integers:
      return one_or_list({{"type", "integer"}});
    case Kind::numbers:
      return one_or_list({{"type", "number"}});
    case Kind::quantities:
      return one_or_list(quantity(key.unit));
    case Kind::raw_quantities:
      return one_or_list({{"type", {"number", "string"}}});
    case Kind::table:
      return {{"type", {"object", "array"}}};
  }
  return Json::object();
}

/// With what an editor shows.
Json described(Json value, const Key& key) {
  const std::string unit = key.unit.empty() ? "" : " [" + key.unit + "]";
  value["description"] = key.sentence + unit;
  if (has_fallback(key)) {
    const Value written = fallback_value(key, {});
    if (written.type == Value::Type::text) value["default"] = written.text;
    if (written.type == Value::Type::flag) value["default"] = written.flag;
    if (written.type == Value::Type::integer) value["default"] = written.integer;
    if (written.type == Value::Type::number) value["default"] = written.number;
  }
  return value;
}

class Tables {
 public:
  explicit Tables(const Schema& schema) : schema_(schema) {}

  Json of(const std::string& path) const {
    const TableKeys known = keys_of(schema_, path, nullptr);
    Json properties = Json::object(), conditions = Json::array(), needed = Json::array();
    for (const Key* key : always(path)) {
      add(properties, *key);
      if (key->fallback == required) needed.push_back(key->name);
    }
    add_choices(path, properties, conditions);
    for (const std::string& name : known.tables) {
      const std::string sentence = properties.contains(name) ? properties[name].value("description", "") : "";
      const Json table = of(join(path, name));
      properties[name] = properties.contains(name) && properties[name].contains("anyOf")
                             ? Json{{"anyOf", {table, properties[name]}}}
                             : table;
      if (!sentence.empty()) properties[name]["description"] = sentence;
    }
    for (const std::string& name : known.lists)
      properties[name] = {{"type", "array"}, {"items", of(join(path, name + "[]"))}};

    Json table = {{"type", "object"}, {"description", sentence(path)}, {"properties", properties}};
    if (!needed.empty()) table["required"] = needed;
    if (!conditions.empty()) table["allOf"] = conditions;
    if (known.any)
      table["additionalProperties"] = described(value_schema(*known.any), *known.any);
    else if (known.named_tables)
      table["additionalProperties"] = of(join(path, "*"));
    else
      table["additionalProperties"] = false;
    return table;
  }

 private:
  std::vector<const Section*> sections(const std::string& path) const {
    std::vector<const Section*> all;
    for (const Section& section : schema_.sections())
      if (section.path == path) all.push_back(&section);
    return all;
  }
  std::string sentence(const std::string& path) const {
    for (const Section* section : sections(path))
      if (section->when_key.empty()) return section->sentence;
    return "";
  }
  std::vector<const Key*> always(const std::string& path) const {
    std::vector<const Key*> keys;
    for (const Section* section : sections(path))
      for (const Key& key : section->keys)
        if (section->when_key.empty() && key.name != "*") keys.push_back(&key);
    return keys;
  }

  /// A key that several sections declare takes what any of them allows.
  static void add(Json& properties, const Key& key) {
    const Json value = described(value_schema(key), key);
    if (!properties.contains(key.name)) {
      properties[key.name] = value;
    } else if (properties[key.name] != value) {
      Json& former = properties[key.name];
      if (!former.contains("anyOf") || former.contains("description")) former = {{"anyOf", {former}}};
      former["anyOf"].push_back(value);
    }
  }

  /// That the table makes the choice a section goes with: written, by default, or by a key named like it.
  Json chosen(const Section& section, const std::vector<const Key*>& unconditional) const {
    Json written = {{"required", {section.when_key}}};
    if (section.when_value.empty()) return written;
    Json ways = {
        {{"properties", {{section.when_key, {{"const", section.when_value}}}}}, {"required", {section.when_key}}}};
    const auto key = std::ranges::find(unconditional, section.when_key, &Key::name);
    if (key == unconditional.end()) return ways[0];
    if (std::ranges::count((*key)->choices, section.when_value)) ways.push_back({{"required", {section.when_value}}});
    if (has_fallback(**key) && fallback_value(**key, {}).text == section.when_value) ways.push_back({{"not", written}});
    return {{"anyOf", ways}};
  }

  /// Keys that go with choices: those that a choice needs, and none without one of theirs.
  void add_choices(const std::string& path, Json& properties, Json& conditions) const {
    const std::vector<const Key*> unconditional = always(path);
    std::vector<std::string> order;
    std::map<std::string, Json> goes_with;
    for (const Section* section : sections(path)) {
      if (section->when_key.empty()) continue;
      const Json choice = chosen(*section, unconditional);
      Json needed = Json::array();
      for (const Key& key : section->keys) {
        add(properties, key);
        if (key.fallback == required) needed.push_back(key.name);
        if (std::ranges::count(unconditional, key.name, &Key::name)) continue;
        if (!goes_with.contains(key.name)) order.push_back(key.name);
        goes_with[key.name].push_back(choice);
      }
      if (!needed.empty()) conditions.push_back({{"if", choice}, {"then", {{"required", needed}}}});
    }
    // A wrong choice is a fault of its own, and none of all keys that go with one.
    Json choices = Json::object();
    for (const Key* key : unconditional)
      if (key->kind == Kind::choice) choices[key->name] = value_schema(*key);
    for (const std::string& name : order)
      conditions.push_back(
          {{"if", {{"required", {name}}, {"properties", choices}}}, {"then", {{"anyOf", goes_with[name]}}}});
  }

  const Schema& schema_;
};

}  // namespace

std::string json_schema(const Schema& schema) {
  Json root = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "Case file of calor " CALOR_VERSION}};
  root.update(Tables(schema).of(""));
  root["oneOf"] = {{{"required", {"steady"}}}, {{"required", {"time"}}}};
  return root.dump(1) + "\n";
}

}  // namespace calor
