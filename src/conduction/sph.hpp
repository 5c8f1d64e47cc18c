#pragma once
// Smoothed particle hydrodynamics: the pair form of div(k grad T) (Cleary & Monaghan, J. Comput. Phys. 148, 1999) with
// the cubic spline kernel of Rong & Kisu, eq. (4), whose constants are those of docs/theory (the printed ones do not
// integrate to 1).
#include "case/case.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/correction.hpp"
#include "conduction/method.hpp"
#include "conduction/pair_conduction.hpp"

namespace calor {

/// Cubic spline W(r, h) in `dimension` dimensions, 1/m^D; support 2h.
double cubic_spline(double r, double h, int dimension);
/// F = -W'(r)/r > 0, so that grad_i W_ij = F x_ji; 1/m^(D+2).
double cubic_spline_F(double r, double h, int dimension);

/// Support radius over spacing: twice the smoothing length over the spacing.
inline double sph_support(double smoothing) { return 2 * smoothing; }

/// 2 V_i V_j x_ji.grad W_ij / |x_ji|^2 / section for every directed pair, m; the section enters V_i V_j twice and the
/// weight once. The kernel is W(|x_ji / s_ij|), stretched with the spacings (Shapiro et al., Astrophys. J. Suppl. 103,
/// 1996); of one spacing, this is 2 V_i V_j F_ij. The same bits for (i, j) and (j, i). V of all local points.
std::vector<double> sph_base_weights(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> V,
                                     double smoothing);

/// The consistent pair weights, m. `neighbours` within sph_support(smoothing), images included. Where `directions` are
/// those of lines, the cloud is a lattice and the smoothing 1. Collective.
std::vector<double> sph_consistent_weights(const Cloud& cloud, const Neighbours& neighbours, double smoothing,
                                           CorrectionReport& report, const PairDirections& directions = {});
/// Registers method = "sph".

}  // namespace calor
