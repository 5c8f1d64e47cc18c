#pragma once
// Texts, numbers and members of JSON.
#include <string>
#include <utility>
#include <vector>

namespace calor {

/// In quotes, escaped; UTF-8 passes as it is, and bytes that are none become the sign for that.
std::string json_string(const std::string& text);
/// Is it UTF-8 without control characters, which any file may hold?
bool is_plain_text(const std::string& text);
/// Shortest text that reads back to the same bits; null for NaN and infinities, which JSON does not have.
std::string json_number(double value);

/// The members of an object and of those in it, by their paths: {"cloud.radius", "0.02"}, {"expect[1].probe", "\"a\""}.
/// Lists of anything but objects are one value. For text as the functions above and Case::json write it.
std::vector<std::pair<std::string, std::string>> json_members(const std::string& object);

}  // namespace calor
