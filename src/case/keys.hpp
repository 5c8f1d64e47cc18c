#pragma once
// What the schema says about one table of a case.
#include <string>
#include <vector>

#include "case/schema.hpp"
#include "case/tree.hpp"

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
void check_case_tree(const Schema& schema, const Value& root, const struct Context& context);

}  // namespace calor
