#pragma once
// run.log in the result folder: what the run said, on the terminal or not.
#include <mpi.h>

#include <memory>
#include <string>

namespace calor {

/// While it lives, everything that rank 0 logs (spdlog) also goes to FOLDER/run.log: debug messages only there, the
/// others to the terminal too. What is logged before `open` is kept until then, so that a case that is refused leaves
/// no trace in an old result.
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
