#pragma once
// What a Table holds on to.
#include <memory>
#include <string>

#include "case/case.hpp"
#include "case/keys.hpp"
#include "case/values.hpp"

namespace calor {

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
