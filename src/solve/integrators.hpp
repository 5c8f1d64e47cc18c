#pragma once
// The integrators, one file each.
#include <memory>

#include "solve/stepper.hpp"

namespace calor {

/// Explicit Euler; the only transient one that knows algebraic walls.
std::unique_ptr<Integrator> make_euler(const StepOptions& options);
/// Super-time-stepping of second order (Meyer, Balsara & Aslam 2014).
std::unique_ptr<Integrator> make_rkl2(const StepOptions& options);
/// Fixed steps.
std::unique_ptr<Integrator> make_backward_euler(const StepOptions& options);
/// Fixed steps; the first two after a start or a jump are four half steps of backward Euler (Rannacher 1984).
std::unique_ptr<Integrator> make_crank_nicolson(const StepOptions& options);
/// Trapezoidal rule and BDF2 in one step, with an embedded error (Hosea & Shampine 1996).
std::unique_ptr<Integrator> make_tr_bdf2(const StepOptions& options);

}  // namespace calor
