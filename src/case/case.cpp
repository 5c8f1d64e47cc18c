#include "case/case.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "base/units.hpp"
#include "case/entries.hpp"
#include "case/json.hpp"
#include "case/keys.hpp"
#include "case/schema.hpp"
#include "case/tree.hpp"
#include "case/values.hpp"

namespace calor {
namespace {

/// Refuses names that formulas cannot use for a parameter or a function.
void check_name(const Entry& entry, const std::string& what) {
  static constexpr std::array reserved{"x", "y", "z", "r", "t", "T", "pi", "e"};
  const auto refuse = [&](const std::string& cure) {
    throw Error(Fault::bad_case, entry.key_location, fmt::format("'{}' cannot be a {}", entry.key, what), cure);
  };
  const auto is_letter = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  if (std::ranges::count(reserved, entry.key))
    refuse(fmt::format("formulas have a meaning for {}: choose another name", fmt::join(reserved, ", ")));
  if (entry.key.empty() || std::isdigit(static_cast<unsigned char>(entry.key[0])) ||
      !std::ranges::all_of(entry.key, is_letter))
    refuse("names are made of letters, digits and _");
}

/// [parameter] as far as it is right; what is wrong is refused here, before a formula uses it.
std::map<std::string, double> read_parameters(const Value& root) {
  std::map<std::string, double> parameters;
  const Value* section = root.find("parameter");
  if (!section || !section->is_table()) return parameters;
  for (const Entry& entry : section->entries) {
    check_name(entry, "parameter");
    parameters[entry.key] = read_number(entry.value, {entry.key, Kind::number, "", required, ""});
  }
  return parameters;
}

/// Puts [function] into the context, as far as it is right: every formula may name those above it.
void read_formulas(const Value& root, Context& context) {
  context.formulas.clear();
  const Value* section = root.find("function");
  if (!section || !section->is_table()) return;
  for (const Entry& entry : section->entries) {
    const Value* formula = entry.value.is_table() ? entry.value.find("formula") : nullptr;
    if (!formula) continue;  // the check says so
    check_name(entry, "function");
    if (context.parameters.contains(entry.key))
      throw Error(Fault::bad_case, entry.key_location,
                  fmt::format("'{}' is the name of a parameter and of a function", entry.key), "rename one of them");
    const std::string text = context.expanded(read_text(*formula, {"formula", Kind::text, "", required, ""}));
    std::map<std::string, double> names = context.parameters;
    names[entry.key] = 0;  // for the message where the name is one that formulas know
    Function::formula(text, {}, names, formula->location, {}, context.lengths);
    Function::formula(text, {}, context.parameters, formula->location, {},
                      context.lengths);  // a function does not name itself
    context.formulas[entry.key] = '(' + text + ')';
  }
}

/// The names of [cloud.distance]; what they stand for is known when the body is made.
LengthsOfPlace read_lengths(const Value& root) {
  LengthsOfPlace lengths;
  const Value* cloud = root.find("cloud");
  const Value* section = cloud ? cloud->find("distance") : nullptr;
  if (!section || !section->is_table()) return lengths;
  for (const Entry& entry : section->entries) {
    check_name(entry, "distance");
    lengths[entry.key] = std::make_shared<LengthOfPlace>();
  }
  return lengths;
}

std::vector<std::string> variant_names(const Value& root) {
  std::vector<std::string> names;
  const Value* variants = root.find("variant");
  if (!variants || variants->type != Value::Type::list) return names;
  for (const Value& variant : variants->list) {
    const Value* name = variant.find("name");
    if (!name || name->type != Value::Type::text) continue;  // the check says so
    if (std::ranges::count(names, name->text))
      refuse_value(*name, fmt::format("there are two variants \"{}\"", name->text), "give each a name of its own");
    names.push_back(name->text);
  }
  return names;
}

void apply_variant(const Schema& schema, Value& root, const Value& variant) {
  if (const Value* remove = variant.find("remove")) {
    for (const std::string& path : read_texts(*remove, {"remove", Kind::texts, "", optional, ""})) {
      const std::vector<std::string> keys = split_path(path);
      Value* table = &root;
      for (std::size_t n = 0; table && n + 1 < keys.size(); ++n) table = find_at(*table, keys[n]);
      if (!table || !table->is_table() || !table->find(keys.back()))
        refuse_value(*remove, fmt::format("the case has no '{}' to remove", path), "check the name");
      std::erase_if(table->entries, [&](const Entry& entry) { return entry.key == keys.back(); });
    }
  }
  if (const Value* set = variant.find("set")) change_case(schema, root, {}, *set);
  if (const Value* expect = variant.find("expect")) set_path(root, {"expect"}, *expect);
}

/// The case with a variant (null for the base case).
Value with_variant(const Schema& schema, const Value& written, const Value* variant) {
  Value root = written;
  if (variant) apply_variant(schema, root, *variant);
  return root;
}

struct Override {
  std::string path, value;
};

Override split_override(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == text.npos || equals == 0)
    throw Error(Fault::command, fmt::format("'{}' is not key=value", text), "write it as in cloud.radius=\"20 mm\"");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

}  // namespace

Case Case::read(const std::string& path, const Schema& keys, const std::vector<std::string>& overrides,
                const Callbacks& callbacks) {
  constexpr std::size_t most_bytes = 1 << 26;  // tables of data belong in CSV files, and /dev/zero never ends
  std::ifstream in(path);
  std::string text(std::min<std::uintmax_t>(most_bytes + 1, 1 << 16), '\0');
  std::size_t size = 0;
  while (in.read(text.data() + size, static_cast<std::streamsize>(text.size() - size)) || in.gcount() > 0) {
    size += static_cast<std::size_t>(in.gcount());
    if (size > most_bytes)
      throw Error(Fault::file, SourceLocation{.file = path}, "the file is larger than 64 MB",
                  "check the name: a case is a short text");
    if (size == text.size()) text.resize(std::min(2 * text.size(), most_bytes + 1));
  }
  text.resize(size);
  if (!in.eof() || std::filesystem::is_directory(path))
    throw Error(Fault::file, SourceLocation{.file = path}, "the case cannot be read", "check the name of the file");
  return parse(text, path, keys, overrides, callbacks);
}

Case Case::parse(const std::string& text, const std::string& name, const Schema& keys,
                 const std::vector<std::string>& overrides, const Callbacks& callbacks) {
  const Value written = read_toml(text, name);
  const std::vector<std::string> variants = variant_names(written);
  const Value* all_variants = variants.empty() ? nullptr : written.find("variant");

  std::string chosen;
  const Value* variant = nullptr;
  std::vector<Override> changes;
  for (const std::string& override : overrides) {
    const Override change = split_override(override);
    if (change.path != "variant") {
      changes.push_back(change);
      continue;
    }
    const Value in_quotes = read_toml_value(change.value, {.file = "command line (variant)"});
    const std::string wanted = in_quotes.type == Value::Type::text ? in_quotes.text : change.value;
    if (variant)
      throw Error(Fault::command, SourceLocation{.file = name},
                  fmt::format("two variants are asked for, \"{}\" and \"{}\"", chosen, wanted),
                  "a run takes one: give the other changes as key=value");
    chosen = wanted;
    const auto found = std::ranges::find(variants, chosen);
    if (found == variants.end())
      throw Error(Fault::command, SourceLocation{.file = name}, fmt::format("there is no variant \"{}\"", chosen),
                  variants.empty() ? "the case has no variants: leave variant= out"
                                   : fmt::format("the variants are {}", fmt::join(variants, ", ")));
    for (const Value& v : all_variants->list)
      if (v.find("name") && v.find("name")->text == chosen) variant = &v;
  }

  auto context = std::make_shared<Context>();
  context->folder = std::filesystem::path(name).parent_path().string();
  context->callbacks = callbacks;
  const auto check = [&](const Value& root) {
    context->parameters = read_parameters(root);
    context->lengths = read_lengths(root);
    read_formulas(root, *context);
    check_case_tree(keys, root, *context);
  };
  if (overrides.empty() && all_variants)
    for (const Value& v : all_variants->list) check(with_variant(keys, written, &v));

  auto node = std::make_shared<Table::Node>();
  node->root = std::make_shared<Value>(with_variant(keys, written, variant));
  for (const Override& change : changes) {
    const SourceLocation location{.file = fmt::format("command line ({})", change.path)};
    change_case(keys, *node->root, split_path(change.path), read_toml_value(change.value, location));
  }
  check(*node->root);
  if (variant)  // it is in its place, and the others start from the case as it was
    std::erase_if(node->root->entries, [](const Entry& entry) { return entry.key == "variant"; });
  node->value = node->root.get();
  node->location = node->value->location;
  node->context = context;
  node->schema = std::make_shared<Schema>(keys);
  node->known = keys_of(*node->schema, "", node->value);

  Case c{Table(node)};
  c.path_ = name;
  c.name_ = std::filesystem::path(name).stem().string() + (chosen.empty() ? "" : "/" + chosen);
  c.variants_ = variants;
  c.context_ = context;
  return c;
}

namespace {

/// A condition is 0 or 1, or a whole number where conditions are added; looked at where a body may well be. Not every
/// formula is finite there.
bool is_condition(const Function& f) {
  constexpr int places = 64;
  for (int n = 1; n <= places; ++n) {
    const double size = std::pow(10, -4 + n % 5);  // 0.1 mm to 1 m
    const Vec3 x = size * Vec3{std::sin(1.7 * n), std::sin(2.9 * n), std::sin(4.3 * n)};
    double value = 0;
    try {
      f.evaluate({.x = {&x, 1}}, {&value, 1});
    } catch (const Error&) {
      continue;
    }
    if (value != std::round(value)) return false;
  }
  return true;
}

}  // namespace

Function where_function(const Case& c, const Table& table) {
  try {
    to_si(1, table.text("length"), "m");
  } catch (const std::invalid_argument& e) {
    table.refuse("length", fmt::format("'length' = \"{}\": {}", table.text("length"), e.what()),
                 "write a unit of length, such as \"mm\"");
  }
  Function f = Function::formula(c.context().expanded(table.text("where")),
                                 {.value = "", .si = "", .length = table.text("length")}, c.context().parameters,
                                 table.location("where"), {}, c.context().lengths);
  if (f.depends_on_time() || f.depends_on_temperature())
    table.refuse("where",
                 fmt::format("'where' = \"{}\" depends on {}", table.text("where"),
                             f.depends_on_time() ? "time" : "temperature"),
                 "use x, y, z and r only");
  if (!is_condition(f))
    table.refuse(
        "where",
        fmt::format("'where' = \"{0}\" is a number, and no condition that holds or does not", table.text("where")),
        fmt::format("write a comparison, such as \"{} > 0\"", table.text("where")));
  return f;
}

std::vector<char> where(const Case& c, const Table& table, std::span<const Vec3> x) {
  const Function f = where_function(c, table);
  std::vector<double> value(x.size());
  f.evaluate({.x = x}, value);
  std::vector<char> selected(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) selected[i] = value[i] != 0;
  return selected;
}

std::vector<Key> where_keys(const std::string& sentence) {
  return {{"where", Kind::text, "", optional, sentence},
          {"length", Kind::text, "", "m", "Unit of x, y, z and r in 'where'."}};
}

void declare_case(Schema& schema) {
  schema.add({.path = "",
              .sentence = "At the top of the file.",
              .keys = {
                  {"title", Kind::text, "", required, "One line that says what the case is about."},
                  {"cloud", Kind::table, "", required, "The points that stand for the body."},
                  {"material", Kind::table, "", required, "What the body is made of, one table a material."},
                  {"steady", Kind::table, "", optional, "Asks for the steady temperature; either this or [time]."},
                  {"time", Kind::table, "", optional, "Asks for the temperature over time; either this or [steady]."},
              }});
  schema.add({.path = "parameter",
              .sentence = "Numbers that every formula of the case may use by their names.",
              .keys = {{"*", Kind::number, "", optional, "Any name but x, y, z, r, t, T, pi and e."}}});
  schema.add({.path = "function.*",
              .sentence = "A formula that others may use by its name: [function.V] formula = \"(y/b)^M\", then "
                          "fraction = { formula = \"1 - V\" }.",
              .keys = {{"formula", Kind::text, "", required,
                        "Stands, as if in parentheses, in the place of the name; x, y, z, r, t and T are those of the "
                        "formula that uses it. It may use [parameter] and the functions above it."}}});
  schema.add({.path = "variant[]",
              .sentence =
                  "The same case with some keys changed: `calor run CASE.toml variant=NAME`; `calor verify` runs "
                  "the case and all its variants.",
              .keys = {
                  {"name", Kind::text, "", required, "What variant=NAME calls it."},
                  {"remove", Kind::texts, "", optional, "Keys or whole tables to take out first: [\"steady\"]."},
                  {"set", Kind::table, "", optional,
                   "What changes, merged deep into the case; lists and functions are replaced."},
                  {"expect", Kind::table, "", optional, "[[variant.expect]] replaces the expectations of the case."},
              }});
}

}  // namespace calor
