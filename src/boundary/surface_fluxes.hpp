#pragma once
// The kinds of surface flux. A new kind is a new file and its name in surface_fluxes.cpp.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/function.hpp"
#include "boundary/conditions.hpp"
#include "case/registry.hpp"

namespace calor {

struct SurfaceFluxKind {
  std::string name;  ///< its key in [boundary.*]
  std::string sentence;
  void (*declare)(Schema& schema);
  /// `boundary`: the table that holds the key; `x`: places on the facets, which must outlive the flux. What is asked
  /// at these places and depends on place alone is evaluated once; with none the flux is asked where it jumps. Throws
  /// Error(bad_case).
  std::unique_ptr<SurfaceFlux> (*make)(const Table& boundary, std::span<const Vec3> x);
};

Registry<SurfaceFluxKind>& surface_fluxes();

/// Checks that all values lie in [low, high]; throws Error naming the place in the case and the point:
/// "the heat transfer coefficient is -3 W/(m^2 K) at ...".
void check_range(std::span<const double> values, double low, double high, const Function& f, const Arguments& args,
                 const std::string& what, const std::string& unit, const std::string& cure);

/// The function `ambient` of a table. Refuses those of temperature, which would be that of the wall.
Function ambient_of(const Table& table);

/// Of both in time.
Changes changes_of(const Function& a, const Function& b);

/// f, a function of place and time, at the points x at time t.
std::vector<double> values_of(const PointFunction& f, std::span<const Vec3> x, double t);

}  // namespace calor
