#include "mesh/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

namespace calor {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string upper(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return out;
}

std::vector<std::string_view> split_at_commas(std::string_view line) {
  std::vector<std::string_view> cells;
  while (!line.empty()) {
    const std::size_t comma = std::min(line.find(','), line.size());
    cells.push_back(trimmed(line.substr(0, comma)));
    line.remove_prefix(std::min(comma + 1, line.size()));
  }
  if (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

TextFile::TextFile(const std::string& path, const SourceLocation& named) : path_(path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  // A folder opens too; its size is no size.
  const std::int64_t size = in ? static_cast<std::int64_t>(in.tellg()) : -1;
  if (size < 0 || size == std::numeric_limits<std::int64_t>::max())
    throw Error(Fault::file, named, fmt::format("the file \"{}\" cannot be read", path),
                "check the name and the permissions");
  text_.resize(size);
  in.seekg(0);
  in.read(text_.data(), size);
  if (trimmed(text_).empty())
    throw Error(Fault::bad_case, SourceLocation{.file = path_, .line = 1}, "the file is empty", "give it a mesh");
}

std::string_view TextFile::line() {
  begin_ = next_;
  const std::size_t end = std::min(text_.find('\n', begin_), text_.size());
  next_ = std::min(end + 1, text_.size());
  return trimmed(std::string_view(text_).substr(begin_, end - begin_));
}

std::string_view TextFile::word() {
  begin_ = next_;
  while (begin_ < text_.size() && is_blank(text_[begin_])) ++begin_;
  next_ = begin_;
  while (next_ < text_.size() && !is_blank(text_[next_])) ++next_;
  if (begin_ == next_) refuse("the file ends too early", "write it again: it is not complete");
  return std::string_view(text_).substr(begin_, next_ - begin_);
}

std::int64_t TextFile::count() {
  const std::int64_t n = integer();
  if (n < 0 || static_cast<std::size_t>(n) > text_.size() - next_)
    refuse(fmt::format("a count of {}, which the file does not hold", n), "write it again: it is not complete");
  return n;
}

double TextFile::to_number(std::string_view word) const {
  const std::string_view s = word.starts_with('+') ? word.substr(1) : word;
  double value = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (error != std::errc() || end != s.data() + s.size())
    refuse_at(word, fmt::format("'{}' is not a number", word), "write a number here");
  if (!std::isfinite(value)) refuse_at(word, fmt::format("'{}' is not finite", word), "write a finite number here");
  return value;
}

std::int64_t TextFile::to_integer(std::string_view word) const {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size())
    refuse_at(word, fmt::format("'{}' is not a whole number", word), "write a whole number here");
  return value;
}

void TextFile::refuse(const std::string& what, const std::string& cure) const {
  refuse_at(std::string_view(text_).substr(std::min(begin_, text_.size())), what, cure);
}

void TextFile::refuse_at(std::string_view piece, const std::string& what, const std::string& cure) const {
  const std::string_view before(text_.data(), static_cast<std::size_t>(piece.data() - text_.data()));
  const std::size_t start = before.rfind('\n') == before.npos ? 0 : before.rfind('\n') + 1;
  throw Error(Fault::bad_case,
              SourceLocation{.file = path_,
                             .line = static_cast<int>(std::ranges::count(before, '\n')) + 1,
                             .column = static_cast<int>(before.size() - start) + 1},
              what, cure);
}

}  // namespace calor
