#pragma once
// Rules for the conductivity of a mixture of two phases. A new rule is one more entry in mixing_rules.cpp.
#include <span>
#include <string>
#include <vector>

namespace calor {

struct MixingRule {
  std::string name;
  std::string sentence;  ///< for the manual
  /// k of every point from the fraction a of the second phase and the conductivities of both, and the derivatives
  /// with respect to these. All spans have the same size.
  void (*mix)(std::span<const double> a, std::span<const double> k1, std::span<const double> k2, std::span<double> k,
              std::span<double> dk_dk1, std::span<double> dk_dk2);
};

const std::vector<MixingRule>& mixing_rules();

}  // namespace calor
