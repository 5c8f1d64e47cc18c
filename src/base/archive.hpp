#pragma once
// What a run carries, in a file from which it goes on. Owners list their state once, in a function that serves for
// writing and for reading, so that the two cannot drift apart.
//
// The file is text, for people too, then arrays of doubles of all points in the order of their numbers, so that any
// number of ranks can read it. A checksum is over the whole. No rank holds an array of global size.
#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace calor {

/// The points of a cloud by their numbers, in slices of equal length, one a rank, and distributed as the cloud is.
class NumberedPoints {
 public:
  /// `id`: of the owned points; all ranks' are 0 ... count - 1. Collective.
  NumberedPoints(MPI_Comm comm, std::span<const std::int64_t> id);

  MPI_Comm comm() const { return comm_; }
  std::int64_t count() const { return count_; }
  std::int64_t slice_begin() const { return begin_; }  ///< number of the first point of this rank's slice
  /// Values of the owned points, arranged by number. Collective.
  std::vector<double> to_slice(std::span<const double> owned) const;
  /// The way back. Collective.
  void from_slice(std::span<const double> slice, std::span<double> owned) const;

 private:
  MPI_Comm comm_;
  std::int64_t count_, begin_ = 0;
  std::vector<int> order_;                    ///< owned points as they are packed for the slices
  std::vector<int> count_to_, count_from_;    ///< points sent to every rank's slice, and those that arrive here
  std::vector<std::int64_t> place_in_slice_;  ///< of those that arrive
};

/// Every entry has a name. All functions are collective.
class Archive {
 public:
  virtual ~Archive() = default;
  virtual bool reads() const = 0;

  /// The same on all ranks; whole numbers up to 2^53.
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void value(const std::string& name, Number& x) {
    auto number = static_cast<double>(x);
    values(name, std::span(&number, 1));
    x = static_cast<Number>(number);
  }
  virtual void values(const std::string& name, std::span<double> values) = 0;
  /// The same on all ranks; may have several lines.
  virtual void text(const std::string& name, std::string& text) = 0;
  /// One a owned point; to be kept as they are until the archive is saved.
  virtual void points(const std::string& name, std::span<double> owned) = 0;
  /// Parts of which the sum over the ranks counts. On another number of ranks all of it goes to the first.
  virtual void shares(const std::string& name, std::span<double> mine) = 0;
};

class ArchiveWriter final : public Archive {
 public:
  explicit ArchiveWriter(const NumberedPoints& points) : points_(points) {}

  bool reads() const override { return false; }
  void values(const std::string& name, std::span<double> values) override;
  void text(const std::string& name, std::string& text) override;
  void points(const std::string& name, std::span<double> owned) override;
  void shares(const std::string& name, std::span<double> mine) override;

  /// Writes the file, which appears or replaces an old one when it is complete and on the disk. Throws Error(file) on
  /// all ranks. Collective.
  void save(const std::string& path) const;

 private:
  void add(const std::string& name, const std::string& value) { text_ += name + " = " + value + "\n"; }

  const NumberedPoints& points_;
  std::string text_;
  std::vector<std::span<const double>> arrays_;
};

class ArchiveReader final : public Archive {
 public:
  /// Reads the whole file once to see whether it is as it was written. Throws Error(file) on all ranks. Collective.
  ArchiveReader(MPI_Comm comm, std::string path);

  /// Number of points of the arrays.
  std::int64_t count() const { return count_; }
  /// Before `points`; must outlive this.
  void distribute(const NumberedPoints& points) { points_ = &points; }

  bool reads() const override { return true; }
  void values(const std::string& name, std::span<double> values) override;
  void text(const std::string& name, std::string& text) override;
  void points(const std::string& name, std::span<double> owned) override;
  void shares(const std::string& name, std::span<double> mine) override;

 private:
  /// The value of the next entry, which must have that name.
  std::string_view next(const std::string& name);
  [[noreturn]] void refuse(const std::string& what) const;
  /// This rank's slice of an array. Throws Error(file) on this rank alone.
  std::vector<double> read_slice(std::int64_t array, std::int64_t begin, std::int64_t end) const;

  MPI_Comm comm_;
  std::string path_, text_;
  std::size_t at_ = 0;      ///< in text_
  std::int64_t first_ = 0;  ///< byte at which the arrays begin
  std::int64_t count_ = 0, arrays_ = 0, next_array_ = 0;
  const NumberedPoints* points_ = nullptr;
};

}  // namespace calor
