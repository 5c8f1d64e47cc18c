#pragma once
// CSV files, row by row. The first line is the header, `t [s],x [m],T [K]`: name and unit of every column, no unit
// where the column has no dimension. Cells are separated by commas; by semicolons or tabs where the header has these
// and no comma. Empty lines and lines that start with # are skipped.
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace calor {

struct CsvColumn {
  std::string name, unit;
};

class CsvReader {
 public:
  /// Reads part `part` of `parts` of the rows (split by bytes: every row belongs to exactly one part, in order).
  /// Throws Error(file) when the file cannot be read, at `named`, where the case names it, if that is known;
  /// Error(bad_case) when it has no header or no rows at all.
  explicit CsvReader(const std::string& path, const SourceLocation& named = {}, int part = 0, int parts = 1);

  const std::vector<CsvColumn>& columns() const { return columns_; }
  /// Index of a column, -1 where there is none.
  int find(const std::string& name) const;
  /// Index of a column that must be there; its numbers come in `si_unit` from now on. Throws Error for a missing
  /// column (naming those there are) and for a unit of another dimension. A `difference` takes no offset.
  int require(const std::string& name, const std::string& si_unit, bool difference = false);

  /// Goes to the next row, false after the last. Throws Error at file:line for a wrong number of cells.
  bool next();
  /// Cell of the current row without surrounding spaces; valid until the next call of next().
  std::string_view text(int column) const { return cells_[column]; }
  /// The same as a number; throws Error at file:line:column unless it is one and finite.
  double number(int column) const;
  std::int64_t integer(int column) const;

  const std::string& path() const { return path_; }
  /// Location of the current row, or of a cell in it.
  SourceLocation location() const;
  SourceLocation location(int column) const;

 private:
  bool next_line();
  void split();

  std::string path_, line_;
  char separator_ = ',';
  std::ifstream in_;
  std::vector<CsvColumn> columns_;
  std::vector<double> scale_, offset_;  // SI = offset + scale * number
  std::vector<std::string_view> cells_;
  int line_number_ = 0;                        // of the row
  bool knows_line_ = true;                     // only in the first part of a file
  std::int64_t at_ = 0, after_ = 0, end_ = 0;  // bytes: start of the row, of the next one, of the next part
};

}  // namespace calor
