#pragma once
// The manual of case files, made from the declarations of the keys.
#include <string>

#include "case/schema.hpp"

namespace calor {

/// Markdown: everything, or the sections and keys that match `key`: "cloud" is a section with what is below it,
/// "cloud.radius" a single key. Throws Error(command) for a key that does not exist, with the nearest one.
std::string manual(const Schema& schema, const std::string& key = "");

}  // namespace calor
