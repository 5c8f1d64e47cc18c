#include "base/archive.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <optional>
#include <tuple>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/parallel.hpp"

namespace calor {
namespace {

constexpr std::string_view magic = "calor archive 1\n";
constexpr std::string_view head_format = "checksum {:016x}, text {:>12} bytes, arrays {:>4} of {:>14} points\n";
constexpr std::size_t head_length = magic.size() + 89;

/// The first point of every rank's slice, and the number of all points.
std::vector<std::int64_t> slices(int ranks, std::int64_t count) {
  std::vector<std::int64_t> begin(ranks + 1);
  for (int r = 0; r <= ranks; ++r) begin[r] = count / ranks * r + std::min<std::int64_t>(r, count % ranks);
  return begin;
}

/// What a word adds to the checksum, by its place: sums do not depend on who adds what (the finaliser of splitmix64).
std::uint64_t mixed(std::uint64_t place, std::uint64_t bits) {
  std::uint64_t z = bits ^ ((place + 1) * 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

std::uint64_t checksum(std::string_view text) {
  std::uint64_t sum = 0;
  for (std::size_t n = 0; n < text.size(); ++n)
    sum += mixed((std::uint64_t{1} << 62) + n, static_cast<unsigned char>(text[n]));
  return sum;
}

std::uint64_t checksum(std::int64_t first, std::span<const double> values) {
  std::uint64_t sum = 0;
  for (std::size_t n = 0; n < values.size(); ++n) sum += mixed(first + n, std::bit_cast<std::uint64_t>(values[n]));
  return sum;
}

/// The sum of all ranks, modulo 2^64. Collective.
std::uint64_t add_up(MPI_Comm comm, std::uint64_t mine) {
  std::array<std::int64_t, 2> halves{static_cast<std::int64_t>(mine >> 32),
                                     static_cast<std::int64_t>(mine & 0xffffffffu)};
  calor::add_up(comm, halves);
  return (static_cast<std::uint64_t>(halves[0]) << 32) + static_cast<std::uint64_t>(halves[1]);
}

std::string numbers_text(std::span<const double> values) {
  std::string text;
  for (const double value : values) text += fmt::format("{}{}", text.empty() ? "" : " ", value);
  return text;
}

/// The number at the start of a text, after blanks; nothing where there is none. Takes it off the text.
template <class Number, class... Base>
std::optional<Number> take_number(std::string_view& text, Base... base) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base...);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(end - text.data());
  return number;
}

}  // namespace

NumberedPoints::NumberedPoints(MPI_Comm comm, std::span<const std::int64_t> id)
    : comm_(comm), count_(total(comm, static_cast<std::int64_t>(id.size()))) {
  const int ranks = size_of(comm), rank = rank_of(comm);
  const std::vector<std::int64_t> begin = slices(ranks, count_);
  begin_ = begin[rank];
  order_.resize(id.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::sort(order_, {}, [&](int i) { return id[i]; });
  struct Sent {
    std::int64_t id;
    int from;
  };
  std::vector<Sent> packed;
  count_to_.assign(ranks, 0), count_from_.assign(ranks, 0);
  for (const int i : order_) {
    packed.push_back({id[i], rank});
    ++count_to_[std::ranges::upper_bound(begin, id[i]) - begin.begin() - 1];
  }
  for (const Sent& sent : exchange(comm, packed, count_to_)) {
    place_in_slice_.push_back(sent.id - begin_);
    ++count_from_[sent.from];
  }
}

std::vector<double> NumberedPoints::to_slice(std::span<const double> owned) const {
  std::vector<double> packed, slice(place_in_slice_.size());
  for (const int i : order_) packed.push_back(owned[i]);
  const std::vector<double> arrived = exchange(comm_, packed, count_to_);
  for (std::size_t n = 0; n < arrived.size(); ++n) slice[place_in_slice_[n]] = arrived[n];
  return slice;
}

void NumberedPoints::from_slice(std::span<const double> slice, std::span<double> owned) const {
  std::vector<double> packed;
  for (const std::int64_t place : place_in_slice_) packed.push_back(slice[place]);
  const std::vector<double> arrived = exchange(comm_, packed, count_from_);
  for (std::size_t n = 0; n < arrived.size(); ++n) owned[order_[n]] = arrived[n];
}

// ---- writing --------------------------------------------------------------------------------------------------------

void ArchiveWriter::values(const std::string& name, std::span<double> values) { add(name, numbers_text(values)); }

void ArchiveWriter::text(const std::string& name, std::string& text) {
  std::string lines;  // further ones are indented
  for (const char c : text) lines += c == '\n' ? "\n  " : std::string(1, c);
  add(name, lines);
}

void ArchiveWriter::points(const std::string& name, std::span<double> owned) {
  add(name, fmt::format("array {}", arrays_.size()));
  arrays_.push_back(owned);
}

void ArchiveWriter::shares(const std::string& name, std::span<double> mine) {
  add(name, numbers_text(gather(points_.comm(), std::vector<double>(mine.begin(), mine.end()))));
}

void ArchiveWriter::save(const std::string& path) const {
  MPI_Comm comm = points_.comm();
  const bool is_first = rank_of(comm) == 0;
  const std::string draft = path + ".part";
  std::optional<File> file;
  try {
    collective_try(comm, [&] {
      if (is_first) file.emplace(draft, O_WRONLY | O_CREAT | O_TRUNC);
    });
    collective_try(comm, [&] {
      if (!is_first) file.emplace(draft, O_WRONLY);
    });
    const auto first = static_cast<std::int64_t>(head_length + text_.size());
    std::uint64_t sum = is_first ? checksum(text_) : 0;
    std::int64_t place = points_.slice_begin();
    for (const auto& array : arrays_) {
      const std::vector<double> slice = points_.to_slice(array);
      sum += checksum(place, slice);
      collective_try(comm, [&] { file->write(slice.data(), slice.size() * sizeof(double), first + 8 * place); });
      place += points_.count();
    }
    sum = add_up(comm, sum);
    collective_try(comm, [&] {
      if (is_first) {
        const std::string head =
            std::string(magic) + fmt::format(head_format, sum, text_.size(), arrays_.size(), points_.count());
        file->write((head + text_).data(), head.size() + text_.size(), 0);
      }
      file->finish();
    });
    collective_try(comm, [&] {
      if (!is_first) return;
      if (std::rename(draft.c_str(), path.c_str()) != 0) refuse_file(path, errno);
      File(std::filesystem::path(path).parent_path(), O_RDONLY | O_DIRECTORY).sync();
    });
  } catch (const Error&) {
    if (is_first) std::remove(draft.c_str());
    throw;
  }
}

// ---- reading --------------------------------------------------------------------------------------------------------

ArchiveReader::ArchiveReader(MPI_Comm comm, std::string path) : comm_(comm), path_(std::move(path)) {
  std::vector<char> head(head_length), text;
  std::uint64_t sum_then = 0, bytes = 0, arrays = 0, points = 0;
  collective_try(comm, [&] {
    const File file(path_, O_RDONLY);
    if (file.read(head.data(), head.size(), 0) < head.size()) refuse("is too short");
    if (!std::string_view(head.data(), head.size()).starts_with(magic)) refuse("is not of this kind");
    std::string_view line(head.data() + magic.size(), head.size() - magic.size());
    for (const auto& [word, base, number] :
         {std::tuple{"checksum", 16, &sum_then}, {"text", 10, &bytes}, {"arrays", 10, &arrays}, {"of", 10, &points}}) {
      line.remove_prefix(std::min(line.size(), line.find(word)));
      line.remove_prefix(std::min(line.size(), std::strlen(word)));
      const auto found = take_number<std::uint64_t>(line, base);
      if (!found) refuse("has a damaged head");
      *number = *found;
    }
    const std::string whole = std::string(magic) + fmt::format(head_format, sum_then, bytes, arrays, points);
    if (whole != std::string_view(head.data(), head.size())) refuse("has a damaged head");
    const auto size = static_cast<std::uint64_t>(file.size());
    constexpr std::uint64_t most = 1u << 31;  // so that no product is too large
    if (bytes > size || arrays > most || points > most * 8 || head_length + bytes + 8 * arrays * points != size)
      refuse("has not the length that it had");
    if (rank_of(comm) != 0) return;
    text.resize(bytes);
    file.read(text.data(), text.size(), head_length);
  });
  const std::vector<char> all = gather(comm, text);
  text_.assign(all.begin(), all.end());
  first_ = static_cast<std::int64_t>(head_length + text_.size());
  arrays_ = static_cast<std::int64_t>(arrays), count_ = static_cast<std::int64_t>(points);

  const std::vector<std::int64_t> begin = slices(size_of(comm), count_);
  const int rank = rank_of(comm);
  std::uint64_t sum = rank == 0 ? checksum(text_) : 0;
  collective_try(comm, [&] {
    for (std::int64_t n = 0; n < arrays_; ++n)
      sum += checksum(n * count_ + begin[rank], read_slice(n, begin[rank], begin[rank + 1]));
  });
  sum = add_up(comm, sum);
  collective_try(comm, [&] {
    if (sum != sum_then) refuse("does not match its checksum");
  });
}

void ArchiveReader::refuse(const std::string& what) const {
  throw Error(Fault::file, SourceLocation{.file = path_}, "the file " + what, "take another one");
}

std::vector<double> ArchiveReader::read_slice(std::int64_t array, std::int64_t begin, std::int64_t end) const {
  std::vector<double> slice(end - begin);
  const std::size_t bytes = slice.size() * sizeof(double);
  const File file(path_, O_RDONLY);
  if (file.read(slice.data(), bytes, first_ + 8 * (array * count_ + begin)) < bytes) refuse("is too short");
  return slice;
}

std::string_view ArchiveReader::next(const std::string& name) {
  const std::string_view left = std::string_view(text_).substr(at_);
  const std::string start = name + " = ";
  if (!left.starts_with(start)) refuse(fmt::format("holds other things than this run: '{}' does not come next", name));
  std::size_t end = left.find('\n');
  while (end + 1 < left.size() && left[end + 1] == ' ') end = left.find('\n', end + 1);
  at_ += end + 1;
  return left.substr(start.size(), end - start.size());
}

void ArchiveReader::values(const std::string& name, std::span<double> values) {
  std::string_view text = next(name);
  for (double& value : values) {
    const auto number = take_number<double>(text);
    if (!number) refuse(fmt::format("holds too few numbers of '{}'", name));
    value = *number;
  }
  if (!text.empty()) refuse(fmt::format("holds too many numbers of '{}'", name));
}

void ArchiveReader::text(const std::string& name, std::string& text) {
  text.clear();
  const std::string_view lines = next(name);
  for (std::size_t n = 0; n < lines.size(); ++n) {
    text += lines[n];
    if (lines[n] == '\n') n += 2;
  }
}

void ArchiveReader::points(const std::string& name, std::span<double> owned) {
  next(name);
  std::vector<double> slice;
  collective_try(comm_, [&] {
    if (points_->count() != count_) refuse(fmt::format("holds {} points, the cloud has {}", count_, points_->count()));
    const std::int64_t begin = points_->slice_begin();
    const std::vector<std::int64_t> begins = slices(size_of(comm_), count_);
    slice = read_slice(next_array_, begin, begins[rank_of(comm_) + 1]);
  });
  ++next_array_;
  points_->from_slice(slice, owned);
}

void ArchiveReader::shares(const std::string& name, std::span<double> mine) {
  const std::size_t width = mine.size();
  std::string_view text = next(name);
  std::vector<double> all;
  while (const auto number = take_number<double>(text)) all.push_back(*number);
  if (width > 0 && (all.empty() || all.size() % width != 0)) refuse(fmt::format("holds other numbers of '{}'", name));
  std::ranges::fill(mine, 0);
  if (width == 0) return;
  const int ranks = size_of(comm_), rank = rank_of(comm_);
  for (std::size_t n = 0; n < all.size(); ++n)
    if (all.size() == width * ranks ? n / width == static_cast<std::size_t>(rank) : rank == 0)
      mine[n % width] += all[n];
}

}  // namespace calor
