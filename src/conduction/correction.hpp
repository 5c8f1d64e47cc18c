#pragma once
// The stage that turns the base weights of any pair method into weights that conserve heat, reproduce linear fields to
// round-off on any cloud and converge with second order.
//
// Think of the pairs as the bars of a truss with forces G_ij x_ji, x_ji = x_j - x_i: it carries the stress
// sigma = 1/2 sum_ij G_ij x_ji (x) x_ji on the segments ij, and heat is conducted with the tensor sigma instead of I.
//   sum_j G_ij x_ji = -A_i                     (L)  div sigma = 0 with the tractions of sigma = I on the surface:
//                                                   linear temperatures and their wall fluxes are exact
//   sum_j G_ij x_ji (x) x_ji = 2 V_i I         (M)  no self-equilibrated stress: without it a layer along the walls has
//                                                   sigma - I = O(1), and the scheme is of first order only
// (M), for points on the walls, cannot hold everywhere at once: it is fitted; (L) is then enforced to round-off. What
// (L) leaves open are rigid motions of the truss, so the areas must satisfy sum A = 0 and sum x cross A = 0.
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/linear_algebra.hpp"

namespace calor {

/// What the correction did, for the report.
struct CorrectionReport {
  bool lattice_shortcut = false;  ///< exact weights of a box lattice, nothing to solve
  int moment_iterations = 0;
  int lambda_solves = 0, lambda_iterations = 0;
  double residual = 0;        ///< max |sum_j G_ij x_ji + A_i| / d^(D-1)
  double change = 0;          ///< max |G/g - 1| of the first lambda solve
  std::int64_t negative = 0;  ///< directed pairs with G < 0 that remain
  double most_negative = 0;   ///< min G / mean |G|, 0 when none
  std::int64_t pairs = 0;     ///< directed pairs
};

/// Adds the numbers that report.json shows, by name.
void add_to_report(const CorrectionReport& done, std::map<std::string, double>& report);

/// Base weights g (directed, symmetric to the last bit, true volumes); called only where they are needed.
using BaseWeights = std::function<std::vector<double>()>;

/// Consistent weights from base weights: Sinkhorn scaling of the traces of (M), a fit of (M), then (L) by
/// G_ij = g_ij [1 + (lambda_i - lambda_j).x_ji]. The cloud must have boundary areas. `lattice_weights`: G of a pair
/// with |x_ji|^2 = 1, 2, 3 d^2 inside an unbounded box lattice of spacing d, for methods whose support ends there; then
/// a box lattice takes its exact weights without any solve. Empty: no such weights. The result does not depend on the
/// number of ranks. Collective; throws Error(numbers) where (L) has no solution.
std::vector<double> consistent_weights(const Cloud& cloud, const Neighbours& neighbours,
                                       const BaseWeights& base_weights, std::span<const double> lattice_weights,
                                       CorrectionReport& report);

/// The same on a graded box lattice, where weights are known that hold (L) and (M) exactly at every point, so that
/// nothing is left to solve: neighbours along an axis get the face between their cells over their distance, all others
/// none. The general way is of first order there (with a small constant): near walls the kernel sees the grading.
/// Collective.
std::vector<double> graded_lattice_weights(const Cloud& cloud, const Neighbours& neighbours, CorrectionReport& report);

// The steps, for bodies whose weights are made in another way. All are collective, take weights of directed pairs that
// are symmetric to the last bit and leave them so.

/// g_ij <- g_ij a_i a_j such that sum_j g_ij |x_ji|^2 = 2 D volume_i: Sinkhorn sweeps. `volume` of the owned points.
void scale_traces(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume,
                  std::span<double> g);

/// Fits sum_j g_ij x_ji (x) x_ji to 2 V_i I by g_ij <- g_ij [1 + x_ji.(tau_i + tau_j) x_ji], tau symmetric tensors, and
/// keeps g >= 0.02 of what it was. For points on the walls. Returns the iterations.
int fit_second_moments(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g);

/// The same fit for points beside cracks: tau_i = z_i P_i adds missing_i to sum_j g_ij x_ji.P_i x_ji where P_i, of the
/// owned points, is not zero.
void restore_second_moments(const Cloud& cloud, const Neighbours& neighbours, std::span<const Symmetric3> P,
                            std::span<const double> missing, std::span<double> g);

/// R_i = -A_i - sum_j g_ij x_ji of the owned points, m^2.
std::vector<Vec3> linear_residual(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g);

struct LambdaSolve {
  int iterations;
  double change;  ///< max |G/g - 1|
};

/// g_ij <- g_ij [1 + (lambda_i - lambda_j).x_ji] with lambda such that sum_j g_ij x_ji = -A_i, up to `tolerance` of
/// what it was off by.
LambdaSolve enforce_linear_consistency(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g,
                                       double tolerance);

/// The same, again and again from weights without the negative ones (kept at 0.02 of what they were), until there are
/// none, six times at most. Books solves, residual and what is left of negative weights.
void enforce_with_positive_weights(const Cloud& cloud, const Neighbours& neighbours, std::vector<double>& g,
                                   CorrectionReport& report);

}  // namespace calor
