#pragma once
// What is integrated over cells and facets.
#include <functional>
#include <span>

#include "base/vec3.hpp"

namespace calor {

/// A function of place, asked for whole arrays: out[n] = f(x[n]).
struct Integrand {
  std::function<void(std::span<const Vec3> x, std::span<double> out)> f;
  bool may_jump = true;  ///< false: smooth wherever it is asked, so that nobody looks for jumps
  /// For functions that are integrated again and again: where the corners and the middle of a lattice's cell have less
  /// than 1e-9 of the scale, nothing more is looked for.
  bool quick = false;
  double scale = 0;  ///< the largest |f| that counts in the body: what is tiny beside it needs no digits
};

}  // namespace calor
