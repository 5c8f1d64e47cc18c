#pragma once
// What derivatives are taken of: the temperatures of the probes, and numbers of the report: of the balance, of a weld
// and of thermal stress.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "output/balance.hpp"
#include "output/probes.hpp"
#include "output/thermal_stress.hpp"
#include "output/weld.hpp"

namespace calor {

class Readings {
 public:
  /// Of all probes, and of the numbers that [output] derivatives_of names. `weld`, `stress`: of the case; null where it
  /// has none. All must outlive this. Collective; throws Error.
  Readings(const Case& c, const Probes& probes, HeatSystem& system, std::shared_ptr<WeldResults> weld = nullptr,
           std::shared_ptr<const ThermalStress> stress = nullptr);

  /// Names with units: the probes', then the numbers' as in report.json.
  std::vector<std::string> headings() const;
  std::size_t count() const { return probes_.names().size() + entries_.size(); }
  /// Are they sums w . u with weights that Probes::add_weights tells?
  bool are_of_probes_alone() const { return entries_.empty(); }
  /// After every step of a run: what weld and stress come to counts from then on. Collective.
  void observe(State& state);
  /// `u`: local points, ghosts up to date. Collective.
  std::vector<double> at(double t, std::span<const double> u) const;

 private:
  std::vector<ReportNumber> listed() const;

  const Probes& probes_;
  HeatSystem& system_;
  std::shared_ptr<WeldResults> weld_;
  std::shared_ptr<const ThermalStress> stress_;
  ExtremeStresses extremes_;
  std::optional<Balance> balance_;
  std::vector<std::size_t> entries_;  ///< of what is listed
};

}  // namespace calor
