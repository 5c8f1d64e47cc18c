#pragma once
// What the schema says about one table of a case.
#include <memory>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/values.hpp"

namespace calor {

/// The keys of one table; a choice in the table (`when_key`) may decide which they are. Pointers go into the schema.
struct TableKeys {
  struct Other {
    const Section* section;
    const Key* key;
  };
  std::vector<const Key*> keys;
  std::vector<Other> others;        ///< keys that go with another choice
  std::vector<std::string> tables;  ///< names of sub-tables that have a section
  std::vector<std::string> lists;   ///< names of arrays of tables that have a section
  const Key* any = nullptr;         ///< stands for all names: [parameter]
  bool named_tables = false;        ///< sub-tables have names of the user's: [material.NAME]

  const Key* find(const std::string& name) const;
  /// A key that goes with another choice.
  bool goes_elsewhere(const std::string& name) const;
  /// A name of the user's for a sub-table, rather than one of the schema's.
  bool is_named_table(const std::string& name) const;
};

/// The declaration of "*" for one of the names that it stands for.
Key named(Key key, const std::string& name);

/// `table` may be null: all defaults.
TableKeys keys_of(const Schema& schema, const std::string& schema_path, const Value* table);

/// Path of a sub-table in the schema: "material" + "*".
std::string join(const std::string& path, const std::string& name);

/// Checks a whole case: every key known, every value as declared, nothing missing. Throws Error(bad_case).
void check_case_tree(const Schema& schema, const Value& root, const Context& context);

/// Merges the value into the case `root` at a path of keys; none for a table of changes to the whole. What the change
/// replaces goes: keys in whose place a new one stands, and keys of a choice (the shape of a cloud) that is no longer
/// made. Throws Error(bad_case) where the path meets no table.
void change_case(const Schema& schema, Value& root, const std::vector<std::string>& keys, const Value& value);

/// What a Table holds on to.
struct Table::Node {
  std::shared_ptr<Value> root;  ///< keeps the whole case alive
  std::shared_ptr<const Context> context;
  std::shared_ptr<const Schema> schema;
  std::string path, schema_path;
  const Value* value = nullptr;  ///< into root; null where the table is absent
  SourceLocation location;
  TableKeys known;
  std::vector<Key> forms;  ///< of a function: keys that stand for other forms than functions

  Key key(const std::string& name) const;
  /// Written value, or null.
  const Value* written(const std::string& name) const { return value ? value->find(name) : nullptr; }
  /// Written value or default; throws Error where there is neither.
  Value get(const std::string& name) const;
  std::shared_ptr<Node> child(const std::string& name, const std::string& schema_name, const Value* value) const;
};

}  // namespace calor
