#pragma once
// The steps of the correction; see correction.hpp for what they are for. All are collective, take weights of directed
// pairs that are symmetric to the last bit and leave them so.
#include <span>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/correction.hpp"
#include "conduction/small_matrix.hpp"

namespace calor {

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
