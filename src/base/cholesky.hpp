#pragma once
// Cholesky's factorisation of matrices so small that loops of known length are faster than a library, in machine code
// and to compile.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace calor {

template <int n>
class Cholesky {
 public:
  using Vector = std::array<double, n>;

  /// Of the symmetric A, by its entries A[i][j], j <= i.
  explicit Cholesky(const std::array<Vector, n>& A) : L_(A) {
    double least = std::numeric_limits<double>::infinity(), largest = 0;
    for (int j = 0; j < n; ++j) {
      double pivot = L_[j][j];
      for (int k = 0; k < j; ++k) pivot -= L_[j][k] * L_[j][k];
      if (!(pivot > 0)) return;
      least = std::min(least, pivot), largest = std::max(largest, pivot);
      L_[j][j] = 1 / std::sqrt(pivot);
      for (int i = j + 1; i < n; ++i) {
        double sum = L_[i][j];
        for (int k = 0; k < j; ++k) sum -= L_[i][k] * L_[j][k];
        L_[i][j] = sum * L_[j][j];
      }
    }
    pivot_ratio_ = least / largest;
  }

  /// The least pivot over the largest; 0: A is not positive definite, and there is no factor.
  double pivot_ratio() const { return pivot_ratio_; }

  /// b becomes A^-1 b.
  void solve(Vector& b) const {
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
  double pivot_ratio_ = 0;
};

}  // namespace calor
