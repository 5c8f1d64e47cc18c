#pragma once
// Pairs of points in bodies that conduct differently by direction, by k R with a constant tensor R
// (material/anisotropy). Two ways lead to weights of pairs:
// - On the lines of a lattice along the axes of R every line is a rod: its weights, times R along it. Every part may
//   have an R of its own, of any ratio, as long as all axes are those of the lattice.
// - Anywhere else R must be the same in the whole body. In the coordinates y = R^(-1/2) x it conducts alike in all
//   directions: with y_ji = R^(-1/2) x_ji and A' = R^(1/2) A
//     sum_j G_ij y_ji = -A'_i,   sum_j G_ij y_ji (x) y_ji = 2 V_i I
//   say the same as sum_j G_ij x_ji = -R A_i and sum_j G_ij x_ji (x) x_ji = 2 V_i R. The neighbours stay those of the
//   round supports in x, so that the ratio that these weights can serve has an end.
#include <optional>
#include <span>
#include <vector>

#include "conduction/correction.hpp"
#include "material/material_field.hpp"

namespace calor {

struct PairDirections {
  /// R of every part, which the weights do not hold yet; pairs lie along its axes then. Empty: there is no such R.
  std::vector<Symmetric3> of_parts = {};
  /// R that the weights hold already.
  std::optional<Anisotropy> in_weights = {};
};

/// How pairs may serve the material; `along_lines`: weights of a lattice's lines suit the method. Refuses bodies that
/// they cannot serve. Collective; throws Error(bad_case).
PairDirections pair_directions(const Case& c, const Cloud& cloud, const MaterialField& material, bool along_lines);

/// R along a pair: x.R x / x.x.
double along(const Symmetric3& R, const Vec3& x_ji);

/// Consistent weights, m, of a body that conducts by R everywhere, from base weights of the cloud as it is. Refuses
/// what they cannot serve. Collective; throws Error.
std::vector<double> anisotropic_weights(const Cloud& cloud, const Neighbours& neighbours, const Anisotropy& R,
                                        const BaseWeights& base_weights, CorrectionReport& report);

}  // namespace calor
