#include "solve/stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/archive.hpp"
#include "base/parallel.hpp"

namespace calor {
namespace {

/// Steps change by powers of 2^(1/8). The last digits of an error estimate, or of a stable step, which come from
/// solvers and differ between numbers of ranks and poses of a body, then hardly ever change a step.
constexpr double steps_per_octave = 8;
double nearest_power(double factor) {
  return std::exp2(std::round(steps_per_octave * std::log2(factor)) / steps_per_octave);
}
double power_below(double factor) {
  return std::exp2(std::floor(steps_per_octave * std::log2(factor)) / steps_per_octave);
}

bool same_time(double a, double b) { return std::abs(a - b) <= 1e-12 * std::max(std::abs(a), std::abs(b)); }

}  // namespace

SmoothInterval::SmoothInterval(const Changes& changes, double t, double t_end)
    : marks_(changes.marks), begin_(t), end_(t_end) {
  for (double b : changes.events) {
    if (same_time(b, t)) begins_at_break_ = true;
    if (same_time(b, t_end)) ends_at_break_ = true;
    if (b > t && b < end_ && !same_time(b, t) && !same_time(b, t_end)) end_ = b, ends_at_break_ = true;
  }
}

double SmoothInterval::data_time(double t) const {
  const double inside = 1e-11 * std::max(end_ - begin_, std::max(std::abs(begin_), std::abs(end_)));
  const double low = begins_at_break_ ? begin_ + inside : begin_, high = ends_at_break_ ? end_ - inside : end_;
  return std::clamp(t, low, std::max(low, high));
}

double SmoothInterval::longest_step(double t, int marks) const {
  const auto next = std::ranges::upper_bound(marks_, t * (1 + 1e-12));
  return marks_.end() - next > marks ? next[marks] - t : std::numeric_limits<double>::infinity();
}

void Stepper::advance(HeatSystem& system, State& state, double t_end, const AfterStep& after_step) {
  while (state.t < t_end) {
    if (!interval_) enter_next(system, state, t_end);
    while (state.t < interval_->end()) {
      const double dt = step(system, state, *interval_);
      accept(system, state, dt);
      ++steps_in_interval_;
      if (!after_step(state)) return;
    }
    interval_.reset();
  }
}

void Stepper::enter_next(HeatSystem& system, State& state, double t_end) {
  if (has_begun_ && shifted_.empty()) shifted_ = system.shifted_at_corners(state.t, state.T);  // as it was stored
  if (const auto begin = std::exchange(stored_begin_, std::nullopt)) {
    interval_.emplace(system.changes(), *begin, t_end);
    return;
  }
  interval_.emplace(system.changes(), state.t, t_end);
  steps_in_interval_ = 0;
  if (!has_begun_) watch_.begin(system, state);
  const bool fresh = !has_begun_ || interval_->begins_at_break();
  has_begun_ = true;
  if (interval_->begins_at_break()) {
    const double t = interval_->data_time(state.t);
    if (follower_) follower_->impose(t, state);
    system.impose(t, state.T, state.E, state.cumulative_heat);
  }
  enter(system, state, *interval_, fresh);
  if (interval_->begins_at_break()) shifted_.clear();
}

void Stepper::accept(HeatSystem& system, State& state, double dt) {
  system.require_finite(state.t, state.T);
  watch_.see(system, state.t - dt, state.t);
  watch_.require(system, state.t, state.T, allowed_excess());
  book_corners(system, state, dt);
  counts.smallest_step = counts.steps == 0 ? dt : std::min(counts.smallest_step, dt);
  counts.largest_step = std::max(counts.largest_step, dt);
  ++counts.steps;
}

void Stepper::book_corners(HeatSystem& system, State& state, double dt) {
  if (!system.has_corners()) return;
  const std::vector<double> before = std::exchange(shifted_, system.shifted_at_corners(state.t, state.T));
  for (std::size_t account = 0; account < shifted_.size(); ++account)
    state.cumulative_heat[account] +=
        dt * std::midpoint(before.empty() ? shifted_[account] : before[account], shifted_[account]);
}

void Stepper::exchange(Archive& archive, HeatSystem& system) {
  archive.value("steps", counts.steps);
  archive.value("rejected steps", counts.rejected);
  archive.value("rate evaluations", counts.rate_evaluations);
  archive.value("newton iterations", counts.newton_iterations);
  archive.value("linear iterations", counts.linear_iterations);
  archive.value("most stages", counts.most_stages);
  archive.value("smallest step", counts.smallest_step);
  archive.value("largest step", counts.largest_step);
  archive.value("has begun", has_begun_);
  if (!has_begun_) return;
  bool is_inside = interval_.has_value();
  double begin = is_inside ? interval_->begin() : 0;
  archive.value("inside an interval", is_inside);
  archive.value("interval begins", begin);
  archive.value("steps in interval", steps_in_interval_);
  if (archive.reads() && is_inside) stored_begin_ = begin;
  archive.value("largest span", largest_span_);
  watch_.exchange(archive);
  exchange_own(archive, system);
}

Stepper::Step Stepper::equal_step(const SmoothInterval& interval) const {
  const EqualSteps steps(interval.begin(), interval.end(), *options_.step);
  return {.dt = steps.step(), .t_new = steps.time(steps_in_interval_ + 1)};
}

double Stepper::allowed_excess() const {
  constexpr double part_of_span = 1e-2;  // methods of second order overshoot a little where data jump
  return std::max(part_of_span * watch_.range().span(), 10 * options_.tolerance.value_or(0));
}

bool Stepper::leaves_range(HeatSystem& system, double t, double t_new, std::span<double> u) {
  watch_.see(system, t, t_new);
  return watch_.excess(system, u) > allowed_excess();
}

void require_motion(double t, double t_new) {
  if (t_new > t) return;
  throw Error(Fault::numbers, fmt::format("steps have become so short that time stands still at t = {:.6g} s", t),
              "look for properties, conditions, sources or an end of an absurd size, or for a run-away");
}

double Stepper::tolerance(HeatSystem& system, const State& state) {
  if (options_.tolerance) return *options_.tolerance;
  constexpr double part_of_span = 1e-4, least = 1e-6;
  largest_span_ = std::max(largest_span_, system.temperature_span(state.t, state.T));
  return std::max(least, part_of_span * largest_span_);
}

EqualSteps::EqualSteps(double begin, double end, double step)
    : begin_(begin),
      end_(end),
      count_(count(end - begin, step, begin)),
      step_((end - begin) / static_cast<double>(count_)) {}

long EqualSteps::count(double length, double step, double begin) {
  const double count = std::ceil(length / step * (1 - 1e-9));
  constexpr double most = 0x1p52;  // time would not move
  if (!(count < most)) require_motion(begin, begin);
  return std::max(1L, static_cast<long>(count));
}

void StepControl::restart(double most, double length) {
  proposal_ = length * power_below(std::min(most / length, 1.0));
}

double StepControl::next(double t, double end, double most) {
  const double dt = std::min(proposal_, most), left = end - t;
  if (dt >= left * (1 - 1e-9)) return left;
  return dt > 0.5 * left ? 0.5 * left : dt;
}

void StepControl::exchange(Archive& archive) {
  archive.value("proposed step", proposal_);
  archive.value("was rejected", was_rejected_);
}

bool StepControl::judge(double dt, double error, double always_good) {
  constexpr double safety = 0.8, least = 0.2, most = 2.5;
  double factor = std::isfinite(error) ? safety * std::pow(std::max(error, 1e-12), -1. / 3) : least;
  factor = std::clamp(nearest_power(factor), least, was_rejected_ ? 1.0 : most);
  if (factor > 1 && factor < least_growth_) factor = 1;
  const bool accepted = error <= 1 || (dt <= always_good && std::isfinite(error));
  // A step shortened to end in time says little about the longer one that was proposed.
  if (accepted && dt < proposal_ && factor * dt >= dt)
    proposal_ = std::max(proposal_, factor * dt);
  else
    proposal_ = std::max(factor * dt, accepted ? std::min(dt, always_good) : 0);
  was_rejected_ = !accepted;
  return accepted;
}

}  // namespace calor
