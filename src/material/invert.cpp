#include "material/invert.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace calor {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most_iterations = 200;

// The search for one temperature.
struct Search {
  double low = -infinity, high = infinity;  // H(low) < H < H(high)
  double step = infinity;                   // the last one
  bool done = false;
};

double bisect(const Search& s, double T) {
  if (std::isinf(s.low)) return T - std::max(1.0, 2 * std::abs(s.high - T) + std::abs(T));
  if (std::isinf(s.high)) return T + std::max(1.0, 2 * std::abs(T - s.low) + std::abs(T));
  return 0.5 * (s.low + s.high);
}

constexpr std::size_t block = 1024;

/// Newton's method without a bracket: from a good guess, as a step of time leaves it, it is there after two
/// evaluations. False, and T as it was, where it is not there soon.
bool converges_at_once(const Increasing& f, std::span<const double> H, std::span<double> T) {
  constexpr int most_sweeps = 4;
  const std::size_t n = H.size();
  std::array<double, block> T_now, H_now, slope, last;
  std::ranges::copy(T, T_now.begin());
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    f({T_now.data(), n}, {H_now.data(), n}, {slope.data(), n});
    bool is_safe = true, is_there = true;  // no early exit: this vectorises
    for (std::size_t i = 0; i < n; ++i) {
      const double step = (H[i] - H_now[i]) / slope[i], size = std::abs(step), level = std::abs(T_now[i]);
      const double tolerance = 1e-13 * level + 1e-300;
      // The next step would be step^3 / last^2, as below.
      const bool next_is_nothing =
          sweep > 0 && size <= 1e-8 * level && 100 * size * step * step <= tolerance * last[i] * last[i];
      is_safe &= slope[i] > 0 && size <= 0.05 * level + tolerance;
      is_there &= size <= tolerance || next_is_nothing;
      last[i] = step;
      T_now[i] += step;
    }
    if (!is_safe) return false;
    if (is_there) {
      std::copy_n(T_now.begin(), n, T.begin());
      return true;
    }
  }
  return false;
}

}  // namespace

int invert_increasing(const Increasing& f, std::span<const double> H, std::span<double> T) {
  if (converges_at_once(f, H, T)) return -1;
  std::array<Search, block> search;
  std::array<double, block> H_now, slope;
  const std::size_t n = H.size();
  std::size_t open = n;
  for (int iteration = 0; open > 0 && iteration < most_iterations; ++iteration) {
    f(T, {H_now.data(), n}, {slope.data(), n});
    for (std::size_t i = 0; i < n; ++i) {
      Search& s = search[i];
      if (s.done) continue;
      const double excess = H_now[i] - H[i], tolerance = 1e-13 * std::abs(T[i]) + 1e-300;
      if (!std::isfinite(excess)) return static_cast<int>(i);
      if (!(slope[i] > 0)) {
        // A step too far into temperatures for which the law was not meant: halfway back, if there was a way here.
        if (std::isinf(s.step) || std::abs(s.step) < tolerance) return static_cast<int>(i);
        s.step /= 2;
        T[i] -= s.step;
        continue;
      }
      (excess > 0 ? s.high : s.low) = T[i];
      // Where H hardly rises Newton's step is out of all proportion.
      const double longest = std::max(1.0, 2 * std::abs(T[i]));
      const double newton = std::clamp(-excess / slope[i], -longest, longest);
      double next = T[i] + newton;
      const bool is_there = std::abs(newton) <= tolerance;  // the bracket may be as narrow as the rounding of H
      const bool is_newton = is_there || (next > s.low && next < s.high);
      if (!is_newton) next = bisect(s, T[i]);
      const double step = next - T[i];
      // Small steps of Newton's shrink like e, C e^2, ...: the next one would be step^3 / last^2.
      const bool is_small = is_newton && std::abs(step) <= 1e-8 * std::abs(T[i]);
      s.done = is_there ||
               (is_small && 100 * std::abs(step) * std::pow(step / s.step, 2) <= tolerance && !std::isinf(s.step));
      open -= s.done;
      s.step = step;
      T[i] = next;
    }
  }
  if (open == 0) return -1;
  return static_cast<int>(std::find_if(search.begin(), search.end(), [](const Search& s) { return !s.done; }) -
                          search.begin());
}

}  // namespace calor
