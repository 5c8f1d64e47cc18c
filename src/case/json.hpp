#pragma once
// The two things that JSON is particular about.
#include <string>

namespace calor {

/// In quotes, escaped; bytes above 127 pass as they are (UTF-8).
std::string json_string(const std::string& text);
/// Shortest text that reads back to the same bits; null for NaN and infinities, which JSON does not have.
std::string json_number(double value);

}  // namespace calor
