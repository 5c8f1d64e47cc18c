#pragma once
// Lengths of a case that have to be positive.
#include <string>

#include "case/case.hpp"

namespace calor {

/// A length of the table, m; refuses one that is not positive.
double positive_length(const Table& table, const std::string& key);

}  // namespace calor
