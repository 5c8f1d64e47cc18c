#pragma once
// What a body is made of. A Material is what the case says; bound to points it becomes PointProperties, which evaluate
// whole arrays (one virtual call an array, never one a point). A new law is a new file and its name in
// materials.cpp.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/function.hpp"
#include "base/vec3.hpp"
#include "material/anisotropy.hpp"

namespace calor {

/// Properties of one material at fixed points x[0..n). Calls ask for the points first, first + 1, ... , one for every
/// entry of T. Values are not checked here: MaterialField does.
class PointProperties {
 public:
  virtual ~PointProperties() = default;
  /// k, W/(m K); dk_dT may be empty.
  virtual void conductivity(std::size_t first, double t, std::span<const double> T, std::span<double> k,
                            std::span<double> dk_dT) const = 0;
  /// theta = integral of k dT from 0, W/m; only where Material::conductivity_of_T_alone().
  virtual void theta(std::span<const double> T, std::span<double> theta) const = 0;
  /// Volumetric enthalpy above the reference temperature, J/m^3, and rho c = dH/dT, J/(m^3 K); either may be empty.
  /// Only where Material::has_capacity().
  virtual void enthalpy(std::size_t first, std::span<const double> T, std::span<double> H,
                        std::span<double> rho_c) const = 0;
  /// kg/m^3; only where Material::has_capacity() and not Material::density_depends_on_T().
  virtual void density(std::size_t first, std::span<double> rho) const = 0;
  /// Of the ingredient with that number in Material::ingredients().
  virtual void volume_fraction(std::size_t /*ingredient*/, std::size_t /*first*/, std::span<double> v) const {
    std::ranges::fill(v, 1.0);
  }
};

/// Temperatures a run is expected to see (curves are sampled there first) and the zero of the enthalpy, K.
struct TemperatureRange {
  double low, high, reference;
};

class Material {
 public:
  explicit Material(std::string name) : name(std::move(name)) {}
  virtual ~Material() = default;
  /// The points must outlive the result. Throws Error(bad_case) where a value that does not depend on temperature or
  /// time is not positive.
  virtual std::unique_ptr<PointProperties> at(std::span<const Vec3> x, const TemperatureRange& range) const = 0;

  virtual bool conductivity_of_T_alone() const = 0;  ///< no place, no time: the integral mean applies
  virtual bool conductivity_is_layered() const { return false; }
  virtual bool conductivity_depends_on_T() const = 0;
  virtual bool conductivity_depends_on_time() const = 0;
  virtual bool capacity_depends_on_T() const = 0;
  virtual bool density_depends_on_T() const = 0;
  /// Are density and specific heat known? A steady case does without.
  virtual bool has_capacity() const = 0;
  /// How the conductivity depends on direction; null: it does not.
  virtual const Anisotropy* anisotropy() const { return nullptr; }
  /// Names of the materials that are mixed in it; its own where nothing is. A name may come twice.
  virtual std::vector<std::string> ingredients() const { return {name}; }

  const std::string name;
};

}  // namespace calor
