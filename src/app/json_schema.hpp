#pragma once
// The declarations of all keys as a JSON Schema, by which editors complete and check case files (taplo, VS Code).
#include <string>

#include "case/schema.hpp"

namespace calor {

/// A JSON Schema (draft 7) of case files: kinds, choices, units as examples, what is required, and which keys go with
/// which choice. What only numbers tell (a size that is not positive) is left to the reader of cases.
std::string json_schema(const Schema& schema);

}  // namespace calor
