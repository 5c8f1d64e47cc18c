#pragma once
// Newton's method (SNES) for equations between the temperatures of the owned points: the steady state and the stages of
// implicit integrators. The options of PETSc are heeded, with the prefix "heat_".
#include <exception>
#include <functional>
#include <span>
#include <vector>

#include "base/petsc.hpp"
#include "solve/heat_system.hpp"
#include "solve/jacobian_operator.hpp"

namespace calor {

class Archive;

class Newton {
 public:
  struct Equations {
    /// R(T) of the owned points; T covers the local points.
    std::function<void(std::span<double> T, std::span<double> R)> residual;
    /// dR/dT.
    std::function<void(std::span<double> T, JacobianOperator& J)> jacobian;
    /// What of R counts as nothing near T, and what rounding alone may leave of it; both come in as zeros.
    std::function<void(std::span<double> T, std::span<double> tolerance, std::span<double> round_off)> tolerance;
    /// Corrects Newton's step from T, of the owned points: dT in, dT out. May be empty.
    std::function<void(std::span<double> T, std::span<double> dT)> correct_step = {};
    bool residual_may_grow = false;  ///< in a corrected step, before it falls
  };
  struct Result {
    bool converged = false;
    bool at_round_off = false;  ///< converged there, short of the tolerance
    int iterations = 0;
    long linear_iterations = 0;
    double residual = 0;             ///< largest |R_i| / tolerance_i
    std::exception_ptr reason = {};  ///< of no convergence: the last error of the equations, if any
  };

  /// `steady` equations are worse conditioned than the stages of a time step, and the first guess may be far away: the
  /// Jacobian stays while the residual falls well, and linear equations are solved no better than that asks for.
  /// Collective.
  Newton(HeatSystem& system, Equations equations, bool steady);
  Newton(const Newton&) = delete;
  Newton& operator=(const Newton&) = delete;

  /// From the first guess T to |R_i| <= tolerance_i everywhere, or to where R falls no further and is round-off. `size`
  /// tells about how large the entries of the Jacobian are, on all ranks alike; that of the first call counts. Errors
  /// of the equations at T itself are passed on; at later iterates they shorten the step. Collective.
  Result solve(std::span<double> T, int most_iterations, double size);

  /// The Jacobian stays as it is until this is called.
  void renew_jacobian() { jacobian_is_old_ = true; }
  /// Data have jumped: nothing of it is kept.
  void forget_jacobian() { J_.forget(), renew_jacobian(); }
  /// From now on every step is shortened until the residual falls, whatever the equations say of it; or no longer.
  /// Slow, but it comes to an end where Newton's steps jump to and fro, as over the switching of a thermostat.
  void go_carefully(bool yes);
  /// Whether the Jacobian is symmetric as the equations of a steady state scale it: what iterates on it.
  void take_as_symmetric(bool yes);
  /// When convergence slows down, and in every iteration of a problem with `always_renew`.
  void always_renew(bool yes) { always_renew_ = yes; }

  /// What is kept from solve to solve. For reading, the Jacobian is evaluated anew where it was. Collective.
  void exchange(Archive& archive);

  /// x = J^-1 b with the last Jacobian, owned points; iterations end at that part of |b|. Collective.
  void solve_linear(std::span<const double> b, std::span<double> x, double tolerance);

 private:
  static PetscErrorCode residual(SNES snes, Vec T, Vec R, void* self);
  static PetscErrorCode jacobian(SNES snes, Vec T, Mat J, Mat P, void* self);
  static PetscErrorCode correct_step(SNESLineSearch search, Vec T, Vec step, PetscBool* changed, void* self);
  static PetscErrorCode converged(SNES snes, PetscInt iteration, PetscReal T_norm, PetscReal step_norm,
                                  PetscReal R_norm, SNESConvergedReason* reason, void* self);
  /// J_ at T_.
  void evaluate_jacobian();
  /// How well the next linear equations are solved: those of a stage to a hundredth of what is asked for; those of a
  /// steady state as the last step has shown that they are those of the equations (Eisenstat and Walker, SIAM J. Sci.
  /// Comput. 17 (1996) 16), and no better than what is left asks for. `left`: |R| over what it was before that step, 0
  /// in the first; `residual`: largest |R_i| / tolerance_i.
  void choose_linear_tolerance(double left, double residual);
  /// Unless the user has chosen.
  void set_linear_tolerance(double tolerance);
  KSP linear_solver() const;
  SNESLineSearch line_search() const;
  /// Largest |R_i| / unit_i. Collective.
  double largest_in_units_of(const std::vector<double>& unit) const;
  bool is_round_off() const;

  HeatSystem& system_;
  Equations equations_;
  bool is_steady_, knows_linear_tolerance_ = false;
  std::vector<double> T_;           ///< local points
  std::vector<double> T_jacobian_;  ///< owned points, at the last Jacobian
  std::vector<double> tolerance_, round_off_;
  double last_residual_ = 0, last_norm_ = 0;
  double unit_ = 0;  ///< of the equations that PETSc sees, see petsc::unit_of
  bool starts_ = true, fails_at_start_ = false, step_failed_ = false, at_round_off_ = false;
  bool has_jacobian_ = false, jacobian_is_old_ = true, always_renew_ = true;
  std::exception_ptr error_;
  JacobianOperator J_;
  petsc::Vector x_, R_, b_;
  petsc::NonlinearSolver snes_;
};

}  // namespace calor
