#include "material/mixing_rules.hpp"

namespace calor {
namespace {

// Phases side by side along the flow of heat (Voigt 1889): k = (1 - a) k1 + a k2.
void voigt(std::span<const double> a, std::span<const double> k1, std::span<const double> k2, std::span<double> k,
           std::span<double> dk_dk1, std::span<double> dk_dk2) {
  for (std::size_t i = 0; i < k.size(); ++i) {
    k[i] = (1 - a[i]) * k1[i] + a[i] * k2[i];
    dk_dk1[i] = 1 - a[i];
    dk_dk2[i] = a[i];
  }
}

}  // namespace

const std::vector<MixingRule>& mixing_rules() {
  static const std::vector<MixingRule> rules = {
      {"voigt", "k = (1 - a) k1 + a k2, the upper bound", voigt},
  };
  return rules;
}

}  // namespace calor
