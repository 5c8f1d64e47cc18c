#include "cloud/linear_shares.hpp"

#include <Eigen/Cholesky>

namespace calor {

void LinearShares::add(std::int64_t id, const Vec3& way, double square) {
  const double inside = 1 - square / (radius * radius);
  if (!(inside > 0)) return;
  ids.push_back(id), value.push_back(inside * inside * inside * inside), way_.push_back(way);
}

bool LinearShares::solve(int D) {
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  for (std::size_t n = 0; n < ids.size(); ++n) {
    const Eigen::Vector4d p(1, way_[n].x, way_[n].y, way_[n].z);
    moments.noalias() += value[n] * p * p.transpose();
  }
  for (int a = D; a < 3; ++a) moments(1 + a, 1 + a) = 1;
  const Eigen::LLT<Eigen::Matrix4d> factor(moments);
  constexpr double least_pivot = 1e-2;  // of the largest: below, small weights would make large shares of both signs
  const auto pivots = factor.matrixLLT().diagonal();
  if (factor.info() != Eigen::Success || !(pivots.minCoeff() > least_pivot * pivots.maxCoeff())) {
    clear();
    return false;
  }
  const Eigen::Vector4d c = factor.solve(Eigen::Vector4d::UnitX());
  for (std::size_t n = 0; n < ids.size(); ++n)
    value[n] *= c[0] + c[1] * way_[n].x + c[2] * way_[n].y + c[3] * way_[n].z;
  return true;
}

}  // namespace calor
