#include "base/csv.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/units.hpp"

namespace calor {
namespace {

std::string_view trim(std::string_view s) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

CsvColumn parse_column(std::string_view head) {
  const auto open = head.find('[');
  if (open == head.npos || head.back() != ']') return {std::string(head), ""};
  return {std::string(trim(head.substr(0, open))), std::string(trim(head.substr(open + 1, head.size() - open - 2)))};
}

}  // namespace

CsvReader::CsvReader(const std::string& path, const SourceLocation& named, int part, int parts)
    : path_(path), in_(path, std::ios::binary) {
  in_.seekg(0, std::ios::end);
  const std::int64_t size = in_ ? static_cast<std::int64_t>(in_.tellg()) : -1;
  // A folder opens too; its size is no size.
  if (size < 0 || size == std::numeric_limits<std::int64_t>::max())
    throw named.file.empty()
        ? Error(Fault::file, SourceLocation{.file = path_}, "cannot be read", "check the name and the permissions")
        : Error(Fault::file, named, fmt::format("the file \"{}\" cannot be read", path_),
                "check the name and the permissions");
  in_.seekg(0);
  constexpr std::string_view mark = "\xEF\xBB\xBF";  // of UTF-8
  std::string first(mark.size(), ' ');
  in_.read(first.data(), static_cast<std::streamsize>(first.size()));
  in_.clear();
  after_ = first == mark ? static_cast<std::int64_t>(mark.size()) : 0;
  in_.seekg(after_);
  end_ = size;
  if (!next_line())
    throw Error(Fault::bad_case, SourceLocation{.file = path_, .line = 1}, "the file is empty",
                "the first line names the columns: x [m],T [K]");
  const int header = line_number_;
  for (const char other : {';', '\t'})
    if (line_.find(',') == line_.npos && line_.find(other) != line_.npos) separator_ = other;
  split();
  for (const auto head : cells_) columns_.push_back(parse_column(head));
  scale_.assign(columns_.size(), 1);
  offset_.assign(columns_.size(), 0);
  const std::int64_t rows = after_;
  if (!next_line())
    throw Error(Fault::bad_case, SourceLocation{.file = path_, .line = 1}, "the file has a header but no rows",
                "add rows of numbers");

  const std::int64_t begin = rows + (size - rows) * part / parts;
  end_ = rows + (size - rows) * (part + 1) / parts;
  in_.clear();
  after_ = begin;
  knows_line_ = part == 0;
  if (part > 0) {  // the row that begin falls into belongs to the part before
    in_.seekg(begin - 1);
    std::string rest;
    std::getline(in_, rest);
    after_ += static_cast<std::int64_t>(rest.size());
  } else {
    in_.seekg(begin);
  }
  line_number_ = header;
  cells_.clear();
}

int CsvReader::find(const std::string& name) const {
  const auto found = std::ranges::find(columns_, name, &CsvColumn::name);
  return found == columns_.end() ? -1 : static_cast<int>(found - columns_.begin());
}

int CsvReader::require(const std::string& name, const std::string& si_unit, bool difference) {
  const int c = find(name);
  if (c < 0) {
    std::vector<std::string> names;
    for (const auto& column : columns_) names.push_back("'" + column.name + "'");
    throw Error(Fault::bad_case, SourceLocation{.file = path_, .line = 1}, fmt::format("there is no column '{}'", name),
                fmt::format("the columns are {}; the header of this one is '{}{}'", fmt::join(names, ", "), name,
                            si_unit.empty() ? "" : " [" + si_unit + "]"));
  }
  if (si_unit.empty() && columns_[c].unit.empty()) return c;
  try {
    if (columns_[c].unit.empty() || si_unit.empty())
      throw std::invalid_argument(si_unit.empty() ? "it takes no unit" : "it has no unit");
    const auto convert = difference ? difference_to_si : to_si;
    offset_[c] = convert(0, columns_[c].unit, si_unit);
    scale_[c] = difference ? convert(1, columns_[c].unit, si_unit) : difference_to_si(1, columns_[c].unit, si_unit);
  } catch (const std::invalid_argument& e) {
    throw Error(Fault::bad_case, SourceLocation{.file = path_, .line = 1},
                fmt::format("column '{}': {}", name, e.what()),
                si_unit.empty()
                    ? fmt::format("write '{}' in the header", name)
                    : fmt::format("write '{} [{}]' in the header, or another unit of that dimension", name, si_unit));
  }
  return c;
}

bool CsvReader::next() {
  if (!next_line()) return false;
  split();
  if (cells_.size() != columns_.size())
    throw Error(Fault::bad_case, location(),
                fmt::format("the row has {} cells, the header has {}", cells_.size(), columns_.size()),
                "write one cell a column, separated as in the header: by commas, semicolons or tabs");
  return true;
}

double CsvReader::number(int column) const {
  std::string_view s = cells_[column];
  if (s.starts_with('+')) s.remove_prefix(1);
  double value = 0;
  const auto [end, fault] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (s.empty() || fault != std::errc{} || end != s.data() + s.size())
    throw Error(Fault::bad_case, location(column),
                fmt::format("'{}' in column '{}' is not a number", cells_[column], columns_[column].name),
                cells_[column].find(',') != std::string_view::npos ? "write a decimal point: 1.5, not 1,5"
                                                                   : "write a number such as 1.5 or 2e-3");
  if (!std::isfinite(value))
    throw Error(Fault::bad_case, location(column),
                fmt::format("'{}' in column '{}' is not finite", cells_[column], columns_[column].name),
                "write a finite number, or leave the row out");
  return offset_[column] + scale_[column] * value;
}

std::int64_t CsvReader::integer(int column) const {
  const std::string_view s = cells_[column];
  std::int64_t value = 0;
  const auto [end, fault] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (s.empty() || fault != std::errc{} || end != s.data() + s.size())
    throw Error(Fault::bad_case, location(column),
                fmt::format("'{}' in column '{}' is not a whole number", s, columns_[column].name),
                "write a whole number");
  return value;
}

SourceLocation CsvReader::location() const {
  if (knows_line_) return {.file = path_, .line = line_number_};
  // Counted only when somebody asks: a part in the middle of a file does not know how many lines came before it.
  std::ifstream again(path_, std::ios::binary);
  std::string line;
  int count = 1;
  for (std::int64_t byte = 0; byte < at_ && std::getline(again, line);
       byte += static_cast<std::int64_t>(line.size()) + 1)
    ++count;
  return {.file = path_, .line = count};
}

SourceLocation CsvReader::location(int column) const {
  SourceLocation p = location();
  p.column = static_cast<int>(cells_[column].data() - line_.data()) + 1;
  return p;
}

bool CsvReader::next_line() {
  while (after_ < end_ && std::getline(in_, line_)) {
    at_ = after_;
    ++line_number_;
    after_ += static_cast<std::int64_t>(line_.size()) + 1;
    const auto s = trim(line_);
    if (!s.empty() && s.front() != '#') return true;
  }
  return false;
}

void CsvReader::split() {
  cells_.clear();
  std::string_view rest = line_;
  for (auto end = rest.find(separator_); end != rest.npos; end = rest.find(separator_)) {
    cells_.push_back(trim(rest.substr(0, end)));
    rest.remove_prefix(end + 1);
  }
  cells_.push_back(trim(rest));
}

}  // namespace calor
