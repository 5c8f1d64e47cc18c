#pragma once
// report.json: what was run, with what, how long it took, and what came out.
#include <map>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "output/expect.hpp"
#include "output/phases.hpp"

namespace calor {

/// Removes the report of an earlier run, which must not stand for this one. Collective.
void forget_report(MPI_Comm comm, const std::string& folder);

/// Writes report.json: the case with all defaults, versions, `texts` (method, integrator, ...), `numbers`, seconds per
/// phase (wall: the slowest rank; cpu: all ranks together) and verdicts. An empty folder writes nothing.
/// Throws Error(file). Collective.
void write_report(MPI_Comm comm, const std::string& folder, const Case& c, const std::map<std::string, double>& numbers,
                  const std::map<std::string, std::string>& texts, const Phases& phases,
                  const std::vector<Verdict>& verdicts, bool passed);

/// The verdict for a terminal: "ok    line y = 2 m at 0.5 s: max 1.2e-05 K of 0.00015 K".
std::string line(const Verdict& verdict);

}  // namespace calor
