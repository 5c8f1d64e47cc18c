#pragma once
// The kinds of surface flux. A new kind is a new file and a line in surface_fluxes.cpp.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/point_function.hpp"
#include "boundary/conditions.hpp"

namespace calor {

struct SurfaceFluxKind {
  std::string key;  ///< in [boundary.*]
  void (*declare)(Schema& schema);
  /// `boundary`: the table that holds the key; `x`: points of the facets, which must outlive the flux. What is asked
  /// at these points and depends on place alone is evaluated once. Throws Error(bad_case).
  std::unique_ptr<SurfaceFlux> (*make)(const Table& boundary, std::span<const Vec3> x);
};

const std::vector<SurfaceFluxKind>& surface_flux_kinds();

// One file each.
extern const SurfaceFluxKind prescribed_flux, convection, radiation;

/// Checks that all values lie in [low, high]; throws Error naming the place in the case and the point:
/// "the heat transfer coefficient is -3 W/(m^2 K) at ...".
void check_range(std::span<const double> values, double low, double high, const Function& f, const Arguments& args,
                 const std::string& what, const std::string& unit, const std::string& cure);

/// The events in time of both.
std::vector<double> events_of(const PointFunction& a, const PointFunction& b);

/// f, a function of place and time, at the points x at time t.
std::vector<double> values_of(const PointFunction& f, std::span<const Vec3> x, double t);

}  // namespace calor
