#pragma once
// The faces between the cells of the points, as quadrature points with area vectors: heat k grad T . area flows through
// a face point. The cells need not exist as polyhedra; what counts is that every face has two sides (heat is conserved)
// and that the area vectors of a cell and its share A_i of the surface of the body close (linear fields are exact).
#include <array>
#include <cstdint>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/quadrature.hpp"

namespace calor {

/// Face points of the cells of this rank's owned points, in the order of the pairs; those that a cell of another rank
/// shares are on both ranks, with the same bits.
struct Faces {
  std::vector<Vec3> x;          ///< quadrature points, m
  std::vector<Vec3> area;       ///< m^2, out of the cell of point a
  std::vector<std::int32_t> a;  ///< local points, by pairs id a < id b
  std::vector<std::int32_t> b;  ///< -1: no other cell takes what leaves a (overlapping subdomains)

  std::size_t size() const { return x.size(); }
};

/// Box cells of an unjittered box lattice; 1 or 2 Gauss points along every edge of a face. Collective.
Faces lattice_faces(const Cloud& cloud, int gauss);

/// What finding the virtual faces took, for the report.
struct FaceReport {
  std::int64_t pairs = 0;   ///< directed pairs
  int iterations = 0;       ///< conjugate gradients, all components
  double residual = 0;      ///< max |sum_j a_ij + A_i| / d^(D-1)
  double moment_error = 0;  ///< root mean square of the components of 1/(2 V_i) sum_j a_ij (x) x_ji - I
};

/// Virtual faces of any cloud with boundary areas and points on the walls: an area vector a_ij = -a_ji per pair, one
/// point halfway, with
///   sum_j a_ij = -A_i                        to round-off
///   1/2 sum_j a_ij (x) x_ji = V_i I          as well as the pairs allow (least squares)
/// so that the divergence theorem holds for linear fields and fluxes. The pairs are those of an SPH kernel with
/// smoothing 1, their first guess its weights scaled to the traces. Collective; throws Error for a surface that is not
/// closed.
Faces virtual_faces(const Cloud& cloud, FaceReport& report);

/// Pairs of virtual faces reach this far, in spacings.
double virtual_face_support();

// The overlapping subdomains of the MLPG papers: circles and spheres around the points, clipped by the walls of a box.

struct Subdomains {
  Faces faces;           ///< on the arcs inside the body; no other cell takes what leaves (b = -1)
  CellQuadrature cells;  ///< phi is left empty
};

/// Circles (2D: 12 angles, 2 radii) or spheres (3D: 4 x 4 points an octant of the surface, 3 x 3 x 2 inside) of radius
/// `radius` in spacings (ellipsoids where these are unequal), but never through a wall that the point does not lie on,
/// around the points of a box. Every balance is
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
