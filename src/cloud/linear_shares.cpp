#include "cloud/linear_shares.hpp"

#include "base/cholesky.hpp"

namespace calor {

void LinearShares::add(std::int64_t id, const Vec3& way, double square) {
  const double inside = 1 - square / (radius * radius);
  if (!(inside > 0)) return;
  ids.push_back(id), value.push_back(inside * inside * inside * inside), way_.push_back(way);
}

std::optional<std::array<double, 4>> LinearShares::coefficients(const std::array<double, moments>& sums, int D) {
  using Moments = Cholesky<4>;
  std::array<Moments::Vector, 4> M{};
  for (int a = 0, n = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b) M[b][a] = sums[n++];
  for (int a = D; a < 3; ++a) M[1 + a][1 + a] = 1;
  constexpr double least_ratio = 1e-4;  // of pivots: below, small weights would make large shares of both signs
  const Moments factor(M);
  if (!(factor.pivot_ratio() > least_ratio)) return std::nullopt;
  Moments::Vector c = {1, 0, 0, 0};
  factor.solve(c);
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
