#pragma once
#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "output/observer.hpp"
#include "solve/integrator.hpp"

namespace calor {

/// Gathers the rows of derivatives.csv: one a time and parameter, one column a reading. It is written at the end.
class DerivativeLog : public Observer {
 public:
  DerivativeLog(const RunSetup& run, const Model& model, std::vector<Parameter> parameters)
      : run_(run),
        model_(model),
        parameters_(std::move(parameters)),
        readings_(run.description, run.probes, run.system, run.weld, run.stress) {}

  /// Refuses to go on from a checkpoint: the derivatives have not been stored.
  void exchange(Archive& archive) override;
  void finish(const Moment& m, RunResult& result) override;

 protected:
  void add(double t, const Parameter& p, const std::vector<double>& derivatives);

  const RunSetup& run_;
  const Model& model_;
  std::vector<Parameter> parameters_;
  Readings readings_;

 private:
  std::string rows_;
};

/// By the tangent or the adjoint of a steady state.
std::unique_ptr<Observer> make_steady_derivatives(const RunSetup& run, const Model& model,
                                                  std::vector<Parameter> parameters);
/// By the tangents of the steps; the integrator tells of them. Null where it cannot. Collective; throws Error.
std::unique_ptr<Observer> make_step_tangents(const RunSetup& run, const Model& model, std::vector<Parameter> parameters,
                                             Integrator& integrator);

}  // namespace calor
