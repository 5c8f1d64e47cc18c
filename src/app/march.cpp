#include "app/march.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/interrupts.hpp"
#include "base/archive.hpp"
#include "base/parallel.hpp"

namespace calor {

Timeline::Timeline(const Case& c, const HeatSystem& system, const Observers& observers)
    : end_(c.section("time").number("end")),
      sample_every_(end_ / static_cast<double>(c.section("output").integer("samples"))),
      next_sample_(sample_every_) {
  add(end_);
  for (const auto& observer : observers)
    for (const double t : observer->times()) add(t);
  for (const double t : system.events()) add(t);
}

bool Timeline::sample_is_due(double t) {
  if (t < next_sample_ * (1 - 1e-12) || stops_.contains(t)) return false;
  next_sample_ = (std::floor(t / sample_every_ * (1 + 1e-12)) + 1) * sample_every_;
  return true;
}

void Timeline::add(double t) {
  if (t <= 0 || t > end_ * (1 + 1e-12)) return;
  const auto near = stops_.lower_bound(t - 1e-12 * end_);
  if (near == stops_.end() || *near > t + 1e-12 * end_) stops_.insert(t);
}

Pace::Pace(const Case& c, MPI_Comm comm, std::optional<double> time_limit)
    : comm_(comm), every_(c.section("output").number("checkpoint")), limit_(time_limit) {
  if (c.section("output").has("checkpoint_steps")) every_steps_ = c.section("output").integer("checkpoint_steps");
}

void Pace::look(long steps) {
  const auto seconds_since = [now = Clock::now()](Clock::time_point t) {
    return std::chrono::duration<double>(now - t).count();
  };
  constexpr std::uint32_t interrupt = 1, late = 2, checkpoint = 4;
  std::uint32_t wishes = calor::interrupted_by() != 0 ? interrupt : 0;
  if (limit_ && seconds_since(begin_) >= *limit_) wishes |= late;
  const bool by_clock = every_ > 0 && seconds_since(stored_) >= every_;
  const bool by_steps = every_steps_ && steps - stored_steps_ >= *every_steps_;
  if (by_clock || by_steps) wishes |= checkpoint;
  wishes = any_bit(comm_, wishes);
  wants_checkpoint_ = wishes != 0;
  is_out_of_time_ = (wishes & late) != 0;
  if (wishes & interrupt) interrupted_by_ = static_cast<int>(max(comm_, calor::interrupted_by()));
}

void Pace::stored(long steps) {
  stored_ = Clock::now(), stored_steps_ = steps;
  wants_checkpoint_ = false;
}

March::March(const RunSetup& run, State& state, Integrator& integrator, const Observers& observers,
             const FolderLock& lock)
    : run_(run),
      state_(state),
      integrator_(integrator),
      observers_(observers),
      lock_(lock),
      timeline_(run.description, run.system, observers) {}

void March::exchange(Archive& archive) {
  archive.value("has been looked at", has_begun_);
  archive.value("recorded at", recorded_at_);
  archive.value("applied at", applied_at_);
  run_.system.exchange(archive, state_);
  timeline_.exchange(archive);
  if (archive.reads()) run_.system.apply(applied_at_);
  integrator_.exchange(archive, run_.system);
  for (const auto& observer : observers_) observer->exchange(archive);
}

void March::record(const Moment& m) {
  if (state_.t == recorded_at_) return;
  recorded_at_ = state_.t;
  lock_.require_folder();
  for (const auto& observer : observers_) observer->record(m);
}

void March::look(bool is_last, bool is_cut_short) {
  Moment m = now();
  m.is_last = is_last, m.is_cut_short = is_cut_short;
  record(m);
  for (const auto& observer : observers_) observer->at_stop(m);
}

void March::store(Pace& pace, Checkpoints& checkpoints) {
  const long steps = integrator_.counts.steps;
  if (checkpoints.are_kept()) try {
      run_.phases.measure("checkpoints",
                          [&] { checkpoints.write(state_.t, steps, [&](Archive& archive) { exchange(archive); }); });
    } catch (const Error& e) {
      if (pace.is_cut_short()) throw;
      // The disk may have room again before this one is missed.
      if (rank_of(run_.comm()) == 0) spdlog::warn("no checkpoint at t = {:.6g} s: {}", state_.t, e.what());
    }
  pace.stored(steps);
}

void March::run(Pace& pace, Checkpoints& checkpoints, RunResult& result) {
  bool is_over = false;
  if (!std::exchange(has_begun_, true)) look(false, false);
  while (state_.t < timeline_.end() && !is_over && !pace.is_cut_short()) {
    const double stop = timeline_.stop_after(state_.t);
    applied_at_ = state_.t * (1 + 1e-12);
    run_.system.apply(applied_at_);
    const auto after_step = [&](const State&) {
      const Moment m = now();
      for (const auto& observer : observers_) is_over = !observer->after_step(m) || is_over;
      if (timeline_.sample_is_due(state_.t)) record(m);
      pace.look(m.steps);
      if (is_over || state_.t == stop) return !is_over;
      if (pace.wants_checkpoint()) store(pace, checkpoints);
      return !pace.is_cut_short();
    };
    run_.phases.measure("march", [&] { integrator_.advance(run_.system, state_, stop, after_step); });
    const bool is_last = is_over || state_.t == timeline_.end();
    if (is_last || state_.t == stop) look(is_last, false);
    if (!is_last && pace.wants_checkpoint()) store(pace, checkpoints);
    if (!is_last && pace.is_cut_short()) {
      look(false, true);
      result.interrupted_by = pace.interrupted_by();
      result.is_out_of_time = pace.is_out_of_time();
    }
  }
  const StepCounts& n = integrator_.counts;
  result.numbers.insert({{"steps", n.steps},
                         {"rejected_steps", n.rejected},
                         {"rate_evaluations", n.rate_evaluations},
                         {"newton_iterations", n.newton_iterations},
                         {"linear_iterations", n.linear_iterations},
                         {"most_stages", n.most_stages},
                         {"smallest_step", n.smallest_step},
                         {"largest_step", n.largest_step},
                         {"end", state_.t}});
}

}  // namespace calor
