#pragma once
// A material with conductivity, density and specific heat of its own.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "material/material.hpp"

namespace calor {

/// Heat of melting, taken up evenly between solidus and liquidus.
struct LatentHeat {
  double heat;               ///< J/kg
  double solidus, liquidus;  ///< K

  double liquid_fraction(double T) const { return std::clamp((T - solidus) / (liquidus - solidus), 0.0, 1.0); }
  /// Its derivative, 1/K; at solidus and liquidus that towards higher temperatures.
  double slope(double T) const { return T >= solidus && T < liquidus ? 1 / (liquidus - solidus) : 0; }
};

struct SimpleProperties {
  Function conductivity;                  ///< W/(m K), of place, time and temperature
  std::optional<Function> density;        ///< kg/m^3, of place and temperature
  std::optional<Function> specific_heat;  ///< J/(kg K), of place and temperature
  std::optional<LatentHeat> latent = {};
  std::optional<Anisotropy> anisotropy = {};
};

/// Throws Error(bad_case) where density or specific heat depends on time, or the density of a material that melts on
/// temperature.
std::unique_ptr<Material> make_simple_material(const std::string& name, SimpleProperties properties);

/// The same from [material.NAME]; `transient`: density and specific heat are needed.
std::unique_ptr<Material> read_simple_material(const std::string& name, const Table& table, bool transient);
/// The keys of that table.
std::vector<Key> simple_keys();

}  // namespace calor
