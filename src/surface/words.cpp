#include "surface/words.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

namespace calor {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

constexpr const char* whole = "the file may be cut off or damaged: write it anew";

/// A word for a message: of binary garbage only what can be shown.
std::string shown(std::string_view word) {
  std::string out;
  for (const char c : word.substr(0, 40)) out += static_cast<unsigned char>(c) < ' ' || c == 127 ? '?' : c;
  return out;
}

}  // namespace

std::string_view Words::next() {
  for (;;) {
    if (const std::string_view word = next_on_line(); !word.empty()) return word;
    if (!next_line()) return {};
  }
}

std::string_view Words::next_on_line() {
  for (;;) {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    const std::string_view rest = text_.substr(at_);
    const std::size_t ending = rest.starts_with("\\\n") ? 2 : rest.starts_with("\\\r\n") ? 3 : 0;
    if (ending == 0) break;
    at_ += ending;
    ++line_;
  }
  const std::size_t begin = at_;
  while (at_ < text_.size() && text_[at_] != '\n' && !is_blank(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

std::string_view Words::rest_of_line() {
  std::string_view rest = text_.substr(at_, text_.find('\n', at_) - at_);
  at_ += rest.size();
  while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
  while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
  return rest;
}

bool Words::next_line() {
  const std::size_t end = text_.find('\n', at_);
  if (end == std::string_view::npos) {
    at_ = text_.size();
    return false;
  }
  at_ = end + 1;
  ++line_;
  return true;
}

double Words::number(std::string_view word) const {
  const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
  double value = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  // Out of range is what is too large, and what is too small: that is 0.
  if (fault == std::errc::result_out_of_range) return std::strtod(std::string(digits).c_str(), nullptr);
  if (fault != std::errc{} || end != digits.data() + digits.size()) refuse_word(word, "a number");
  return value;
}

double Words::coordinate(std::string_view word) const {
  const double value = number(word);
  if (!std::isfinite(value)) refuse(fmt::format("a coordinate is '{}'", shown(word)), "coordinates are finite numbers");
  return value;
}

std::int64_t Words::integer(std::string_view word) const {
  std::int64_t value = 0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || fault != std::errc{} || end != word.data() + word.size()) refuse_word(word, "a whole number");
  return value;
}

void Words::refuse(const std::string& what, const std::string& cure) const {
  throw Error(Fault::bad_case, location(), what, cure);
}

void Words::refuse_word(std::string_view word, const std::string& wanted) const {
  if (word.empty()) refuse(fmt::format("there is nothing where {} should come", wanted), whole);
  refuse(fmt::format("'{}' where {} should come", shown(word), wanted), whole);
}

std::string read_whole_file(const std::string& path, const SourceLocation& named) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = in ? static_cast<std::streamoff>(in.tellg()) : -1;
  std::string text;
  // A folder opens too; its size is no size.
  if (size >= 0 && size < std::numeric_limits<std::streamoff>::max()) {
    text.resize(static_cast<std::size_t>(size));
    in.seekg(0);
    in.read(text.data(), size);
  }
  if (!in || size < 0 || size == std::numeric_limits<std::streamoff>::max())
    throw Error(Fault::file, named, fmt::format("the file \"{}\" cannot be read", path),
                "check the name and the permissions");
  return text;
}

}  // namespace calor
