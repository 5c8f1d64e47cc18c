#pragma once
// What is integrated over cells and facets.
#include <functional>
#include <span>

#include "base/vec3.hpp"

namespace calor {

/// Part of a function's scale that is nothing beside it.
constexpr double negligible = 1e-7;

/// A function of place, asked for whole arrays: out[n] = f(x[n]).
struct Integrand {
  std::function<void(std::span<const Vec3> x, std::span<double> out)> f;
  bool may_jump = true;  ///< false: smooth wherever it is asked, so that nobody looks for jumps
  /// For functions that are integrated again and again: cells of lattices in which two cheap rules agree to 3e-5 of the
  /// scale are done, and those whose corners and point or middle have only what is negligible beside it.
  bool quick = false;
  double scale = 0;  ///< the largest |f| that counts in the body: what is tiny beside it needs no digits
};

}  // namespace calor
