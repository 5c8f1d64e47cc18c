#pragma once
// What all integrators share: stretches of time without events in the data, step sizes, error tolerances.
#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/function.hpp"
#include "case/registry.hpp"
#include "solve/integrator.hpp"
#include "solve/range_watch.hpp"

namespace calor {

/// A interval of time in which data are smooth. Data are asked for just inside its ends, so that at a jump either side
/// gets its own value.
class SmoothInterval {
 public:
  /// From t to the next event or t_end. The changes must outlive it.
  SmoothInterval(const Changes& changes, double t, double t_end);

  double begin() const { return begin_; }
  double end() const { return end_; }
  bool begins_at_break() const { return begins_at_break_; }
  /// The time at which data are evaluated for a stage at t.
  double data_time(double t) const;
  /// A step from t as long as the data allow that pass over so many of their marks, s.
  double longest_step(double t, int marks) const;

 private:
  const std::vector<double>& marks_;
  double begin_, end_;
  bool begins_at_break_ = false, ends_at_break_ = false;
};

struct StepOptions {
  std::optional<double> step;       ///< s; given: all steps are (nearly) this long
  std::optional<double> tolerance;  ///< K; error of one step. Default: 1e-4 of the span of temperatures
  double safety = 0.9;              ///< part of the stable step that Euler takes
};

/// Splits [t, t_end] at the events of the data and leaves the steps within one interval to the method.
class Stepper : public Integrator {
 public:
  explicit Stepper(StepOptions options) : options_(options) {}
  void advance(HeatSystem& system, State& state, double t_end, const AfterStep& after_step) final;
  void exchange(Archive& archive, HeatSystem& system) final;

 protected:
  /// Where an interval begins. `fresh`: the solution may not be smooth here, as data jump or the run begins.
  virtual void enter(HeatSystem& system, State& state, const SmoothInterval& interval, bool fresh) = 0;
  /// Takes the state one step on, at most to the end of the interval; returns the length of the step, s.
  virtual double step(HeatSystem& system, State& state, const SmoothInterval& interval) = 0;
  /// What the method itself carries from step to step.
  virtual void exchange_own(Archive& archive, HeatSystem& system) = 0;

  long steps_in_interval() const { return steps_in_interval_; }  ///< taken so far
  struct Step {
    double dt, t_new;  ///< s
  };
  /// The next one where all are (nearly) as long as options_.step.
  Step equal_step(const SmoothInterval& interval) const;
  /// Do degrees of freedom u at t_new, a step after t, lie farther out of the range of data than errors of steps may
  /// take them? Collective.
  bool leaves_range(HeatSystem& system, double t, double t_new, std::span<double> u);
  /// The step tolerance now, K.
  double tolerance(HeatSystem& system, const State& state);

  StepOptions options_;
  StepFollower* follower_ = nullptr;

 private:
  /// Enters the next interval, or goes on in the one in which the run was stored.
  void enter_next(HeatSystem& system, State& state, double t_end);
  /// Books a step and checks the state. Throws Error(numbers) where temperatures are not finite or cannot be.
  void accept(HeatSystem& system, State& state, double dt);
  /// Books the heat of a step to the walls where they meet.
  void book_corners(HeatSystem& system, State& state, double dt);
  /// How far out of the range of data temperatures may be, K.
  double allowed_excess() const;

  std::optional<SmoothInterval> interval_;  ///< in which the state is, if it has not come to its end
  std::optional<double> stored_begin_;      ///< of the interval in which the run was stored
  long steps_in_interval_ = 0;
  bool has_begun_ = false;
  RangeWatch watch_;
  double largest_span_ = 0;
  std::vector<double> shifted_;  ///< at corners at the end of the last step, W; empty where data have jumped since
};

/// Throws Error(numbers) where a step from t does not move the time.
void require_motion(double t, double t_new);

/// Equal steps of about `step` that end exactly at the end of the interval.
class EqualSteps {
 public:
  EqualSteps(double begin, double end, double step);
  long count() const { return count_; }
  double time(long n) const { return n == count_ ? end_ : begin_ + static_cast<double>(n) * step_; }
  double step() const { return step_; }

 private:
  /// Throws Error(numbers) where steps are too short to move the time.
  static long count(double length, double step, double begin);

  double begin_, end_;
  long count_;
  double step_;
};

/// Marks of the data that a step may pass over: with an eye on the error of steps, and without.
constexpr int marks_with_control = 5, marks_without_control = 1;

/// Adaptive steps shorter than this, s, are taken whatever their error: neither the body, whose scale is Euler's limit,
/// nor the data change faster.
inline double shortest_scale(const SmoothInterval& interval, double euler_limit) {
  return 1e-3 * std::min(euler_limit, interval.end() - interval.begin());
}

/// Lengths of adaptive steps for a method whose step error grows like dt^3.
class StepControl {
 public:
  /// A step that could grow by less than `least_growth` stays as it is: implicit methods keep their factorisation.
  explicit StepControl(double least_growth = 1) : least_growth_(least_growth) {}
  /// The first step of a stretch of time of that length, at most `most`.
  void restart(double most, double length);
  bool has_proposal() const { return proposal_ > 0; }
  /// The next step: the proposal, at most `most`, shortened so that the steps to `end` come out even.
  double next(double t, double end, double most);
  /// Takes the error of the step dt in units of the tolerance; true if the step is accepted. Steps of at most
  /// `always_good` are not refused.
  bool judge(double dt, double error, double always_good);
  /// After a step that failed altogether.
  void reduce(double dt) { proposal_ = 0.25 * dt, was_rejected_ = true; }
  void exchange(Archive& archive);

 private:
  double least_growth_;
  double proposal_ = 0;
  bool was_rejected_ = false;
};

/// A value of [time] integrator. A new one is a new file and its name in integrators.cpp.
struct IntegratorKind {
  std::string name, sentence;
  std::unique_ptr<Integrator> (*make)(const StepOptions& options);
  bool is_adaptive = false;  ///< chooses its steps where the case gives none
  bool is_explicit = false;
};
Registry<IntegratorKind>& integrators();

}  // namespace calor
