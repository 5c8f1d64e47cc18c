#pragma once
// What JSON is particular about, and a look into JSON that this program wrote.
#include <string>
#include <utility>
#include <vector>

namespace calor {

/// In quotes, escaped; bytes above 127 pass as they are (UTF-8).
std::string json_string(const std::string& text);
/// Shortest text that reads back to the same bits; null for NaN and infinities, which JSON does not have.
std::string json_number(double value);

/// The members of an object and of those in it, by their paths: {"cloud.radius", "0.02"}, {"expect[1].probe", "\"a\""}.
/// Lists of anything but objects are one value. For text as the functions above and Case::json write it.
std::vector<std::pair<std::string, std::string>> json_members(const std::string& object);

}  // namespace calor
