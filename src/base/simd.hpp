#pragma once
// Vectors of doubles for the few loops that take most of the time, and the instruction sets these loops are compiled
// for. One binary serves all machines: it holds every such loop once for each set, and takes the best that the
// processor has. Results of different sets differ by rounding alone (fused multiply-add).
#include <cstdint>

// Vectors never cross a call: what takes or returns them is always inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

/// For what a loop with vectors is made of: a call would leave the instruction set of its caller.
#define CALOR_ALWAYS_INLINE __attribute__((always_inline))

// A build for one kind of processor (-march=...) has nothing to choose from.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__AVX__)
#define CALOR_CHOOSES_INSTRUCTION_SET 1
#else
#define CALOR_CHOOSES_INSTRUCTION_SET 0
#endif

namespace calor {

/// `width` doubles, as the compilers' vector extensions have them.
template <int width>
using Doubles __attribute__((vector_size(8 * width))) = double;
/// The same anywhere in memory.
template <int width>
using UnalignedDoubles __attribute__((vector_size(8 * width), aligned(8), may_alias)) = double;

/// Loads of the `width` values p[first], p[first + 1], ...
template <int width>
struct Consecutive {
  std::int64_t first;
  CALOR_ALWAYS_INLINE Doubles<width> operator()(const double* p) const {
    return *reinterpret_cast<const UnalignedDoubles<width>*>(p + first);
  }
};

/// Loads of the `width` values p[index[0]], p[index[1]], ...
template <int width>
struct Gathered {
  const std::int32_t* index;
  CALOR_ALWAYS_INLINE Doubles<width> operator()(const double* p) const {
    Doubles<width> v;
    for (int lane = 0; lane < width; ++lane) v[lane] = p[index[lane]];
    return v;
  }
};

/// What a binary that chooses can choose from, in the order of their speed.
enum class InstructionSet { baseline, avx2, avx512 };

/// The best that the compiler and this processor have.
InstructionSet best_instruction_set();
const char* name_of(InstructionSet set);

/// Vectors of the baseline: what the whole program is compiled for.
#if defined(__AVX512F__)
inline constexpr int baseline_width = 8;
#elif defined(__AVX__)
inline constexpr int baseline_width = 4;
#else
inline constexpr int baseline_width = 2;
#endif

#if CALOR_CHOOSES_INSTRUCTION_SET
template <class Loop>
[[gnu::target("avx512f,avx512vl,avx512dq,fma")]] void run_with_avx512(const Loop& loop) {
  loop.template operator()<8>();
}
template <class Loop>
[[gnu::target("avx2,fma")]] void run_with_avx2(const Loop& loop) {
  loop.template operator()<4>();
}
#endif

/// Calls loop.operator()<width>(), which must be CALOR_ALWAYS_INLINE, compiled for an instruction set that this
/// processor has.
template <class Loop>
void run_vectorised(const Loop& loop, [[maybe_unused]] InstructionSet set = best_instruction_set()) {
#if CALOR_CHOOSES_INSTRUCTION_SET
  if (set == InstructionSet::avx512) return run_with_avx512(loop);
  if (set == InstructionSet::avx2) return run_with_avx2(loop);
#endif
  loop.template operator()<baseline_width>();
}

}  // namespace calor
