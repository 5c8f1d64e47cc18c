#pragma once
// report.json: what was run, with what, how long it took, and what came out.
#include <mpi.h>

#include <chrono>
#include <ctime>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "case/case.hpp"

namespace calor {

struct Timing {
  double wall = 0, cpu = 0;  ///< s; cpu: of this process
};

/// Stopwatches by name, in the order of their first use.
class Phases {
 public:
  /// Runs `work` and adds its time to the phase, also when it throws. Phases may nest; each counts all of its time.
  template <class Work>
  void measure(const std::string& name, const Work& work) {
    struct Watch {
      Phases& phases;
      const std::string& name;
      Timing start = now();
      ~Watch() { phases.add(name, now(), start); }
    } watch{*this, name};
    work();
  }
  const std::vector<std::pair<std::string, Timing>>& timings() const { return timings_; }

 private:
  static Timing now() {
    const auto since = std::chrono::steady_clock::now().time_since_epoch();
    return {.wall = std::chrono::duration<double>(since).count(),
            .cpu = static_cast<double>(std::clock()) / CLOCKS_PER_SEC};
  }
  void add(const std::string& name, Timing end, Timing start) {
    Timing* timing = nullptr;
    for (auto& [known, value] : timings_)
      if (known == name) timing = &value;
    if (!timing) timing = &timings_.emplace_back(name, Timing{}).second;
    timing->wall += end.wall - start.wall;
    timing->cpu += end.cpu - start.cpu;
  }

  std::vector<std::pair<std::string, Timing>> timings_;
};

/// What became of an [[expect]].
struct Verdict {
  std::string what;  ///< "line y = 2 m at 0.5 s, reference fig3.csv"
  std::string norm;  ///< "max", "rms" or "value"
  std::string unit;
  double error = 0, tolerance = 0;
  bool passed = false;
  double value = 0, reference = 0;  ///< for probes and report entries
};

struct RunResult {
  std::vector<Verdict> verdicts;
  std::map<std::string, double> numbers;     ///< what report.json says
  std::map<std::string, std::string> texts;  ///< method, integrator
  int interrupted_by = 0;                    ///< signal number, 0 = ran to the end
  bool passed() const;
};

/// Puts the report of an earlier run aside, as report.earlier.json: it must not stand for this one, and is kept until
/// this one has a report of its own. Collective.
void set_report_aside(MPI_Comm comm, const std::string& folder);

/// Writes report.json: the case with all defaults, versions, the result and seconds per phase (wall: the slowest rank;
/// cpu: all ranks together). An empty folder writes nothing. Throws Error(file). Collective.
void write_report(MPI_Comm comm, const std::string& folder, const Case& c, const RunResult& result,
                  const Phases& phases);

/// The verdict for a terminal: "ok    line y = 2 m at 0.5 s: max 1.2e-05 K of 0.00015 K".
std::string line(const Verdict& verdict);

}  // namespace calor
