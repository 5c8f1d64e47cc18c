#include "conduction/evaluation.hpp"

#include <algorithm>
#include <utility>

namespace calor {

void Coefficients::begin(double t, std::span<const double> u, bool frozen) {
  t_ = t, u_ = u, frozen_ = frozen;
  has_T_ = has_dk_dT_ = has_theta_ = false;
  has_k_ = has_k_ && !material_->conductivity_depends_on_T() && !material_->conductivity_depends_on_time();
}

std::span<const double> Coefficients::T() {
  if (!phi_) return u_;
  if (!std::exchange(has_T_, true)) {
    T_buffer_.resize(phi_->count());
    phi_->apply(u_, T_buffer_);
  }
  return T_buffer_;
}

std::span<const double> Coefficients::k() {
  if (!has_k_) {
    const std::span<const double> at = T();
    k_.resize(at.size());
    material_->conductivity(t_, at, k_, {});
    has_k_ = true;
  }
  return k_;
}

std::span<const double> Coefficients::dk_dT() {
  if (frozen_ || !material_->conductivity_depends_on_T()) return {};
  if (!has_dk_dT_) {
    const std::span<const double> at = T();
    k_.resize(at.size()), dk_dT_.resize(at.size());
    material_->conductivity(t_, at, k_, dk_dT_);
    has_k_ = has_dk_dT_ = true;
  }
  return dk_dT_;
}

Conductivity Coefficients::at_ends(Purpose purpose) {
  const Mean mean = material_->mean() == Mean::harmonic ? Mean::harmonic : Mean::arithmetic;
  return {
      .mean = mean, .k = k(), .dk_dT = purpose == Purpose::jacobian ? dk_dT() : std::span<const double>(), .theta = {}};
}

Conductivity Coefficients::conductivity(Purpose purpose) {
  const Mean mean = phi_ ? Mean::arithmetic : material_->mean();
  if (mean == Mean::integral && purpose == Purpose::rate) {
    if (!has_theta_) {
      const std::span<const double> at = T();
      theta_.resize(at.size());
      material_->theta(at, theta_);
      has_theta_ = true;
    }
    return {.mean = mean, .k = {}, .dk_dT = {}, .theta = theta_};
  }
  // Differences of theta have no term in dk/dT.
  const bool with_derivative = purpose == Purpose::jacobian && mean != Mean::integral;
  const std::span<const double> derivative = with_derivative ? dk_dT() : std::span<const double>();
  return {.mean = mean, .k = k(), .dk_dT = derivative, .theta = {}};
}

Evaluation::Evaluation(const Dofs& dofs, std::vector<Coefficients> locations)
    : dofs_(dofs), locations_(std::move(locations)), has_begun_(locations_.size()) {}

void Evaluation::begin(double t, std::span<const double> u, bool frozen) {
  t_ = t, u_ = u, frozen_ = frozen, has_T_ = false;
  std::ranges::fill(has_begun_, 0);
}

std::span<const double> Evaluation::T() {
  if (dofs_.are_temperatures()) return u_.first(dofs_.owned());
  if (!std::exchange(has_T_, true)) {
    T_.resize(dofs_.owned());
    dofs_.temperatures(u_, T_);
  }
  return T_;
}

double Evaluation::T(int i) const {
  if (has_T_) return T_[i];
  return dofs_.are_temperatures() ? u_[i] : dofs_.phi().times(i, u_);
}

Coefficients& Evaluation::at(Location location) {
  Coefficients& here = locations_[location];
  if (!std::exchange(has_begun_[location], 1)) {
    const bool by_temperature = location == nodes && !dofs_.are_temperatures();
    here.begin(t_, by_temperature ? T() : u_, frozen_);
  }
  return here;
}

}  // namespace calor
