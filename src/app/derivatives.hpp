#pragma once
// derivatives.csv: what temperatures of probes and numbers of the report change by with numbers of the case.
#include <memory>

#include "app/model.hpp"
#include "output/observer.hpp"
#include "output/probes.hpp"
#include "solve/integrator.hpp"

namespace calor {

/// What [output] derivatives asks for; null where it asks for nothing. `integrator`: null of a steady state. All
/// outlive it. Collective; throws Error.
std::unique_ptr<Observer> make_derivative_log(const RunSetup& run, const Model& model, Integrator* integrator);

/// Refuses what it asks for and cannot have. Collective; throws Error.
void check_derivatives(const RunSetup& run, Integrator* integrator);

}  // namespace calor
