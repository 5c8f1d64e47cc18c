#pragma once
// The files that a run writes.
#include <mpi.h>

#include <cstdio>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace calor {

/// Throws the Error(file) for a path that cannot be written, with the reason the system gives in `error` (errno).
[[noreturn]] void refuse_writing(const std::string& path, int error);

/// Makes a folder and those above it. Throws Error(file) on all ranks when it cannot be written. Collective.
void make_folder(MPI_Comm comm, const std::string& folder);

/// Writes a file that appears, or replaces the old one, only when it is complete. Throws Error(file). Not collective.
void replace_file(const std::string& path, const std::string& text);

/// Writes one file from rows of all ranks, rank after rank; `rows` writes those of its rank.
/// Throws Error(file) on all ranks. Collective.
void write_in_turns(MPI_Comm comm, const std::string& path, const std::string& header,
                    const std::function<void(std::FILE*)>& rows);

/// A CSV file with a row a time. It stays readable when the run is interrupted.
class CsvLog {
 public:
  CsvLog() = default;  ///< writes nothing
  /// Creates `path` (and its folder) with a header line; only rank 0 writes. Throws Error(file) on all ranks.
  /// Collective.
  CsvLog(MPI_Comm comm, const std::string& path, const std::string& header);

  /// Adds a row with all digits; it is in the file when this returns. Throws Error(file) on all ranks. Collective.
  void row(std::span<const double> values);

 private:
  MPI_Comm comm_ = MPI_COMM_SELF;
  std::string path_;  // empty: nothing is written
  std::shared_ptr<std::FILE> file_;
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

  /// Starts the file; an empty folder writes nothing. Throws Error(file). Collective.
  void open(const std::string& folder);

 private:
  MPI_Comm comm_;
  struct Sinks;
  std::unique_ptr<Sinks> sinks_;
};

}  // namespace calor
