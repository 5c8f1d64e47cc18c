#pragma once
// A material with conductivity, density and specific heat of its own.
#include <memory>
#include <optional>
#include <string>

#include "material/material.hpp"

namespace calor {

struct SimpleProperties {
  Function conductivity;                  ///< W/(m K), of place, time and temperature
  std::optional<Function> density;        ///< kg/m^3, of place and temperature
  std::optional<Function> specific_heat;  ///< J/(kg K), of place and temperature
};

/// Throws Error(bad_case) where density or specific heat depends on time.
std::unique_ptr<Material> make_simple_material(const std::string& name, SimpleProperties properties);

}  // namespace calor
