#pragma once
// Entries of lists in paths of keys: body.layer[1].contact is body, layer, [1], contact (see split_path).
#include <cstddef>
#include <optional>
#include <string>

#include "case/tree.hpp"

namespace calor {

/// The index n of a key [n], which counts from 0; none for other keys.
std::optional<std::size_t> entry_of(const std::string& key);

/// What stands at a key of a table, or at an entry [n] of a list; null where there is nothing.
Value* find_at(Value& value, const std::string& key);

}  // namespace calor
