#pragma once
// The overlapping subdomains of the MLPG papers: circles and spheres around the points, clipped by the walls of a box.
#include <array>
#include <vector>

#include "cloud/cloud.hpp"
#include "conduction/faces.hpp"
#include "conduction/quadrature.hpp"

namespace calor {

struct Subdomains {
  Faces faces;           ///< on the arcs inside the body; no other cell takes what leaves (b = -1)
  CellQuadrature cells;  ///< phi is left empty
};

/// Circles (2D: 12 angles, 2 radii) or spheres (3D: 4 x 4 points an octant of the surface, 3 x 3 x 2 inside) of radius
/// `radius` d_i, but never through a wall that the point does not lie on, around the points of a box. Every balance is
/// scaled such that the heat through its part of a wall is that through the point's boundary area; inside, such that
/// the volumes are those of the points. They do not fill the body, so heat is not conserved to round-off. Collective;
/// throws Error for bodies other than boxes of two or three dimensions.
Subdomains sphere_subdomains(const Cloud& cloud, double radius);

/// Quadrature of one whole circle or sphere of radius 1 around the origin.
struct UnitSphere {
  std::vector<Vec3> on, inside;
  std::vector<double> area, volume;  ///< weights
};
/// `side` of every axis: 0 the whole axis, -1 or +1 that half only (the point lies on a wall).
UnitSphere unit_sphere(int dimension, const std::array<int, 3>& side);

}  // namespace calor
