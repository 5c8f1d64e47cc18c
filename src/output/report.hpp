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
#include "output/temperature_unit.hpp"

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
  double elapsed() const { return now().wall - start_.wall; }  ///< s, since this was made

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

  Timing start_ = now();
  std::vector<std::pair<std::string, Timing>> timings_;
};

/// What became of an [[expect]].
struct Verdict {
  std::string what;  ///< "points with y == 2, fig3.csv at 0.5 s"
  std::string norm;  ///< over points "max" or "rms", of one number "value", of the report "at most" or "at least"
  std::string unit;  ///< of error and tolerance
  double error = 0, tolerance = 0;
  bool passed = false;
  double value = 0, reference = 0;       ///< SI; over points: where they differ most
  std::string value_unit = {};           ///< of these two
  double least = 0;                      ///< the error has to be as large as that: one that is known
  std::vector<double> worst_place = {};  ///< m, where they differ most; empty for one number
  std::string source = {};               ///< of the reference, as the case names it
};

/// A number of the report, as it is known before the run; `unit`: SI, "" of counts and ratios.
struct ReportNumber {
  std::string name, unit;
};

/// A temperature that a run came to, K, with its time, s, and place, m.
struct Extreme {
  double T = 0, t = 0;
  std::vector<double> x = {};
};

struct RunResult {
  std::vector<Verdict> verdicts;
  std::map<std::string, double> numbers;     ///< what report.json says
  std::map<std::string, std::string> units;  ///< of those that have one
  std::map<std::string, std::string> texts;  ///< method, integrator and why it was taken
  std::vector<std::string> command = {};     ///< words of the command line without -j; none where a program runs it
  Extreme lowest, highest;                   ///< of the points, at the moments that were recorded
  double wall = 0;                           ///< s
  int interrupted_by = 0;                    ///< signal number
  bool is_out_of_time = false;               ///< ended by its limit of time
  bool is_cut_short() const { return interrupted_by != 0 || is_out_of_time; }
  bool passed() const;
};

/// Puts the report of an earlier run aside, as report.earlier.json: it must not stand for this one, and is kept until
/// this one has a report of its own. Collective.
void set_report_aside(MPI_Comm comm, const std::string& folder);

/// Writes report.json: the case with all defaults, its file, the command line, versions, the result and seconds per
/// phase (wall: the slowest rank; cpu: all ranks together). An empty folder writes nothing. Throws Error(file).
/// Collective.
void write_report(MPI_Comm comm, const std::string& folder, const Case& c, const RunResult& result,
                  const Phases& phases);

/// The verdict for people: "probe hot at 60 s: 40.0 degC, expected 200.0 degC, off by 160 K, allowed 1 K".
std::string sentence(const Verdict& verdict, const TemperatureUnit& unit = {});
/// "ok  " or "FAIL", perhaps green or red.
std::string status(const Verdict& verdict, bool in_colour);
/// Both.
std::string line(const Verdict& verdict, const TemperatureUnit& unit = {}, bool in_colour = false);

/// What a run comes to, for people: points, integrator and why, temperatures, heat balance, steps, seconds. Lines of at
/// most 80 columns where words allow.
std::vector<std::string> summary(const RunResult& result, const TemperatureUnit& unit = {});

}  // namespace calor
