#pragma once
// What templates over the width of vectors need besides arithmetic.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/simd.hpp"

namespace calor {

/// Doubles, and what comparing them gives: template arguments lose the attribute of an alias that depends on others.
template <int width>
struct Vectors {
  using Values __attribute__((vector_size(8 * width))) = double;
  using Flags __attribute__((vector_size(8 * width))) = std::int64_t;
};

/// flags ? if_so : otherwise, lane by lane. The conditions of the compilers' extensions are what g++ 12 takes apart
/// where a function has other instructions than its file.
template <class Flags, class Values>
CALOR_ALWAYS_INLINE inline Values chosen(Flags flags, Values if_so, Values otherwise) {
  return (Values)(((Flags)if_so & flags) | ((Flags)otherwise & ~flags));
}
CALOR_ALWAYS_INLINE inline double chosen(bool flag, double if_so, double otherwise) { return flag ? if_so : otherwise; }

/// Square roots, lane by lane: of whole vectors in files that are compiled with -fno-math-errno.
template <class Values>
CALOR_ALWAYS_INLINE inline Values root(Values x) {
  for (std::size_t lane = 0; lane < sizeof(Values) / sizeof(double); ++lane) x[lane] = std::sqrt(x[lane]);
  return x;
}
CALOR_ALWAYS_INLINE inline double root(double x) { return std::sqrt(x); }

}  // namespace calor
