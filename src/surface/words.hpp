#pragma once
// Text files word by word: words are separated by blanks, and know their line.
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.hpp"

namespace calor {

class Words {
 public:
  /// `text`, the whole file, must outlive it.
  Words(std::string path, std::string_view text) : path_(std::move(path)), text_(text) {}

  /// Next word, "" at the end of the file.
  std::string_view next();
  /// Next word of this line, "" at its end. A backslash at the end of a line continues it.
  std::string_view next_on_line();
  /// What is left of this line, without blanks around it.
  std::string_view rest_of_line();
  /// Goes to the next line, false at the end of the file.
  bool next_line();

  /// A word as a number, as a finite one, as a whole one; throws Error(bad_case) at this line for what is none.
  double number(std::string_view word) const;
  double coordinate(std::string_view word) const;
  std::int64_t integer(std::string_view word) const;

  /// Bytes that have been read.
  std::size_t byte() const { return at_; }
  const std::string& path() const { return path_; }
  SourceLocation location() const { return {.file = path_, .line = line_, .column = 0}; }
  /// Throws Error(bad_case) at this line.
  [[noreturn]] void refuse(const std::string& what, const std::string& cure) const;
  /// The same for a word that comes instead of what is wanted.
  [[noreturn]] void refuse_word(std::string_view word, const std::string& wanted) const;

 private:
  std::string path_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// The whole file. Throws Error(file) at `named`, where the case names it, when it cannot be read.
std::string read_whole_file(const std::string& path, const SourceLocation& named);

}  // namespace calor
