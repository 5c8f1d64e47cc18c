#pragma once
// The built-in materials. Every value carries its source.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "material/simple.hpp"

namespace calor {

/// One property with where it comes from.
struct LibraryValue {
  std::string
      value;         ///< as it would be written in a case, e.g. "7900 kg/m^3" or a formula in T (K); or what the law is
  std::string unit;  ///< of a formula or law; empty where `value` has one
  std::string source;
  double (*law)(double) = nullptr;                    ///< of the temperature in degC, in SI units
  std::vector<std::pair<double, double>> table = {};  ///< temperature in degC, value in SI units
};

struct LibraryMelting {
  LatentHeat latent;
  std::string source;
};

struct LibraryMaterial {
  std::string name;
  LibraryValue conductivity, density, specific_heat;
  double low, high;  ///< temperatures for which these values are good, K
  std::optional<LibraryMelting> melting = {};

  SimpleProperties properties() const;
};

const std::vector<LibraryMaterial>& material_library();
/// Null where there is none of that name.
const LibraryMaterial* find_in_library(const std::string& name);

}  // namespace calor
