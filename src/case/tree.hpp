#pragma once
// A case as it is written, before anybody asks what its keys mean: values and tables that know their location.
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"

namespace calor {

struct Value;

struct Entry;

struct Value {
  enum class Type { text, flag, integer, number, list, table, date };

  Type type = Type::table;
  std::string text;            ///< of Type::text
  bool flag = false;           ///< of Type::flag
  long integer = 0;            ///< of Type::integer
  double number = 0;           ///< of Type::number and Type::integer
  std::vector<Value> list;     ///< of Type::list
  std::vector<Entry> entries;  ///< of Type::table, in the order of the file
  SourceLocation location;

  static Value empty_table(const SourceLocation& location);
  static Value of_text(std::string text, const SourceLocation& location);
  bool is_number() const { return type == Type::number || type == Type::integer; }
  bool is_table() const { return type == Type::table; }
  /// Value of a key of a table; null where there is none.
  const Value* find(const std::string& key) const;
  Value* find(const std::string& key);
  /// Kind and value for messages: `the text "ten"`, `the number 1.5`, `a table`.
  std::string described() const;
};

/// One `key = value` of a table.
struct Entry {
  std::string key;
  SourceLocation key_location;
  Value value;
};

/// Reads TOML; `file` stands in messages. Throws Error(bad_case) with line and column for what is no TOML.
Value read_toml(const std::string& text, const std::string& file);

/// A single value in TOML; what is none, and does not begin like a string, list or table, is taken as text ("22 s",
/// disc). Every part of it gets `location`. Throws Error(bad_case).
Value read_toml_value(const std::string& text, const SourceLocation& location);

/// A table as TOML, from which it is read again: plain keys first, then a section for every table.
std::string toml_of(const Value& table);

/// Keys of a dotted path: cloud.radius, material."my steel".density. Throws Error(command).
std::vector<std::string> split_path(const std::string& path);

/// Merges `changes` deep into `into`: tables merge, everything else is replaced; so are functions, whose forms do not
/// mix ({ formula = ... }, { table = ... }, { layers = ... }), but for a law of the same form ({ power = 2 }).
void merge(Value& into, const Value& changes);

/// Sets the value at a path of keys, making tables on the way. Throws Error(bad_case) where the path meets no table.
void set_path(Value& root, const std::vector<std::string>& keys, const Value& value);

}  // namespace calor
