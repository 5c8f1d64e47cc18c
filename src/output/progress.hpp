#pragma once
// The line on a terminal that says how far a run has come.
#include <mpi.h>

#include <chrono>
#include <cstdio>

namespace calor {

/// Rewrites one line on stderr; silent in a pipe, on all ranks but 0, and where `quiet`.
class Progress {
 public:
  Progress(MPI_Comm comm, double end, bool quiet);
  ~Progress() { done(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(double t, long steps);
  void done();  ///< Clears the line.

 private:
  using Clock = std::chrono::steady_clock;
  double end_;
  bool speaks_;
  Clock::time_point start_, shown_;
};

}  // namespace calor
