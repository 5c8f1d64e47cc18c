#pragma once
// Two phases mixed in a fraction that may vary from place to place, perhaps with pores.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "material/material.hpp"
#include "material/mixing_rules.hpp"

namespace calor {

/// What the fraction measures. It enters the conductivity as it is; mass: heat is held per mass,
/// rho = 1 / ((1-a)/rho1 + a/rho2) and c = (1-a) c1 + a c2; volume: rho and rho c are volume averages.
enum class Basis { mass, volume };

/// How pores enter the conductivity: as the second phase in the mixture of the two others, all three phases at once, or
/// by a factor on that of the two others.
enum class Pores { sequential, third, factor };

/// With a the fraction of the second phase and P the porosity, the phases take (1-P)(1-a), (1-P) a and P of the volume.
struct MixtureRecipe {
  std::string name;
  const MixingRule* rule;
  Basis basis;
  Function fraction;                                      ///< of the second phase in the solid, in [0, 1]
  std::vector<std::shared_ptr<const Material>> phases{};  ///< two, then what fills the pores where there is a porosity
  std::optional<Function> porosity{};                     ///< in [0, 1)
  Pores pores = Pores::sequential;
  std::optional<Function> factor{};  ///< of Pores::factor, in [0, 1]
};

/// Throws Error(bad_case) for a fraction, porosity or factor that depends on more than place, and at `location` with
/// Basis::mass for a rule that takes volumes only and for densities that depend on temperature.
std::unique_ptr<Material> make_mixture(MixtureRecipe recipe, const SourceLocation& location);

}  // namespace calor
