// Variants and KEY=VALUE: what a change of a case replaces besides the keys that it writes.
#include <algorithm>

#include "case/case.hpp"
#include "case/keys.hpp"
#include "case/tree.hpp"

namespace calor {
namespace {

/// Drops from `now` what `changes` replace. `before`: the table without them; null where there was none.
void drop_replaced(const Schema& schema, const std::string& schema_path, const Value* before, const Value& changes,
                   Value& now) {
  const TableKeys had = keys_of(schema, schema_path, before), has = keys_of(schema, schema_path, &now);
  const auto is_replaced = [&](const Entry& entry) {
    if (changes.find(entry.key)) return false;
    const bool lost_its_choice = !had.goes_elsewhere(entry.key) && has.goes_elsewhere(entry.key);
    return lost_its_choice || std::ranges::any_of(changes.entries, [&](const Entry& written) {
             const Key* key = has.find(written.key);
             return key && std::ranges::count(key->instead_of, entry.key) > 0;
           });
  };
  std::erase_if(now.entries, is_replaced);
  for (const Entry& written : changes.entries) {
    Value* table = now.find(written.key);
    const bool is_section = std::ranges::count(has.tables, written.key) > 0;
    if (!table || !table->is_table() || !written.value.is_table() || !(is_section || has.is_named_table(written.key)))
      continue;
    const Value* old = before ? before->find(written.key) : nullptr;
    drop_replaced(schema, join(schema_path, is_section ? written.key : "*"), old && old->is_table() ? old : nullptr,
                  written.value, *table);
  }
}

}  // namespace

void change_case(const Schema& schema, Value& root, const std::vector<std::string>& keys, const Value& value) {
  const Value before = root;
  set_path(root, keys, value);
  Value changes = Value::empty_table(value.location);
  set_path(changes, keys, value);
  if (root.is_table() && changes.is_table()) drop_replaced(schema, "", &before, changes, root);
}

}  // namespace calor
