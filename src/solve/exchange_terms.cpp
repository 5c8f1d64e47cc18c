#include "solve/exchange_terms.hpp"

#include <cmath>

namespace calor {

void SurfaceFluxTerm::evaluate(Evaluation& at, bool derivative) {
  const std::size_t n = term_.point.size();
  T_.resize(n), q_.resize(n), dq_dT_.resize(derivative ? n : 0);
  if (n == 0) return;
  for (std::size_t p = 0; p < n; ++p) T_[p] = at.T(term_.point[p]);
  term_.flux->evaluate({.x = term_.x, .t = at.t(), .T = T_}, q_, dq_dT_);
}

void SurfaceFluxTerm::add_rate(Evaluation& at, std::span<double> F, std::span<double> power) {
  evaluate(at, false);
  double total = 0;
  for (std::size_t p = 0; p < q_.size(); ++p) {
    const double heat = q_[p] * term_.area[p];
    F[term_.point[p]] += heat;
    total += heat;
  }
  power[term_.account] += total;
}

void SurfaceFluxTerm::add_jacobian(Evaluation& at, JacobianEntries& J) {
  if (!term_.flux->depends_on_temperature()) return;
  evaluate(at, true);
  for (std::size_t p = 0; p < q_.size(); ++p) J.add_nodal(term_.point[p], dq_dT_[p] * term_.area[p]);
}

void SurfaceFluxTerm::add_row_sums(Evaluation& at, std::span<double> sums) {
  if (!term_.flux->depends_on_temperature()) return;
  evaluate(at, true);
  for (std::size_t p = 0; p < q_.size(); ++p) sums[term_.point[p]] += std::abs(dq_dT_[p] * term_.area[p]);
}

Traits SurfaceFluxTerm::traits() const {
  const SurfaceFlux& flux = *term_.flux;
  if (!flux.depends_on_temperature()) return {};
  return {.is_constant = flux.linear_in_temperature() && !flux.derivative_depends_on_time(),
          .fixes_level = !term_.point.empty()};
}

void SourceTerm::add_rate(Evaluation& at, std::span<double> F, std::span<double> power) {
  power[account_] += source_.add_power(at.t(), at.T(), F);
}

std::span<const double> SourceTerm::derivative(Evaluation& at) {
  derivative_.assign(at.T().size(), 0);
  source_.add_derivative(at.t(), at.T(), derivative_);
  return derivative_;
}

void SourceTerm::add_jacobian(Evaluation& at, JacobianEntries& J) {
  if (!source_.depends_on_temperature()) return;
  const std::span<const double> dP_dT = derivative(at);
  for (std::size_t i = 0; i < dP_dT.size(); ++i)
    if (dP_dT[i] != 0) J.add_nodal(static_cast<int>(i), dP_dT[i]);
}

void SourceTerm::add_row_sums(Evaluation& at, std::span<double> sums) {
  if (!source_.depends_on_temperature()) return;
  const std::span<const double> dP_dT = derivative(at);
  for (std::size_t i = 0; i < dP_dT.size(); ++i) sums[i] += std::abs(dP_dT[i]);
}

}  // namespace calor
