#pragma once
// The files that a run writes.
#include <mpi.h>

#include <cstdint>
#include <cstdio>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace calor {

class Archive;

/// Throws the Error(file) for a path that cannot be written, with the reason the system gives in `error` (errno).
[[noreturn]] void refuse_writing(const std::string& path, int error);

/// Makes a folder and those above it. Throws Error(file) on all ranks when it cannot be written. Collective.
void make_folder(MPI_Comm comm, const std::string& folder);

/// Writes a file that appears, or replaces the old one, only when it is complete. Throws Error(file). Not collective.
void replace_file(const std::string& path, const std::string& text);

/// Removes files of a folder, where there are any. Names are relative to it; their last part may be a pattern of the
/// shell. Throws Error(file). Collective.
void remove_files(MPI_Comm comm, const std::string& folder, const std::vector<std::string>& names);

/// A field of a CSV file: in quotes where it holds a comma, a quote or the end of a line (RFC 4180).
std::string csv_field(const std::string& text);

/// Writes one file from rows of all ranks, rank after rank; `rows` writes those of its rank.
/// Throws Error(file) on all ranks. Collective.
void write_in_turns(MPI_Comm comm, const std::string& path, const std::string& header,
                    const std::function<void(std::FILE*)>& rows);

/// Lines of numbers with all digits, separated by commas, for `rows` of write_in_turns. What the line before has in the
/// same column, as places of lattices mostly do, is not converted again.
class NumberLines {
 public:
  explicit NumberLines(std::FILE* file) : file_(file) {}
  /// As many numbers every time. Throws where the file takes no more.
  void add(std::initializer_list<double> numbers);
  /// After the last line. Throws as add.
  void finish();

 private:
  struct Column {
    double number;
    std::string text;
  };

  std::FILE* file_;
  std::vector<Column> columns_;
  std::string text_;  ///< not yet in the file
};

/// A CSV file with a row a time, written by rank 0. It stays readable when the run is interrupted. All functions are
/// collective and throw Error(file) on all ranks.
class CsvLog {
 public:
  CsvLog() = default;  ///< writes nothing
  CsvLog(MPI_Comm comm, std::string path, std::string header)
      : comm_(comm), path_(std::move(path)), header_(std::move(header)) {}

  /// Creates the file (and its folder) with a header line; or goes on after the rows that `exchange` has read of, and
  /// cuts off those that came later.
  void open();
  /// Adds a row with all digits; it is in the file when this returns.
  void row(std::span<const double> values);
  /// Stores how much of the file there is, which is on the disk when this returns.
  void exchange(Archive& archive);

 private:
  /// Throws Error(file).
  void write(const std::string& line);

  MPI_Comm comm_ = MPI_COMM_SELF;
  std::string path_, header_;  // empty: nothing is written
  std::shared_ptr<std::FILE> file_;
  std::int64_t length_ = 0;  // bytes; of the rank that writes
};

/// Keeps other runs out of a result folder while it lives. The system lets go of it however the process ends.
class FolderLock {
 public:
  /// An empty folder needs no lock.
  FolderLock(MPI_Comm comm, const std::string& folder)
      : comm_(comm), path_(folder.empty() ? "" : folder + "/run.lock") {}
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Makes the folder. Throws Error(file) where another run holds it. Collective.
  void take();
  /// Throws Error(file) where the folder has been removed or replaced. Collective.
  void require_folder() const;

 private:
  MPI_Comm comm_;
  std::string path_;
  int descriptor_ = -1;  // of rank 0
};

/// run.log: while it lives, everything that rank 0 logs (spdlog) also goes to FOLDER/run.log: debug messages only
/// there, the others to the terminal too. What is logged before `open` is kept until then, so that a case that is
/// refused leaves no trace in an old result.
class RunLog {
 public:
  explicit RunLog(MPI_Comm comm);
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  /// Starts the file, or adds to it where a run `goes_on`; an empty folder writes nothing. Throws Error(file).
  /// Collective.
  void open(const std::string& folder, bool goes_on);

 private:
  MPI_Comm comm_;
  struct Sinks;
  std::unique_ptr<Sinks> sinks_;
};

}  // namespace calor
