// The lowest and the highest temperature of a run, with time and place.
#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "base/reduce.hpp"
#include "output/observer.hpp"

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
  explicit Extremes(const Cloud& cloud) : cloud_(cloud) {}

  void record(const Moment& m) override {
    const std::span<const double> T = m.temperatures();
    const ValueRange range = range_of(T);
    see(range.low, 1, lowest_, m);
    see(range.high, -1, highest_, m);
  }
  void exchange(Archive& archive) override {
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

  const Cloud& cloud_;
  Candidate lowest_, highest_;  ///< of this rank; the highest with the sign of T turned
};

}  // namespace

std::unique_ptr<Observer> make_extremes(const RunSetup& run) { return std::make_unique<Extremes>(run.system.cloud()); }

}  // namespace calor
