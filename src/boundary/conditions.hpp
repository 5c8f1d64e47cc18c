#pragma once
// Boundary conditions: prescribed temperatures, and heat fluxes into the body that add up on a face.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/function.hpp"
#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// Heat flux into the body through unit area, as a function of place, time and surface temperature.
class SurfaceFlux {
 public:
  virtual ~SurfaceFlux() = default;
  /// q[i], W/m^2, and dq/dT (may be empty), W/(m^2 K).
  virtual void evaluate(const Arguments& args, std::span<double> q, std::span<double> dq_dT) const = 0;
  virtual bool depends_on_temperature() const = 0;  ///< false: q is prescribed
  virtual bool linear_in_temperature() const = 0;   ///< dq/dT does not depend on T
  /// false: the same at all places of a facet, so that its area is all that counts
  virtual bool depends_on_place() const { return true; }
  virtual bool derivative_depends_on_time() const { return false; }
  /// Does it draw the surface towards the ambient temperature and no farther?
  virtual bool draws_to_ambient() const { return false; }
  virtual Changes changes() const = 0;
  /// Ambient temperatures at time t, for the range of temperatures to expect; empty for a plain flux.
  virtual std::vector<double> ambient(std::span<const Vec3> x, double t) const = 0;
};

/// One flux on parts of facets of this rank: at the places of a quadrature, or on each facet as a whole where it does
/// not depend on the place.
struct SurfaceTerm {
  std::string name;  ///< "top.convection"
  int account;       ///< index into Conditions::accounts
  std::unique_ptr<SurfaceFlux> flux;
  std::vector<int> point;    ///< owned points, one entry a place
  std::vector<int> facet;    ///< index into Cloud::facets; none on the faces of a plate
  std::vector<double> area;  ///< m^2
  std::vector<Vec3> x;
  bool is_plate = false;  ///< on the faces of a plate: the area is that of the cells, and heat goes into all of them
};

/// Prescribed temperature on points of this rank. Where several meet, each carries its share of the mean. On a cloud
/// without points on its walls no point takes it: the facets' walls do, by mirror images beyond them or by the heat
/// that the layer between wall and point conducts.
struct PrescribedTerm {
  std::string name;
  int account;
  Function temperature;       ///< K
  std::vector<int> point;     ///< owned points, ascending; none off the walls
  std::vector<int> facet;     ///< off the walls: index into Cloud::facets, ascending
  std::vector<double> share;  ///< of every point or facet: 1, or 1/2 where two meet, ...
  std::vector<Vec3> area;     ///< outward, of the wall that each of these points has here, m^2
  std::vector<Vec3> x;        ///< of these points, or on the wall of these facets
};

/// Where a section of the case holds on plane walls, for methods that put mirror images beyond them.
struct WallSection {
  std::uint32_t faces;
  int condition;  ///< index into Conditions::temperatures, or one of the two below
  std::function<std::vector<char>(std::span<const Vec3>)> where;  ///< empty: everywhere on the faces

  static constexpr int insulated = -1, flux = -2;
};

struct Conditions {
  std::vector<std::string> accounts;  ///< names of the boundary sections, in the order of the case
  std::vector<double> areas;  ///< on which the fluxes of each act at the start, of all ranks, m^2; 0 without a flux
  std::vector<SurfaceTerm> fluxes;
  std::vector<PrescribedTerm> temperatures;
  std::vector<WallSection> walls;  ///< in the order of the case
  std::vector<std::string> notes;  ///< e.g. "21 points on xmin and ymin take the mean of two temperatures"
};

/// WallSection::condition of the first section that holds at each of the places on faces[face], `insulated` where none
/// does. Throws Error where a formula fails.
std::vector<int> conditions_at(const Conditions& conditions, int face, std::span<const Vec3> x);

/// Conditions of [boundary.*] on the cloud. Refuses unknown faces, empty selections and contradictions.
/// Collective; throws Error.
Conditions make_conditions(const Case& c, const Cloud& cloud);

void declare_boundaries(Schema& schema);

}  // namespace calor
