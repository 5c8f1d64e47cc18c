#pragma once
// Is an MLPG scheme stable in time? C dT/dt = -K T with matrices that are not symmetric does not decay by itself.
#include <vector>

#include "cloud/cloud.hpp"
#include "conduction/face_conduction.hpp"
#include "conduction/mls.hpp"

namespace calor {

/// Quadrature of the cell of a point inside an unbounded lattice of spacing 1, around the origin. Lattices of unequal
/// spacings are stretched to it, and then conduct differently along every axis.
struct LatticeCell {
  std::vector<Vec3> face, area;  ///< points on its surface and their outward area vectors
  std::vector<Vec3> inside;
  std::vector<double> volume;
};

LatticeCell lattice_box(int dimension, bool one_point);
LatticeCell lattice_sphere(int dimension, double radius, bool one_point);

/// The cell's balance for waves exp(i k.x) of the parameters: volume * C(k) dT/dt = -conductivity * K(k) T.
struct LatticeSymbols {
  double least_capacity;  ///< min C(k)
  double least_rate;      ///< min K(k) / C(k) for k != 0, in units of diffusivity / d^2; negative: waves grow
  double kappa;           ///< effective over true diffusivity of long waves

  /// Where C(k) changes its sign, so does K(k) nearby, but not at the same k: then some waves grow.
  bool stable() const { return least_capacity > 0 && least_rate > -1e-9; }
};

/// Conductivity along every axis of a lattice that is stretched to spacing 1, over that along the axis of the least
/// spacing: (d / s_a)^2 for spacings s_a.
Vec3 stretched_conductivity(const Lattice& lattice);

/// R: support radius in spacings, the same for all points. `conductivity`: see stretched_conductivity.
LatticeSymbols lattice_symbols(const MovingLeastSquares& mls, double R, const LatticeCell& cell,
                               const Vec3& conductivity = {1, 1, 1});

/// Marches 60 Crank-Nicolson steps of a tenth of d^2/diffusivity from random parameters and returns the growth of T^h
/// over the last 20 (below 1 for a stable scheme); infinite where it blows up before or the linear solver fails.
/// `factor`: the largest of an anisotropic conductivity. Collective.
double start_up_growth(const Cloud& cloud, const FaceConduction& conduction, double factor = 1);

}  // namespace calor
