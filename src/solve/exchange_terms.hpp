#pragma once
// Heat exchanged with what is outside the conduction of the body, as heat terms: surface fluxes and sources.
#include <memory>
#include <vector>

#include "boundary/conditions.hpp"
#include "conduction/heat_term.hpp"
#include "source/source.hpp"

namespace calor {

/// F_i += area q(x, t, T(x_i)) of every facet. The surface term must outlive it.
class SurfaceFluxTerm final : public HeatTerm {
 public:
  explicit SurfaceFluxTerm(const SurfaceTerm& term) : term_(term) {}
  void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void add_row_sums(Evaluation& at, std::span<double> sums) override;
  Traits traits() const override;
  Changes changes() const override { return term_.flux->changes(); }

 private:
  /// Fills q_ and, if wanted, dq_dT_.
  void evaluate(Evaluation& at, bool derivative);

  const SurfaceTerm& term_;
  std::vector<double> T_, q_, dq_dT_;
};

/// F_i += power of the source into the cell of point i. The source must outlive it.
class SourceTerm final : public HeatTerm {
 public:
  /// `account`: the index of the source among all accounts.
  SourceTerm(Source& source, int account) : source_(source), account_(account) {}
  void prepare(double t) override { source_.prepare(t); }
  void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void add_row_sums(Evaluation& at, std::span<double> sums) override;
  Traits traits() const override { return {.is_constant = !source_.depends_on_temperature()}; }
  Changes changes() const override { return source_.changes(); }

 private:
  std::span<const double> derivative(Evaluation& at);

  Source& source_;
  int account_;
  std::vector<double> derivative_;
};

}  // namespace calor
