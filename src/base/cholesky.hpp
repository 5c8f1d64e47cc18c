#pragma once
// Cholesky's factorisation of matrices so small that loops of known length are faster than a library, in machine code
// and to compile.
#include <array>

#include "base/lanes.hpp"

namespace calor {

/// Of one matrix, Real = double, or of one in every lane of Doubles.
template <int n, class Real = double>
class Cholesky {
 public:
  using Vector = std::array<Real, n>;

  /// Of the symmetric A, by its entries A[i][j], j <= i.
  CALOR_ALWAYS_INLINE explicit Cholesky(const std::array<Vector, n>& A) : L_(A) {
    Real least = L_[0][0], largest = L_[0][0];
    for (int j = 0; j < n; ++j) {
      Real pivot = L_[j][j];
      for (int k = 0; k < j; ++k) pivot -= L_[j][k] * L_[j][k];
      least = chosen(least <= pivot, least, pivot);  // NaN, which follows a pivot that is not positive, stays
      largest = chosen(largest < pivot, pivot, largest);
      L_[j][j] = 1 / root(pivot);
      for (int i = j + 1; i < n; ++i) {
        Real sum = L_[i][j];
        for (int k = 0; k < j; ++k) sum -= L_[i][k] * L_[j][k];
        L_[i][j] = sum * L_[j][j];
      }
    }
    pivot_ratio_ = least / largest;
  }

  /// The least pivot over the largest. Where A is not positive definite it is not positive, or NaN, and there is no
  /// factor.
  CALOR_ALWAYS_INLINE Real pivot_ratio() const { return pivot_ratio_; }

  /// b becomes A^-1 b.
  CALOR_ALWAYS_INLINE void solve(Vector& b) const {
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k) b[i] -= L_[i][k] * b[k];
      b[i] *= L_[i][i];
    }
    for (int i = n; i-- > 0;) {
      for (int k = i + 1; k < n; ++k) b[i] -= L_[k][i] * b[k];
      b[i] *= L_[i][i];
    }
  }

 private:
  std::array<Vector, n> L_;  ///< 1 / L_ii on the diagonal
  Real pivot_ratio_;
};

}  // namespace calor
