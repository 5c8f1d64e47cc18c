#pragma once
// The entries of one kind that a case can ask for: methods, material laws, sources, ... Every kind has one registry;
// the schema, the manual and messages take their names from it.
#include <algorithm>
#include <deque>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"

namespace calor {

/// An Entry has a `name`, and a `sentence` that says what it is (lower case, no full stop). Calor's own entries come
/// first, in the order of the manual. A program that links the library adds its own before it reads a case.
template <class Entry>
class Registry {
 public:
  Registry(std::initializer_list<Entry> own) : entries_(own) {}

  /// Throws std::invalid_argument where the name is taken.
  void add(Entry entry) {
    if (find(entry.name)) throw std::invalid_argument("the name '" + entry.name + "' is taken");
    entries_.push_back(std::move(entry));
  }

  /// Null where there is none of that name. Entries stay where they are.
  const Entry* find(const std::string& name) const {
    const auto found = std::ranges::find(entries_, name, &Entry::name);
    return found == entries_.end() ? nullptr : &*found;
  }
  /// The entry that a key of Kind::choice names.
  const Entry& chosen(const Table& table, const std::string& key) const {
    const Entry* entry = find(table.text(key));
    if (!entry) table.refuse(key, "'" + table.text(key) + "' is not known", "see `calor doc " + key + "`");
    return *entry;
  }
  /// Those whose names are keys of the table.
  std::vector<const Entry*> given(const Table& table) const {
    std::vector<const Entry*> out;
    for (const Entry& entry : entries_)
      if (table.has(entry.name)) out.push_back(&entry);
    return out;
  }

  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const Entry& entry : entries_) out.push_back(entry.name);
    return out;
  }
  /// "a, b or c".
  std::string listed() const {
    const std::vector<std::string> all = names();
    std::string out;
    for (std::size_t n = 0; n < all.size(); ++n) out += (n == 0 ? "" : n + 1 < all.size() ? ", " : " or ") + all[n];
    return out;
  }
  /// " NAME: SENTENCE." of every entry, to follow the sentence of a key.
  std::string sentences() const {
    std::string out;
    for (const Entry& entry : entries_) out += " " + entry.name + ": " + entry.sentence + ".";
    return out;
  }
  /// The keys of all entries: those with a `declare`.
  void declare(Schema& schema) const {
    for (const Entry& entry : entries_)
      if (entry.declare) entry.declare(schema);
  }

  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }

 private:
  std::deque<Entry> entries_;
};

}  // namespace calor
