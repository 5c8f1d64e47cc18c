#pragma once
// The way of the data: case -> cloud -> discretisation -> heat system -> integrator -> outputs.
#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

#include "app/model.hpp"
#include "case/case.hpp"
#include "output/observer.hpp"
#include "output/report.hpp"

namespace calor {

struct RunOptions {
  std::string folder;                     ///< results; empty: nothing is written
  bool quiet = false;                     ///< no progress line
  bool restart = false;                   ///< go on from the newest checkpoint in the folder
  std::optional<double> time_limit = {};  ///< by the clock, s: then the run is stored and ends
  std::vector<std::string> command = {};  ///< words of the command line without -j, for the report
};

/// Runs a case. It ends early, stored, when a signal is noted (app/interrupts.hpp). Collective; throws Error.
RunResult run(const Case& c, MPI_Comm comm, const RunOptions& options);

/// All numbers that the report of a run will have.
std::vector<ReportNumber> report_numbers(const Model& model, const Observers& observers);

}  // namespace calor
