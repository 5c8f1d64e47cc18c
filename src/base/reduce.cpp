#include "base/reduce.hpp"

#include <algorithm>
#include <cmath>

#include "base/simd.hpp"

namespace calor {
namespace {

constexpr int lanes = 32;  // so many that operations of several vectors overlap

}  // namespace

ValueRange range_of(std::span<const double> values) {
  ValueRange range;
  std::size_t done = 0;
  run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
    constexpr int blocks = lanes / width;
    Doubles<width> low[blocks], high[blocks];
    for (int b = 0; b < blocks; ++b) low[b] = Doubles<width>{} + range.low, high[b] = Doubles<width>{} + range.high;
    std::size_t i = 0;
    for (; i + lanes <= values.size(); i += lanes) {
#pragma GCC unroll 16
      for (int b = 0; b < blocks; ++b) {
        const auto v = Consecutive<width>{static_cast<std::int64_t>(i) + b * width}(values.data());
        low[b] = v < low[b] ? v : low[b];
        high[b] = v > high[b] ? v : high[b];
      }
    }
    for (int b = 0; b < blocks; ++b)
      for (int lane = 0; lane < width; ++lane)
        range.low = std::min(range.low, low[b][lane]), range.high = std::max(range.high, high[b][lane]);
    done = i;
  });
  for (const double v : values.subspan(done)) range.low = std::min(range.low, v), range.high = std::max(range.high, v);
  return range;
}

bool all_finite(std::span<const double> values) {
  double sum = 0;  // of zeros, unless a value is infinite or not a number
  std::size_t done = 0;
  run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
    constexpr int blocks = lanes / width;
    Doubles<width> sums[blocks] = {};
    std::size_t i = 0;
    for (; i + lanes <= values.size(); i += lanes) {
#pragma GCC unroll 16
      for (int b = 0; b < blocks; ++b) {
        const auto v = Consecutive<width>{static_cast<std::int64_t>(i) + b * width}(values.data());
        sums[b] += v - v;
      }
    }
    for (int b = 0; b < blocks; ++b)
      for (int lane = 0; lane < width; ++lane) sum += sums[b][lane];
    done = i;
  });
  for (const double v : values.subspan(done)) sum += v - v;
  return sum == 0;
}

}  // namespace calor
