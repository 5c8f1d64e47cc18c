#pragma once
// The meshless local Petrov-Galerkin method with the Heaviside test function (MLPG5: Atluri & Shen, The meshless local
// Petrov-Galerkin (MLPG) method, Tech Science Press, 2002): the heat balance of every cell, with the fluxes through its
// faces from moving least squares.
#include "cloud/cloud.hpp"
#include "conduction/face_conduction.hpp"
#include "conduction/faces.hpp"
#include "conduction/method.hpp"
#include "conduction/mls.hpp"
#include "conduction/supports.hpp"
#include "conduction/wall_terms.hpp"

namespace calor {

/// How the temperature gradient on a face follows from the unknowns.
enum class MlpgFlux {
  parameters,       ///< gradient of T^h = sum phi_J T^_J; the unknowns are the parameters T^
  edge_stabilised,  ///< the same of the values T_J, with the part along the line i-j replaced by (T_j - T_i) / r
};
enum class MlpgCapacity {
  consistent,  ///< integrals of T^h over the cells
  one_point,   ///< V_i T^h(x_i)
};

enum class MlpgSubdomain {
  tiles,   ///< cells that fill the body
  sphere,  ///< circles and spheres around the points, which overlap: for comparison with the papers
};

enum class MlpgPrescribed {
  collocation,  ///< the row of a point on the wall says T^h(x_i) = T*
  penalty,      ///< its heat balance has the flux through the wall and alpha (T* - T^h), alpha = 1e5 k / spacing
};

struct MlpgOptions {
  MovingLeastSquares mls;
  SupportSize support;
  MlpgFlux flux = MlpgFlux::parameters;
  MlpgCapacity capacity = MlpgCapacity::consistent;
  MlpgSubdomain subdomain = MlpgSubdomain::tiles;
  double radius = 0.7;  ///< of the spheres, over spacing
  MlpgPrescribed prescribed = MlpgPrescribed::collocation;
  std::optional<Anisotropy> anisotropy = {};  ///< of the material; none: it conducts alike in all directions

  /// What suits the cloud; `regular`: a box lattice.
  static MlpgOptions defaults(int dimension, bool regular, int degree = 1);
};

struct MlpgReport {
  FaceReport faces;
  SupportReport supports;
  double neighbours = 0;  ///< mean number of points that a face point sees
};

/// Support radius over spacing that the halo of the cloud must cover.
double mlpg_support(const MlpgOptions& options);

/// What the options make of a cloud.
struct MlpgScheme {
  std::unique_ptr<FaceConduction> conduction;
  ShapeFunctions shapes = {};                    ///< of parameters
  std::unique_ptr<CellSamples> subdomains = {};  ///< where they are not the points' cells
  std::unique_ptr<HeatTerm> walls = {};          ///< null: prescribed temperatures are collocated
};

/// The scheme on cells that fill the body, boxes on unjittered lattices and virtual faces on all other clouds; or on
/// spheres. The cloud must have points on the walls and boundary areas. `temperatures` are the prescribed ones.
/// Collective; throws Error.
MlpgScheme mlpg_scheme(const Cloud& cloud, const MlpgOptions& options, MlpgReport& report,
                       std::span<const PrescribedTerm> temperatures = {});

/// Registers method = "mlpg".

}  // namespace calor
