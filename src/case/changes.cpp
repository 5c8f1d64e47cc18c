// Variants and KEY=VALUE: what a change of a case replaces besides the keys that it writes.
#include <algorithm>

#include "case/case.hpp"
#include "case/entries.hpp"
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
  Value before = root;
  set_path(root, keys, value);
  // What an entry of a list replaces, it replaces within itself.
  const auto last = std::find_if(keys.rbegin(), keys.rend(), [](const std::string& key) { return entry_of(key); });
  const auto below = static_cast<std::size_t>(keys.rend() - last);
  Value *was = &before, *now = &root;
  std::string schema_path;
  for (std::size_t n = 0; n < below; ++n) {
    if (now->is_table()) {
      const bool is_section = std::ranges::count(keys_of(schema, schema_path, now).tables, keys[n]) > 0;
      const bool is_list = n + 1 < below && entry_of(keys[n + 1]);
      schema_path = join(schema_path, is_list ? keys[n] + "[]" : is_section ? keys[n] : "*");
    }
    was = find_at(*was, keys[n]), now = find_at(*now, keys[n]);
  }
  if (!now->is_table()) return;
  Value changes = Value::empty_table(value.location);
  set_path(changes, {keys.begin() + static_cast<std::ptrdiff_t>(below), keys.end()}, value);
  if (changes.is_table()) drop_replaced(schema, schema_path, was, changes, *now);
}

}  // namespace calor
