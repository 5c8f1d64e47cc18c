#pragma once
// What is asked of whole arrays in every step of a run, at the speed of memory.
#include <limits>
#include <span>

namespace calor {

/// low > high of nothing.
struct ValueRange {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  double span() const { return high - low; }
};

/// Lowest and highest value; those that are not a number are passed over.
ValueRange range_of(std::span<const double> values);
bool all_finite(std::span<const double> values);

}  // namespace calor
