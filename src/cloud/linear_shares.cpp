#include "cloud/linear_shares.hpp"

#include <Eigen/Cholesky>

namespace calor {

void LinearShares::add(std::int64_t id, const Vec3& way, double square) {
  const double inside = 1 - square / (radius * radius);
  if (!(inside > 0)) return;
  ids.push_back(id), value.push_back(inside * inside * inside * inside), way_.push_back(way);
}

std::optional<std::array<double, 4>> LinearShares::coefficients(const std::array<double, moments>& sums, int D) {
  Eigen::Matrix4d M;
  std::size_t n = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b) M(a, b) = M(b, a) = sums[n++];
  for (int a = D; a < 3; ++a) M(1 + a, 1 + a) = 1;
  const Eigen::LLT<Eigen::Matrix4d> factor(M);
  constexpr double least_pivot = 1e-2;  // of the largest: below, small weights would make large shares of both signs
  const auto pivots = factor.matrixLLT().diagonal();
  if (factor.info() != Eigen::Success || !(pivots.minCoeff() > least_pivot * pivots.maxCoeff())) return std::nullopt;
  const Eigen::Vector4d c = factor.solve(Eigen::Vector4d::UnitX());
  return std::array<double, 4>{c[0], c[1], c[2], c[3]};
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
