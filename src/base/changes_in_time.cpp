// When a formula of time jumps, begins to change or comes to rest, and how fast it changes: steps that follow the body
// alone would pass over what happens between two of them.
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "base/function.hpp"

namespace calor {
namespace {

/// Pulses shorter than this part of a run may be missed.
constexpr int samples = 10000;

/// The values of a function at the places, at one time.
class Values {
 public:
  Values(const Function& f, std::span<const Vec3> places, double T) : f_(f), x_(places), T_(places.size(), T) {}

  /// Nothing where the function fails: whoever needs it there will say so.
  bool at(double t, std::vector<double>& out) const {
    out.resize(x_.size());
    try {
      f_.evaluate({.x = x_, .t = t, .T = T_}, out);
    } catch (const Error&) {
      return false;
    }
    return true;
  }

 private:
  const Function& f_;
  std::span<const Vec3> x_;
  std::vector<double> T_;
};

/// The largest change, in parts of the range at each place.
double change(std::span<const double> a, std::span<const double> b, std::span<const double> range) {
  double most = 0;
  for (std::size_t n = 0; n < a.size(); ++n)
    if (range[n] > 0) most = std::max(most, std::abs(b[n] - a[n]) / range[n]);
  return most;
}

/// The time of a jump between two times, if most of the change is one.
std::optional<double> jump_between(const Values& values, double low, double high, std::span<const double> range) {
  std::vector<double> at_low, at_high, at_middle;
  if (!values.at(low, at_low) || !values.at(high, at_high)) return std::nullopt;
  const double whole = change(at_low, at_high, range);
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (low + high);
    if (!(low < middle && middle < high) || !values.at(middle, at_middle)) break;
    if (change(at_low, at_middle, range) >= change(at_middle, at_high, range))
      high = middle, at_high = at_middle;
    else
      low = middle, at_low = at_middle;
  }
  if (change(at_low, at_high, range) < 0.5 * whole) return std::nullopt;
  return high;
}

}  // namespace

Changes Function::found_changes(const Course& course) const {
  const std::span<const Vec3> all(course.places);
  const Values values(*this, depends_on_place() ? all : all.first(1), course.T);
  std::vector<std::vector<double>> value;
  for (int n = 0; n <= samples; ++n) {
    value.emplace_back();
    if (values.at(course.end * n / samples, value.back())) continue;
    value.pop_back();
    break;
  }
  if (value.empty()) return {};
  std::vector<double> range;
  for (std::size_t q = 0; q < value[0].size(); ++q) {
    double least = value[0][q], most = least, size = 0;
    for (const auto& v : value) {
      least = std::min(least, v[q]), most = std::max(most, v[q]);
      size = std::max(size, std::abs(v[q]));
    }
    constexpr double round_off = 1e-12;
    range.push_back(most - least > round_off * size ? most - least : 0);
  }

  constexpr double still = 1e-9, fast = 1e-2;  // changes from sample to sample, in parts of the range
  constexpr std::size_t rest = 10;             // samples: what a smooth function does not stand still for
  constexpr double from_mark_to_mark = 0.02;   // of the range
  Changes found;
  const auto time = [&](std::size_t n) { return course.end * static_cast<double>(n) / samples; };
  double since_mark = 0;
  std::size_t quiet = 0;
  bool moves = false;
  for (std::size_t n = 1; n < value.size(); ++n) {
    const double v = change(value[n - 1], value[n], range);
    if (v > fast) {
      if (const auto jump = jump_between(values, time(n - 1), time(n), range)) {
        found.events.push_back(*jump);
        quiet = 0;
        moves = false;
        continue;
      }
    }
    if (v > still) {
      if (quiet >= rest) found.events.push_back(time(n - 1));
      quiet = 0;
      moves = true;
    } else if (++quiet == rest && moves) {
      found.events.push_back(time(n - rest));
      moves = false;
    }
    // As if it changed evenly from sample to sample.
    const double before = since_mark;
    since_mark += v;
    for (int mark = 1; mark * from_mark_to_mark <= since_mark; ++mark) {
      const double part = (mark * from_mark_to_mark - before) / v;
      found.marks.push_back((1 - part) * time(n - 1) + part * time(n));
    }
    since_mark = std::fmod(since_mark, from_mark_to_mark);
  }
  return found;
}

}  // namespace calor
