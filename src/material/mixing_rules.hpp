#pragma once
// Rules for the conductivity of a mixture of phases, from their volume fractions. A new rule is one more entry in
// mixing_rules.cpp.
#include <span>
#include <string>
#include <vector>

#include "case/registry.hpp"

namespace calor {

struct MixingRule {
  std::string name;
  std::string sentence;  ///< for the manual, without a full stop
  std::string source;
  /// Conductivity of every point, and its derivatives by the conductivities of the phases. v (fractions, whose sum is
  /// 1), k (W/(m K)) and dmixed_dk hold the first phase at all points, then the second phase at all points, and so on:
  /// mixed.size() entries a phase.
  void (*mix)(std::span<const double> v, std::span<const double> k, std::span<double> mixed,
              std::span<double> dmixed_dk);
  bool takes_mass = false;  ///< may the fractions be of the mass, taken as they are?
};

Registry<MixingRule>& mixing_rules();

}  // namespace calor
