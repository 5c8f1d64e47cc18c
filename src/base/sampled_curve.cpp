// Curves through samples of a function, which grow where they are asked.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

#include "base/error.hpp"
#include "base/knots.hpp"
#include "base/sampler.hpp"

namespace calor {
namespace {

constexpr double finest = 0x1p17;  // intervals over [lo, hi]
constexpr std::int64_t most_knots = 10'000'000;

class Samples final : public Curve::Knots {
 public:
  Samples(std::function<double(double)> f, double lo, double hi) : f_(std::move(f)) {
    // Intervals of a few thousandths of the temperature at most, however smooth f is over [lo, hi]: outside it may have
    // a peak. At least 8 over [lo, hi] where that is more than next to nothing.
    const double largest = std::max(std::abs(lo), std::abs(hi)), level = largest > 0 ? largest : 1;
    const double width = std::max(hi - lo, level / 128);
    ramp_ = Sampler::ramp(level);
    step_ = std::exp2(std::floor(std::log2(std::min(width / 8, level / 256))));
    for (double x = lo; x <= hi; x += std::min(Sampler::scan, width / 8))
      largest_ = std::max(largest_, std::abs(f_(x)));
    while (!is_mostly_smooth(lo, hi) && width / (step_ / 2) <= finest) step_ /= 2;
    per_step_ = 1 / step_;
    first_ = std::floor(lo * per_step_);
    include(lo, hi);
  }

  void evaluate(Ask ask, std::span<const double> x, std::span<double> out) const override {
    if (x.empty()) return;
    double lo = first_ * step_, hi = lo;  // both inside
    for (const double xi : x) {
      lo = xi < lo ? xi : lo;
      hi = xi > hi ? xi : hi;
    }
    include(lo, hi);
    if (ask == Ask::value) evaluate<Ask::value>(x, out);
    if (ask == Ask::derivative) evaluate<Ask::derivative>(x, out);
    if (ask == Ask::integral) evaluate<Ask::integral>(x, out);
  }

 private:
  // Local coordinate s = x / step - knot in [0, 1): exact, since the step is a power of two.
  template <Ask ask>
  void evaluate(std::span<const double> x, std::span<double> out) const {
    const SampledInterval* intervals = intervals_.data() + unused_;
    const auto last = static_cast<double>(intervals_.size() - unused_ - 1);
    const double scale = ask == Ask::value ? 1 : ask == Ask::derivative ? per_step_ : step_;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double u = x[i] * per_step_;
      const double knot = std::floor(u);
      const double interval = knot - first_;
      // NaN falls on the last interval and comes out as NaN.
      const auto k = static_cast<std::int32_t>(interval < last ? interval : last);
      out[i] = scale * intervals[k].at<ask>(u - knot);
    }
  }

  bool is_mostly_smooth(double lo, double hi) const {
    const Sampler sampler(f_, step_, largest_, ramp_);
    std::int64_t all = 0, rough = 0;
    for (double knot = std::floor(lo / step_); knot * step_ <= hi; ++knot, ++all) rough += !sampler.is_smooth(knot);
    return Sampler::are_few(rough, all);
  }

  /// Grows until lo and hi lie inside.
  void include(double lo, double hi) const {
    const auto size = [this] { return static_cast<std::int64_t>(intervals_.size() - unused_); };
    const double below = first_ - std::floor(lo * per_step_);
    const double above = std::floor(hi * per_step_) - (first_ + size()) + 1;
    if (below <= 0 && above <= 0) return;
    if (!(std::max(below, 0.0) + std::max(above, 0.0) + size() < most_knots)) {
      throw Error(Fault::numbers,
                  "the tabulated function is asked for between " + std::to_string(lo) + " and " + std::to_string(hi) +
                      ", too far from where it is known",
                  "look why the temperatures run away, or use a table instead of a formula");
    }
    Sampler sampler(f_, step_, largest_, ramp_);
    for (auto missing = static_cast<std::int64_t>(above); missing > 0; --missing) {
      SampledInterval next = sampler.interval(first_ + size());
      if (size() > 0) next.cubic.before = intervals_.back().cubic.before + intervals_.back().area();
      intervals_.push_back(std::move(next));
    }
    if (below > unused_) {  // room in front, as much as there is already
      const std::size_t room = std::max<std::size_t>(below - unused_, intervals_.size());
      intervals_.insert(intervals_.begin(), room, SampledInterval{});
      unused_ += room;
    }
    for (auto missing = static_cast<std::int64_t>(below); missing > 0; --missing) {
      SampledInterval next = sampler.interval(first_ - 1);
      next.cubic.before = intervals_[unused_].cubic.before - next.area();
      intervals_[--unused_] = std::move(next);
      --first_;
    }
  }

  std::function<double(double)> f_;
  double step_, per_step_, ramp_;
  double largest_ = 0;  // |f| over [lo, hi]
  // What is known so far: intervals [first_, first_ + 1], ... in steps; entries before `unused_` are room to grow.
  mutable double first_;
  mutable std::size_t unused_ = 0;
  mutable std::vector<SampledInterval> intervals_;
};

}  // namespace

Curve Curve::sampled(std::function<double(double)> f, double lo, double hi) {
  Curve curve;
  curve.knots_ = std::make_shared<Samples>(std::move(f), lo, hi);
  return curve;
}

}  // namespace calor
