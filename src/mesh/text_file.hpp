#pragma once
// A text file in memory, word by word or line by line, that knows where it is when something is wrong.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace calor {

std::string_view trimmed(std::string_view text);
/// Upper case, ASCII.
std::string upper(std::string_view text);
/// Cells between commas, without surrounding blanks; an empty one after the last comma is none.
std::vector<std::string_view> split_at_commas(std::string_view line);

class TextFile {
 public:
  /// Throws Error(file) when the file cannot be read, at `named`, where the case names it, if that is known.
  TextFile(const std::string& path, const SourceLocation& named);

  const std::string& path() const { return path_; }
  std::string_view text() const { return text_; }

  bool at_end() const { return next_ == text_.size(); }
  /// The rest of this line, without surrounding blanks.
  std::string_view line();
  /// The next word, between blanks or line ends. Throws Error(bad_case) at the end of the file.
  std::string_view word();
  std::int64_t integer() { return to_integer(word()); }
  double number() { return to_number(word()); }
  /// A count of records that fills memory; refuses negative ones and those that the rest of the file cannot hold.
  std::int64_t count();
  /// Goes to a place in the text.
  void go_to(std::size_t place) { next_ = begin_ = place; }
  std::size_t place() const { return next_; }

  /// A word or cell of the text as a number. Throws Error(bad_case) there unless it is one and finite.
  double to_number(std::string_view word) const;
  std::int64_t to_integer(std::string_view word) const;

  /// Throws Error(bad_case) at the last word or line, or at a piece of the text.
  [[noreturn]] void refuse(const std::string& what, const std::string& cure) const;
  [[noreturn]] void refuse_at(std::string_view piece, const std::string& what, const std::string& cure) const;

 private:
  std::string path_, text_;
  std::size_t begin_ = 0, next_ = 0;  // of the last word or line; of the next one
};

}  // namespace calor
