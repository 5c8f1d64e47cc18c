#include "cloud/linear_shares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace calor {

void LinearShares::add(std::int64_t id, const Vec3& way, double square) {
  const double inside = 1 - square / (radius * radius);
  if (!(inside > 0)) return;
  ids.push_back(id), value.push_back(inside * inside * inside * inside), way_.push_back(way);
}

std::optional<std::array<double, 4>> LinearShares::coefficients(const std::array<double, moments>& sums, int D) {
  // Cholesky's factor L of the moment matrix, by loops of known length.
  constexpr int n = 4;
  double L[n][n] = {};
  for (int a = 0, m = 0; a < n; ++a)
    for (int b = a; b < n; ++b) L[b][a] = sums[m++];
  for (int a = D; a < 3; ++a) L[1 + a][1 + a] = 1;
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  for (int k = 0; k < n; ++k) {
    for (int m = 0; m < k; ++m) L[k][k] -= L[k][m] * L[k][m];
    if (!(L[k][k] > 0)) return std::nullopt;
    L[k][k] = std::sqrt(L[k][k]);
    least = std::min(least, L[k][k]), largest = std::max(largest, L[k][k]);
    for (int i = k + 1; i < n; ++i) {
      for (int m = 0; m < k; ++m) L[i][k] -= L[i][m] * L[k][m];
      L[i][k] /= L[k][k];
    }
  }
  constexpr double least_pivot = 1e-2;  // of the largest: below, small weights would make large shares of both signs
  if (!(least > least_pivot * largest)) return std::nullopt;
  std::array<double, 4> c = {1, 0, 0, 0};
  for (int i = 0; i < n; ++i) {
    for (int m = 0; m < i; ++m) c[i] -= L[i][m] * c[m];
    c[i] /= L[i][i];
  }
  for (int i = n; i-- > 0;) {
    for (int m = i + 1; m < n; ++m) c[i] -= L[m][i] * c[m];
    c[i] /= L[i][i];
  }
  return c;
}

bool LinearShares::solve(int D) {
  std::array<double, moments> sums{};
  for (std::size_t n = 0; n < ids.size(); ++n) {
    const std::array<double, 4> p = {1, way_[n].x, way_[n].y, way_[n].z};
    std::size_t m = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = a; b < 4; ++b) sums[m++] += value[n] * p[a] * p[b];
  }
  const auto c = coefficients(sums, D);
  if (!c) {
    clear();
    return false;
  }
  for (std::size_t n = 0; n < ids.size(); ++n)
    value[n] *= (*c)[0] + (*c)[1] * way_[n].x + (*c)[2] * way_[n].y + (*c)[3] * way_[n].z;
  return true;
}

}  // namespace calor
