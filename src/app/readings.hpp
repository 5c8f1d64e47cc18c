#pragma once
// What derivatives are taken of: the temperatures of the probes, and numbers of the balance.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "output/balance.hpp"
#include "output/probes.hpp"

namespace calor {

class Readings {
 public:
  /// Of all probes, and of the numbers that [output] derivatives_of names. Probes and system must outlive this.
  /// Collective; throws Error.
  Readings(const Case& c, const Probes& probes, HeatSystem& system);

  /// Names with units: the probes', then the numbers' as in report.json.
  std::vector<std::string> headings() const;
  std::size_t count() const { return probes_.names().size() + entries_.size(); }
  /// Are they sums w . u with weights that Probes::add_weights tells?
  bool are_of_probes_alone() const { return entries_.empty(); }
  /// `u`: local points, ghosts up to date. Collective.
  std::vector<double> at(double t, std::span<const double> u) const;

 private:
  const Probes& probes_;
  std::optional<Balance> balance_;
  std::vector<std::size_t> entries_;  ///< of the numbers of the balance
};

}  // namespace calor
