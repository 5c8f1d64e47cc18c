// The lowest and the highest temperature of a run, with time and place, and whether they can be.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <utility>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "base/reduce.hpp"
#include "output/observer.hpp"
#include "output/temperature_unit.hpp"
#include "solve/range_watch.hpp"

namespace calor {
namespace {

/// As it travels between ranks. The earliest counts, and of one time the point of the lowest number.
struct Candidate {
  double T = std::numeric_limits<double>::infinity(), t = 0;
  std::int64_t id = 0;
  Vec3 x = {};

  bool operator<(const Candidate& other) const {
    if (T != other.T) return T < other.T;
    return t != other.t ? t < other.t : id < other.id;
  }
};

class Extremes : public Observer {
 public:
  explicit Extremes(const RunSetup& run)
      : system_(run.system), cloud_(run.system.cloud()), unit_(TemperatureUnit::of(run.description)) {
    watch_.begin(system_, run.start);
    lowest_at_start_ = watch_.range().low;
  }

  void record(const Moment& m) override {
    const double t = m.state().t;
    watch_.see(system_, std::exchange(t_recorded_, t), t);
    const ValueRange given = system_.given_heat(t, m.u());
    is_cooled_ = is_cooled_ || given.low < 0, is_heated_ = is_heated_ || given.high > 0;
    const std::span<const double> T = m.temperatures();
    const ValueRange range = range_of(T);
    see(range.low, 1, lowest_, m);
    see(range.high, -1, highest_, m);
  }
  void exchange(Archive& archive) override {
    watch_.exchange(archive);
    archive.value("temperatures were recorded at", t_recorded_);
    archive.value("heat was taken", is_cooled_);
    archive.value("heat was given", is_heated_);
    for (Candidate* best : {&lowest_, &highest_}) {
      *best = of_all(*best);
      std::array<double, 6> numbers{best->T, best->t, static_cast<double>(best->id), best->x.x, best->x.y, best->x.z};
      archive.values(best == &lowest_ ? "lowest temperature" : "highest temperature, turned", numbers);
      *best = {.T = numbers[0],
               .t = numbers[1],
               .id = static_cast<std::int64_t>(numbers[2]),
               .x = {numbers[3], numbers[4], numbers[5]}};
    }
  }
  void finish(const Moment&, RunResult& result) override {
    result.lowest = extreme(lowest_, 1);
    result.highest = extreme(highest_, -1);
    const ValueRange& data = watch_.range();
    const double allowed = std::max(round_off * std::abs(result.highest.T),
                                    part_of_span * std::max(result.highest.T - data.low, data.high - result.lowest.T));
    if (lowest_at_start_ > 0 && result.lowest.T < 0) warn_of_absolute_zero(result.lowest);
    if (!is_cooled_ && data.low - result.lowest.T > allowed) warn(result.lowest, data.low, "below", "takes heat out");
    if (!is_heated_ && result.highest.T - data.high > allowed) warn(result.highest, data.high, "above", "heats it");
  }

 private:
  /// `value`: the lowest of the temperatures (sign = 1) or the highest (-1).
  void see(double value, int sign, Candidate& best, const Moment& m) const {
    if (!(sign * value < best.T)) return;
    const std::span<const double> T = m.temperatures();
    for (int i = 0; i < cloud_.owned; ++i)
      if (T[i] == value)
        best = std::min(best, {.T = sign * value, .t = m.state().t, .id = cloud_.id[i], .x = cloud_.x[i]});
  }
  Candidate of_all(const Candidate& mine) const {
    return std::ranges::min(gather(cloud_.comm, std::vector{mine}), std::less{});
  }
  Extreme extreme(const Candidate& mine, int sign) const {
    const Candidate best = of_all(mine);
    Extreme e{.T = sign * best.T, .t = best.t};
    for (int axis = 0; axis < cloud_.dimension; ++axis) e.x.push_back(best.x[axis]);
    return e;
  }

  /// What takes heat out without end is an error before; surroundings by a formula may lead there.
  void warn_of_absolute_zero(const Extreme& e) const {
    if (rank_of(cloud_.comm) != 0) return;
    spdlog::warn(
        "a temperature of {:.6g} K at ({:.4g}) m, {:.6g} s, is below absolute zero, unlike all at the start: are walls "
        "or surroundings given by a formula in another unit?",
        e.T, fmt::join(e.x, ", "), e.t);
  }
  void warn(const Extreme& e, double data, const char* side, const char* what) const {
    if (rank_of(cloud_.comm) != 0) return;
    spdlog::warn(
        "a temperature of {:.6g} {} at ({:.4g}) m, {:.6g} s, is {:.3g} {} {} all of start, walls and "
        "surroundings, though nothing else {}: the points are too far apart for what changes there, or take "
        "a method whose weights are positive",
        unit_.value(e.T), unit_.name(), fmt::join(e.x, ", "), e.t, unit_.difference(std::abs(e.T - data)),
        unit_.difference_name(), side, what);
  }

  static constexpr double part_of_span = 2e-2;  // methods of second order overshoot a little where data jump
  static constexpr double round_off = 1e-9;

  HeatSystem& system_;
  const Cloud& cloud_;
  TemperatureUnit unit_;
  RangeWatch watch_;
  double t_recorded_ = 0, lowest_at_start_ = 0;
  bool is_cooled_ = false, is_heated_ = false;  ///< by what draws to no ambient temperature
  Candidate lowest_, highest_;                  ///< of this rank; the highest with the sign of T turned
};

}  // namespace

std::unique_ptr<Observer> make_extremes(const RunSetup& run) { return std::make_unique<Extremes>(run); }

}  // namespace calor
