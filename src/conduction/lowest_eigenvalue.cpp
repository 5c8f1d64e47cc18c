// Do weights of pairs let differences of temperature decay? With negative weights they may grow.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "conduction/correction.hpp"

namespace calor {
namespace {

/// S^-1/2 L S^-1/2 with (L u)_i = sum_j G_ij (u_i - u_j) and S_i = sum_j |G_ij|: its eigenvalues lie between -2 and 2.
class ScaledConduction {
 public:
  ScaledConduction(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G)
      : cloud_(cloud), neighbours_(neighbours), G_(G), scale_(cloud.owned), u_(cloud.local()) {
    for (int i = 0; i < cloud.owned; ++i) {
      double size = 0;
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) size += std::abs(G[n]);
      scale_[i] = size > 0 ? 1 / std::sqrt(size) : 0;
    }
  }

  void multiply(std::span<const double> v, std::span<double> out) {
    for (int i = 0; i < cloud_.owned; ++i) u_[i] = scale_[i] * v[i];
    cloud_.halo.update(std::span<double>(u_));
    for (int i = 0; i < cloud_.owned; ++i) {
      double sum = 0;
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n)
        sum += G_[n] * (u_[i] - u_[neighbours_.column[n]]);
      out[i] = scale_[i] * sum;
    }
  }

 private:
  const Cloud& cloud_;
  const Neighbours& neighbours_;
  std::span<const double> G_;
  std::vector<double> scale_, u_;
};

}  // namespace

double lowest_eigenvalue(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G) {
  constexpr int most_steps = 100;
  ScaledConduction S(cloud, neighbours, G);
  const auto owned = static_cast<std::size_t>(cloud.owned);
  std::vector<double> v(owned), last(owned), next(owned), diagonal, beside;
  for (std::size_t i = 0; i < owned; ++i) v[i] = hashed_uniform(1, cloud.id[i]).x - 0.5;
  double size = std::sqrt(dot(cloud.comm, v, v));
  for (int step = 0; step < std::min<std::int64_t>(most_steps, cloud.count) && size > 1e-10; ++step) {
    for (double& value : v) value /= size;
    S.multiply(v, next);
    const double along = dot(cloud.comm, v, next);
    for (std::size_t i = 0; i < owned; ++i) next[i] -= along * v[i] + (step > 0 ? size : 0) * last[i];
    if (step > 0) beside.push_back(size);
    diagonal.push_back(along);
    std::swap(last, v), std::swap(v, next);
    size = std::sqrt(dot(cloud.comm, v, v));
  }
  const auto vector = [](const std::vector<double>& x) {
    return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  };
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
  eigen.computeFromTridiagonal(vector(diagonal), vector(beside), Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0];
}

}  // namespace calor
