#pragma once
// The built-in materials. Every value carries its source.
#include <string>
#include <vector>

#include "material/simple.hpp"

namespace calor {

/// One property with where it comes from.
struct LibraryValue {
  std::string value;  ///< as it would be written in a case, e.g. "7900 kg/m^3" or a formula in T (K)
  std::string unit;   ///< of a formula; empty where `value` has one
  std::string source;
};

struct LibraryMaterial {
  std::string name;
  LibraryValue conductivity, density, specific_heat;

  SimpleProperties properties() const;
};

const std::vector<LibraryMaterial>& material_library();
/// Null where there is none of that name.
const LibraryMaterial* find_in_library(const std::string& name);

}  // namespace calor
