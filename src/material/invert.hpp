#pragma once
// Temperatures from enthalpies, many at a time.
#include <functional>
#include <span>

namespace calor {

/// f(T, H, dH_dT): H(T) of point i at T[i], strictly increasing in T.
using Increasing = std::function<void(std::span<const double> T, std::span<double> H, std::span<double> dH_dT)>;

/// Solves H_i(T_i) = H[i] by Newton's method within a bracket, to 1e-13 of |T|. T holds a guess on entry; at most 1024
/// points. Returns -1, or the first point for which there is no solution (or dH/dT is not positive on the way), with
/// the last T tried.
int invert_increasing(const Increasing& f, std::span<const double> H, std::span<double> T);

}  // namespace calor
