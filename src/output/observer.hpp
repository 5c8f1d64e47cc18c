#pragma once
// What is looked at and written while a case runs. An observer is one file and one line in a registry.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/registry.hpp"
#include "output/report.hpp"
#include "solve/heat_system.hpp"

namespace calor {

class Archive;
class Probes;
class ThermalStress;
class WeldResults;

/// A moment of a run.
class Moment {
 public:
  Moment(HeatSystem& system, State& state, long steps = 0) : steps(steps), system_(system), state_(state) {}

  const State& state() const { return state_; }
  std::span<double> u() const { return state_.T; }  ///< degrees of freedom, for what updates their ghosts
  /// Temperatures of the owned points, K; from then on the ghosts of state().T are up to date. Collective.
  std::span<const double> temperatures() const {
    if (!is_known_) T_ = system_.temperatures(state_.T), is_known_ = true;
    return T_;
  }

  long steps;                 ///< so far
  bool is_last = false;       ///< the run has come to its end
  bool is_cut_short = false;  ///< by a signal or a limit of time

 private:
  HeatSystem& system_;
  State& state_;
  mutable std::vector<double> T_;
  mutable bool is_known_ = false;
};

/// All calls are collective and may throw Error on all ranks.
class Observer {
 public:
  virtual ~Observer() = default;
  /// Times that the run has to land on, s.
  virtual std::vector<double> times() const { return {}; }
  /// Opens files; whatever a case can be refused for was refused when the observer was made.
  virtual void begin() {}
  /// After every step; false ends the run.
  virtual bool after_step(const Moment&) { return true; }
  /// At the start, at about [output] samples moments, evenly spaced, and at all stops.
  virtual void record(const Moment&) {}
  /// At the start, where the run lands on a time, and where it ends.
  virtual void at_stop(const Moment&) {}
  /// What it has gathered so far, for a run that goes on later; reading comes before `begin`, which then opens the
  /// files where they were left.
  virtual void exchange(Archive&) {}
  /// At the end: adds to the result.
  virtual void finish(const Moment&, RunResult&) {}
  /// The numbers of the report that `finish` adds.
  virtual std::vector<ReportNumber> numbers() const { return {}; }
};

/// What observers are made of. It outlives them.
struct RunSetup {
  const Case& description;
  HeatSystem& system;
  const Probes& probes;
  std::shared_ptr<WeldResults> weld;                 ///< null where the case has no [weld]
  std::shared_ptr<const ThermalStress> stress = {};  ///< null where the case has no [stress]
  const std::vector<double>& start_E;                ///< enthalpies of the owned points before walls were imposed, J
  const State& start;                                ///< walls imposed; the state of the run itself, as it goes on
  std::string folder = {};                           ///< of the results; empty: nothing is written
  bool is_quiet = true;                              ///< no progress line
  Phases& phases;

  MPI_Comm comm() const { return system.cloud().comm; }
  bool is_steady() const { return description.root().has("steady"); }
};

struct ObserverKind {
  std::string name;
  std::string sentence;
  void (*declare)(Schema& schema) = nullptr;  ///< its own keys
  /// Null where a run has no use for it. Refuses what the case asks of it and cannot have. Collective; throws Error.
  std::function<std::unique_ptr<Observer>(const RunSetup& run)> make;
  std::vector<std::string> files = {};  ///< what it writes into the folder of results, as `remove_files` takes it
};
/// In the order in which they look.
Registry<ObserverKind>& observers();

/// The keys of [output].
void declare_output(Schema& schema);

using Observers = std::vector<std::unique_ptr<Observer>>;
/// All observers of a run; those that give the verdicts come last. Collective; throws Error.
Observers make_observers(const RunSetup& run);
/// Removes what an earlier run has left in the folder of results, so that nothing of it is taken for a result of this
/// run: all files of the observers. Throws Error(file). Collective.
void remove_earlier_results(MPI_Comm comm, const std::string& folder);

// The observers, each in its own file.
std::unique_ptr<Observer> make_progress(const RunSetup& run);
std::unique_ptr<Observer> make_weld_log(const RunSetup& run);
std::unique_ptr<Observer> make_energy_log(const RunSetup& run);
std::unique_ptr<Observer> make_balance_log(const RunSetup& run);
std::unique_ptr<Observer> make_stress_log(const RunSetup& run);
std::unique_ptr<Observer> make_probe_log(const RunSetup& run);
std::unique_ptr<Observer> make_extremes(const RunSetup& run);
std::unique_ptr<Observer> make_fields(const RunSetup& run);
std::unique_ptr<Observer> make_steady_stop(const RunSetup& run);
std::unique_ptr<Observer> make_final_state(const RunSetup& run);
std::unique_ptr<Observer> make_known_range(const RunSetup& run);
std::unique_ptr<Observer> make_expectations(const RunSetup& run);

}  // namespace calor
