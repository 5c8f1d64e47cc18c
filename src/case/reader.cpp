// The only file that knows toml++.
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <string_view>
#include <tuple>

#include "case/entries.hpp"
#include "case/tree.hpp"

namespace calor {
namespace {

/// Where things stand; with a fixed location for values that do not come from a file.
struct Locations {
  std::string file;
  const SourceLocation* fixed = nullptr;

  SourceLocation of(const toml::source_region& region) const {
    if (fixed) return *fixed;
    return {.file = file, .line = static_cast<int>(region.begin.line), .column = static_cast<int>(region.begin.column)};
  }
};

Value convert(const toml::node& node, const Locations& locations) {
  Value v;
  v.location = locations.of(node.source());
  if (const auto* table = node.as_table()) {
    v.type = Value::Type::table;
    // toml++ sorts by name; the order of the file is the order of the places.
    std::vector<std::tuple<toml::source_position, const toml::key*, const toml::node*>> in_order;
    for (auto&& [key, child] : *table) in_order.emplace_back(key.source().begin, &key, &child);
    std::ranges::stable_sort(in_order, [](const auto& a, const auto& b) { return std::get<0>(a) < std::get<0>(b); });
    for (const auto& [position, key, child] : in_order)
      v.entries.push_back({.key = std::string(key->str()),
                           .key_location = locations.of(key->source()),
                           .value = convert(*child, locations)});
  } else if (const auto* array = node.as_array()) {
    v.type = Value::Type::list;
    for (const toml::node& child : *array) v.list.push_back(convert(child, locations));
  } else if (const auto* text = node.as_string()) {
    v.type = Value::Type::text;
    v.text = text->get();
  } else if (const auto* integer = node.as_integer()) {
    v.type = Value::Type::integer;
    v.integer = static_cast<long>(integer->get());
    v.number = static_cast<double>(integer->get());
  } else if (const auto* number = node.as_floating_point()) {
    v.type = Value::Type::number;
    v.number = number->get();
  } else if (const auto* flag = node.as_boolean()) {
    v.type = Value::Type::flag;
    v.flag = flag->get();
  } else {
    v.type = Value::Type::date;
  }
  return v;
}

/// Refuses tables and lists that are nested deeper than any case needs: the parser would run out of stack.
void refuse_depth(const std::string& text, const std::string& file) {
  constexpr int deepest = 100;
  int depth = 0, dots = 0, line = 1;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (c == '"' || c == '\'') {
      const std::string three(3, c), end = text.compare(i, 3, three) == 0 ? three : std::string(1, c);
      for (i += end.size(); i < text.size() && text.compare(i, end.size(), end) != 0; ++i) {
        if (text[i] == '\n') ++line;
        if (text[i] == '\n' && end.size() == 1) break;  // not closed, as the parser will say
        if (c == '"' && text[i] == '\\') ++i;
      }
      i += end.size() - 1;
    } else {
      if (c == '[' || c == '{') ++depth;
      if (c == ']' || c == '}') --depth;
      if (c == '.') ++dots;
      if (std::string_view("[]{},=\n").find(c) != std::string_view::npos) dots = 0;
      if (c == '\n') ++line;
      if (std::max(depth, dots) > deepest)
        throw Error(Fault::bad_case, {.file = file, .line = line},
                    fmt::format("tables or lists are nested more than {} deep", deepest),
                    "no key of a case lies so deep");
    }
  }
}

/// What toml++ says, without the words that only its author needs.
std::string problem_of(std::string_view description) {
  if (description.find("control characters") != description.npos) return "the text is not closed on its line";
  return std::string(description);
}

std::string cure_of(std::string_view problem) {
  const auto says = [&](std::string_view words) { return problem.find(words) != problem.npos; };
  if (says("cannot redefine")) return "give every key and every [table] once";
  if (says("determine value type")) return "put texts in quotes, numbers as 1.5 or 1e-3";
  if (says("expected a comment or whitespace"))
    return "one key a line; a number with a unit goes in quotes, e.g. \"15 mm\"";
  if (says("string")) return "close the text with the quote it began with, on the same line";
  if (says("inline table")) return "write { key = value, key = value } in one line, without a comma at the end";
  if (says("array")) return "write a list as [1, 2, 3]";
  if (says("table header")) return "write [name] or [[name]]";
  return "the file is written in TOML: key = value, [table], \"text\"";
}

}  // namespace

Value read_toml(const std::string& text, const std::string& file) {
  refuse_depth(text, file);
  try {
    const toml::table table = toml::parse(std::string_view(text), std::string_view(file));
    Value root = convert(table, {.file = file});
    root.location = {.file = file, .line = 1, .column = 1};
    return root;
  } catch (const toml::parse_error& e) {
    const auto at = e.source().begin;
    throw Error(Fault::bad_case,
                {.file = file, .line = static_cast<int>(at.line), .column = static_cast<int>(at.column)},
                problem_of(e.description()), cure_of(e.description()));
  }
}

Value read_toml_value(const std::string& text, const SourceLocation& location) {
  refuse_depth(text, location.file);
  try {
    const toml::table table = toml::parse("value = " + text, std::string_view(location.file));
    if (table.size() == 1) return convert(*table.get("value"), {.file = location.file, .fixed = &location});
  } catch (const toml::parse_error& e) {
    if (text.find_first_of("\"'[{") == 0)
      throw Error(Fault::bad_case, location, fmt::format("{}: {}", text, e.description()), cure_of(e.description()));
  }
  return Value::of_text(text, location);
}

std::vector<std::string> split_path(const std::string& path) {
  const auto refuse = [&]() {
    throw Error(Fault::command, fmt::format("'{}' is not the path of a key", path),
                "write it as in cloud.radius=\"20 mm\"");
  };
  std::vector<std::string> keys;
  refuse_depth(path, "");
  for (std::size_t at = 0; at < path.size();) {
    if (path[at] == '[') {
      const std::size_t end = std::min(path.find(']', at), path.size() - 1);
      keys.push_back(path.substr(at, end + 1 - at));
      if (keys.size() == 1 || !entry_of(keys.back())) refuse();
      at = end + 1;
      continue;
    }
    if (!keys.empty() && path[at++] != '.') refuse();
    std::size_t end = at;
    for (char quote = 0; end < path.size() && (quote != 0 || path[end] != '['); ++end) {
      if (path[end] == quote)
        quote = 0;
      else if (quote == 0 && (path[end] == '"' || path[end] == '\''))
        quote = path[end];
    }
    const std::size_t before = keys.size();
    try {
      const toml::table table = toml::parse(path.substr(at, end - at) + " = 0", std::string_view());
      for (const toml::table* in = &table; in && in->size() == 1; in = in->begin()->second.as_table())
        keys.emplace_back(in->begin()->first.str());
    } catch (const toml::parse_error&) {
    }
    if (keys.size() == before) refuse();
    at = end;
  }
  if (keys.empty()) refuse();
  return keys;
}

}  // namespace calor
