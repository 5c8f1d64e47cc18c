#include "case/json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace calor {
namespace {

using Json = nlohmann::ordered_json;

void add_members(const Json& value, const std::string& path, std::vector<std::pair<std::string, std::string>>& all) {
  if (value.is_object()) {
    for (const auto& [key, member] : value.items())
      add_members(member, path.empty() ? key : fmt::format("{}.{}", path, key), all);
  } else if (value.is_array() && !value.empty() && value.front().is_object()) {
    for (std::size_t n = 0; n < value.size(); ++n) add_members(value[n], fmt::format("{}[{}]", path, n + 1), all);
  } else {
    all.emplace_back(path, value.dump(-1, ' ', false, Json::error_handler_t::replace));
  }
}

}  // namespace

std::string json_string(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool is_plain_text(const std::string& text) {
  if (std::ranges::any_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7f; })) return false;
  return json_string(text) == Json(text).dump(-1, ' ', false, Json::error_handler_t::ignore);
}

std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

std::vector<std::pair<std::string, std::string>> json_members(const std::string& object) {
  std::vector<std::pair<std::string, std::string>> all;
  add_members(Json::parse(object), "", all);
  return all;
}

}  // namespace calor
