#pragma once
// The way of the data: case -> cloud -> discretisation -> heat system -> integrator -> outputs.
#include <mpi.h>

#include <string>

#include "case/case.hpp"
#include "output/report.hpp"

namespace calor {

struct RunOptions {
  std::string folder;  ///< results; empty: nothing is written
  bool quiet = false;  ///< no progress line
};

/// Runs a case. Collective; throws Error.
RunResult run(const Case& c, MPI_Comm comm, const RunOptions& options);

/// Lets SIGINT and SIGTERM (and SIGUSR1, which mpiexec passes on) end a run after the current step, with everything
/// written so far readable.
void catch_interrupts();

}  // namespace calor
