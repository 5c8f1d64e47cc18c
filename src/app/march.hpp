#pragma once
// The way of a transient run from stop to stop, and what is stored of it on the way.
#include <chrono>
#include <functional>
#include <optional>
#include <set>

#include "output/checkpoint.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"
#include "solve/integrator.hpp"

namespace calor {

/// The times a run lands on, and those in between at which it is recorded.
class Timeline {
 public:
  Timeline(const Case& c, const HeatSystem& system, const Observers& observers);

  double end() const { return end_; }
  /// The next stop after t, s.
  double stop_after(double t) const { return *stops_.upper_bound(t); }
  /// Is a sample due at t? Not at a stop, where there is one anyway.
  bool sample_is_due(double t);
  void exchange(Archive& archive) { archive.value("next sample", next_sample_); }

 private:
  /// Adds t if it lies in (0, end]. What differs by round-off alone is one time.
  void add(double t);

  double end_, sample_every_, next_sample_;
  std::set<double> stops_;
};

/// Checkpoints by the clock and by steps, and the end of a run before its time. Ranks agree on all of it.
class Pace {
 public:
  /// `time_limit`: by the clock, s.
  Pace(const Case& c, MPI_Comm comm, std::optional<double> time_limit);

  /// After a step. Collective.
  void look(long steps);
  void stored(long steps);

  bool wants_checkpoint() const { return wants_checkpoint_; }
  bool is_cut_short() const { return interrupted_by_ != 0 || is_out_of_time_; }
  int interrupted_by() const { return interrupted_by_; }
  bool is_out_of_time() const { return is_out_of_time_; }

 private:
  using Clock = std::chrono::steady_clock;
  MPI_Comm comm_;
  double every_;  ///< s by the clock; 0: never
  std::optional<long> every_steps_;
  std::optional<double> limit_;
  Clock::time_point begin_ = Clock::now(), stored_ = begin_;
  long stored_steps_ = 0;
  bool wants_checkpoint_ = false, is_out_of_time_ = false;
  int interrupted_by_ = 0;
};

class March {
 public:
  March(const RunSetup& run, State& state, Integrator& integrator, const Observers& observers, const FolderLock& lock);

  /// All that the run carries. A run is stored between two steps: within an interval before anything is due, at a stop
  /// after it has been looked at; so it does not show in the results whether it was. Collective.
  void exchange(Archive& archive);
  /// From where the state is to the end, until the run is over for another reason, or is cut short. Then the last step
  /// is stored, and written for whom looks at it. Collective; throws Error.
  void run(Pace& pace, Checkpoints& checkpoints, RunResult& result);

 private:
  void record(const Moment& m);
  Moment now() { return {run_.system, state_, integrator_.counts.steps}; }
  /// Looks at a stop, or at the last state.
  void look(bool is_last, bool is_cut_short);
  void store(Pace& pace, Checkpoints& checkpoints);

  const RunSetup& run_;
  State& state_;
  Integrator& integrator_;
  const Observers& observers_;
  const FolderLock& lock_;
  Timeline timeline_;
  bool has_begun_ = false;
  double recorded_at_ = -1, applied_at_ = 0;  ///< s
};

}  // namespace calor
