#pragma once
// Bond-based peridynamics of heat conduction (Bobaru & Duangpanya, Int. J. Heat Mass Transfer 53, 2010; Oterkus,
// Madenci & Agwai, J. Comput. Phys. 265, 2014): within the horizon delta every two points exchange heat through a bond,
//   rho c dT/dt = integral over |xi| <= delta of kappa (T(x + xi) - T(x)) / |xi|^n dV,   n = 0, 1, 2,
// with the micro-conductivity kappa that gives linear temperatures their classical heat flux.
#include <vector>

#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/correction.hpp"
#include "conduction/method.hpp"
#include "conduction/pair_directions.hpp"

namespace calor {

/// kappa of unit conductivity, with cross-section (1D) or thickness (2D) 1: 1/m^(D+2-n).
double micro_conductivity(int dimension, int n, double horizon);

struct Peridynamics {
  int n = 2;                       ///< power of 1/|xi|
  Support horizon = 3.015;         ///< delta
  bool partial_volumes = true;     ///< v: cells that the horizon cuts count in part
  bool surface_correction = true;  ///< g, of bond_weights

  /// How far points see: partial volumes reach half a spacing beyond the horizon, which itself belongs to the family.
  Support support() const;
};

/// kappa v V_i V_j / |xi|^n of every pair, m; the same bits for (i, j) and (j, i). Where the spacings are unequal the
/// family is an ellipsoid, and the weight falls as in a sphere to which it is stretched, but for a factor 1 / |xi|^2.
std::vector<double> base_weights(const Cloud& cloud, const Neighbours& neighbours, const Peridynamics& options);

/// Consistent weights of bonds: on lattices of unequal spacings peridynamics along every line of points, on all other
/// clouds base weights that are corrected. Where a body conducts differently by direction, the lines serve lattices of
/// equal spacings too. Collective; throws Error.
std::vector<double> peridynamic_weights(const Cloud& cloud, const Neighbours& neighbours, const Peridynamics& options,
                                        CorrectionReport& report, const PairDirections& directions = {});

/// The paper's weights: base weights times g, the surface correction by direction (Madenci & Oterkus, Peridynamic
/// Theory and Its Applications, 2014, sec. 4.2): along every axis the thermal potential of a linear temperature is
/// scaled to its classical value, and g_ij follows from the ellipsoid of the two points' factors. Collective (updates
/// ghosts).
std::vector<double> bond_weights(const Cloud& cloud, const Neighbours& neighbours, const Peridynamics& options);

/// Registers method = "peridynamics".

}  // namespace calor
