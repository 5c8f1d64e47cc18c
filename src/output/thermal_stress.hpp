#pragma once
// Thermal stress of thin bodies: beams, plates and discs whose cross-sections stay plane, so that the strain is linear
// through the thickness. What the temperature of a section does to it follows from integrals along lines through the
// thickness. Boley & Weiner, Theory of Thermal Stresses (1960), chapters 9, 10 and 12.
#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "material/elasticity.hpp"
#include "output/probes.hpp"
#include "output/report.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// How a body deforms at one time.
struct Deformation {
  /// Of beam and plate: strain where the line begins, and curvature, 1/m. Of a disc: radial displacement (m) and
  /// slope of the line's beginning at every node along the radius.
  std::vector<double> d;
  double strain = 0;               ///< in the middle of the thickness; of a disc on its axis
  double curvature = 0;            ///< 1/m, positive where the end of the line is longer; of a disc on its axis
  double lowest = 0, highest = 0;  ///< stress, Pa, over the section and all components
  // The section: one value a place.
  std::vector<double> T;                    ///< K
  std::vector<std::vector<double>> stress;  ///< of every component, Pa
};

/// The extremes of several deformations, Pa.
struct ExtremeStresses {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;

  void add(const Deformation& d) { lowest = std::min(lowest, d.lowest), highest = std::max(highest, d.highest); }
  /// Their numbers in the report.
  static std::vector<ReportNumber> listed() {
    return {{"lowest_stress", "Pa"}, {"highest_stress", "Pa"}, {"largest_stress", "Pa"}};
  }
  std::vector<double> numbers() const { return {lowest, highest, std::max(-lowest, highest)}; }
};

class ThermalStress {
 public:
  /// By [stress]; null where the case has none. `probes`: of the case. All must outlive it. Collective; throws Error.
  static std::shared_ptr<const ThermalStress> make(const Case& c, const HeatSystem& system, const Probes& probes);
  ~ThermalStress();

  /// "stress" of beam and plate; "radial stress" and "hoop stress" of a disc.
  const std::vector<std::string>& components() const;
  /// Where the section is looked at: distance from the beginning of the line and from the axis, m.
  std::span<const double> s() const;
  std::span<const double> r() const;

  /// u: see Probes::temperatures. Collective.
  Deformation deformation(std::span<const double> u) const;
  /// Stress at the owned points, Pa; T: their temperatures, K. Throws Error, maybe on one rank alone.
  std::vector<double> at_points(const Deformation& deformation, std::size_t component, std::span<const double> T) const;
  /// At the probes; T: their temperatures, K.
  std::vector<double> at_probes(const Deformation& deformation, std::size_t component, std::span<const double> T) const;

 private:
  struct Impl;
  explicit ThermalStress(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

void declare_stress(Schema& schema);

}  // namespace calor
