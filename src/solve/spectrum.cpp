// Bounds of the spectrum of the heat system, for explicit steps.

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "solve/heat_system.hpp"

namespace calor {
namespace {

/// Neighbours differ in sign or size, as in the fastest modes; the same on any number of ranks.
double start_value(const Cloud& cloud, int i) {
  return std::sin(1.0 + 12.9898 * static_cast<double>(cloud.id[i] % 100003));
}

}  // namespace

double HeatSystem::rate_bound(double t, std::span<double> u) { return largest_rate_of_rows(t, u, 1, {}); }

double HeatSystem::largest_rate_of_rows(double t, std::span<double> u, double exchange_factor,
                                        std::span<const double> unit) {
  std::vector<double> sums(cloud_.owned), C(cloud_.owned);
  cloud_.halo.update(u);
  at_->begin(t, u);
  collective_try(cloud_.comm, [&] {
    discretisation_.capacity->evaluate(*at_, {}, C);
    for (const auto& term : exchange_) term->add_row_sums(*at_, sums);
    for (const auto& term : discretisation_.walls) term->add_row_sums(*at_, sums);
    for (double& sum : sums) sum *= exchange_factor;
    discretisation_.conduction->add_row_sums(*at_, sums);
  });
  double largest = 0;
  for (int i = 0; i < cloud_.owned; ++i)
    if (role_[i] == Role::free) largest = std::max(largest, sums[i] / C[i] / (unit.empty() ? 1 : unit[i]));
  return max(cloud_.comm, largest);
}

double HeatSystem::explicit_rate_bound(double t, std::span<double> u, double exchange_factor) {
  if (discretisation_.dofs->are_temperatures()) return largest_rate_of_rows(t, u, exchange_factor, {});
  if (!uniform_body_) uniform_body_ = rates_of_uniform_body();
  return uniform_body_->largest * largest_rate_of_rows(t, u, exchange_factor, uniform_body_->of_row);
}

double HeatSystem::euler_limit(double t, std::span<double> u) {
  const double rate = frozen_jacobian_is_symmetric() ? largest_rate(t, u) : rate_bound(t, u);
  return 2 / (discretisation_.dofs->are_temperatures() ? rate : std::max(rate, explicit_rate_bound(t, u)));
}

HeatSystem::UniformBody HeatSystem::rates_of_uniform_body() {
  std::size_t most = cloud_.x.size();
  for (const QuadraturePoints* points : discretisation_.locations) most = std::max(most, points->x.size());
  const std::vector<double> one(most, 1.0);
  const Conductivity k{.mean = Mean::arithmetic, .k = one, .dk_dT = {}, .theta = {}};
  const Conduction& conduction = *discretisation_.conduction;
  std::vector<double> v(cloud_.owned), F(cloud_.owned), u(cloud_.local());
  UniformBody body{.of_row = std::vector<double>(cloud_.owned)};
  conduction.add_row_sums(k, body.of_row);
  for (int i = 0; i < cloud_.owned; ++i) body.of_row[i] /= cloud_.volume[i];
  double before = 0, now = 0;
  constexpr int steps = 100;  // of the power iteration
  constexpr double settled = 1e-3, margin = 1.05;
  for (int i = 0; i < cloud_.owned; ++i) v[i] = role_[i] == Role::free ? start_value(cloud_, i) : 0;
  for (int step = 0; step < steps; ++step) {
    const double length = std::sqrt(dot(cloud_.comm, v, v));
    if (!(length > 0)) break;
    for (double& value : v) value /= length;
    std::ranges::fill(u, 0);
    discretisation_.dofs->add(v, u);
    cloud_.halo.update(std::span<double>(u));
    std::ranges::fill(F, 0);
    conduction.add_rate(k, u, F);
    for (int i = 0; i < cloud_.owned; ++i) v[i] = role_[i] == Role::free ? -F[i] / cloud_.volume[i] : 0;
    before = std::exchange(now, std::sqrt(dot(cloud_.comm, v, v)));
    if (std::abs(now - before) < settled * now / steps) break;
  }
  body.largest = margin * now;
  return body;
}

double HeatSystem::largest_rate(double t, std::span<double> u) {
  // Lanczos on S = D^-1 C^-1/2 (-dF/du) C^-1/2 D, where D = k^-1/2 makes the integral mean's G_ij k_j symmetric, from a
  // start vector that excites free points alone: walls are frozen.
  constexpr int most_steps = 200;
  constexpr double tolerance = 1e-4;
  std::vector<double> C(cloud_.owned), scale(cloud_.owned, 1), v(cloud_.owned), before(cloud_.owned), w(cloud_.owned);
  capacity(u, C);
  const petsc::Matrix J = create_jacobian();
  assemble(t, u, 0, 1, true, J);
  if (material().mean() == Mean::integral)
    collective_try(cloud_.comm, [&] {
      const std::span<const double> k = at_->at(Evaluation::nodes).k();
      for (int i = 0; i < cloud_.owned; ++i) scale[i] = k[i] > 0 ? 1 / std::sqrt(k[i]) : 1;
    });
  for (int i = 0; i < cloud_.owned; ++i) v[i] = role_[i] == Role::free ? start_value(cloud_, i) : 0;
  const petsc::Vector x = petsc::create_vector(J), y = petsc::create_vector(J);
  const auto multiply = [&](const std::vector<double>& from, std::vector<double>& to) {
    for (int i = 0; i < cloud_.owned; ++i) to[i] = role_[i] == Role::free ? from[i] * scale[i] / std::sqrt(C[i]) : 0;
    petsc::copy(to, x);
    petsc::check(MatMult(J, x, y));
    petsc::copy(y, to);
    for (int i = 0; i < cloud_.owned; ++i) to[i] = role_[i] == Role::free ? to[i] / (scale[i] * std::sqrt(C[i])) : 0;
  };

  std::vector<double> alpha, beta;
  double largest = 0;
  double length = std::sqrt(dot(cloud_.comm, v, v));
  for (int step = 0; step < most_steps && length > 0; ++step) {
    for (double& value : v) value /= length;
    multiply(v, w);
    alpha.push_back(dot(cloud_.comm, v, w));
    for (int i = 0; i < cloud_.owned; ++i) {
      w[i] -= alpha.back() * v[i] + (beta.empty() ? 0 : beta.back()) * before[i];
      before[i] = v[i];
      v[i] = w[i];
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> tridiagonal;
    tridiagonal.computeFromTridiagonal(Eigen::Map<Eigen::VectorXd>(alpha.data(), alpha.size()),
                                       Eigen::Map<Eigen::VectorXd>(beta.data(), beta.size()), Eigen::EigenvaluesOnly);
    const double last = largest;
    largest = tridiagonal.eigenvalues().maxCoeff();
    length = std::sqrt(dot(cloud_.comm, v, v));
    if (step > 20 && largest - last < tolerance * largest * 0.01) break;
    if (length < 1e-10 * largest) break;
    beta.push_back(length);
  }
  return largest;
}

}  // namespace calor
