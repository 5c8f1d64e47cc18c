#pragma once
// Boundary conditions: prescribed temperatures, and heat fluxes into the body that add up on a face. A new kind of flux
// is a new file with a SurfaceFlux and a line in conditions.cpp.
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
  virtual bool derivative_depends_on_time() const { return false; }
  virtual std::vector<double> breaks() const = 0;
  /// Ambient temperatures at time t, for the range of temperatures to expect; empty for a plain flux.
  virtual std::vector<double> ambient(std::span<const Vec3> x, double t) const = 0;
};

/// One flux on a set of patches of this rank.
struct SurfaceTerm {
  std::string name;  ///< "top.convection"
  int account;       ///< index into Conditions::accounts
  std::unique_ptr<SurfaceFlux> flux;
  std::vector<int> point;    ///< owned points, one entry per patch
  std::vector<double> area;  ///< m^2
  std::vector<Vec3> x;
};

/// Prescribed temperature on points of this rank. Where several meet, each carries its share of the mean.
struct PrescribedTerm {
  std::string name;
  int account;
  Function temperature;       ///< K
  std::vector<int> point;     ///< owned points, ascending
  std::vector<double> share;  ///< 1, or 1/2 where two meet, ...
  std::vector<Vec3> x;
};

struct Conditions {
  std::vector<std::string> accounts;  ///< names of the boundary sections, in the order of the case
  std::vector<SurfaceTerm> fluxes;
  std::vector<PrescribedTerm> temperatures;
  std::vector<std::string> notes;  ///< e.g. "21 points on xmin and ymin take the mean of two temperatures"
};

/// Conditions of [boundary.*] on the cloud. Refuses unknown faces, empty selections, contradictions, prescribed
/// temperatures on cell-centred clouds. Collective; throws Error.
Conditions make_conditions(const Case& c, const Cloud& cloud);

void declare_boundaries(Schema& schema);

}  // namespace calor
