#pragma once
// Two phases mixed in a fraction that may vary from place to place.
#include <memory>
#include <string>

#include "material/material.hpp"
#include "material/mixing_rules.hpp"

namespace calor {

/// What the fraction measures. It enters the conductivity as it is; mass: heat is held per mass,
/// rho = 1 / ((1-a)/rho1 + a/rho2) and c = (1-a) c1 + a c2; volume: rho and rho c are volume averages.
enum class Basis { mass, volume };

/// `fraction`: of the second phase, a function of place in [0, 1]. Throws Error(bad_case) at `place` for a fraction
/// that depends on more than place, and with Basis::mass for densities that depend on temperature.
std::unique_ptr<Material> make_mixture(const std::string& name, const MixingRule& rule, Basis basis, Function fraction,
                                       std::shared_ptr<const Material> first, std::shared_ptr<const Material> second,
                                       const Place& place);

}  // namespace calor
