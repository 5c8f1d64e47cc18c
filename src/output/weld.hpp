#pragma once
// What a weld is judged by: the extent of the melt along lines, peak temperatures, cooling times, the average
// temperature against the theory.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "output/files.hpp"
#include "output/history.hpp"
#include "output/probes.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// The part of a line between two places that is hotter than an isotherm: from the first crossing to the last.
class Extent {
 public:
  /// Refuses lines outside the body. Collective.
  Extent(const std::string& name, const Cloud& cloud, const Vec3& from, const Vec3& to, double isotherm,
         const SourceLocation& in_case, const Dofs* dofs = nullptr);

  struct Part {
    double begin = 0, end = 0;  ///< distances from `from`, m; equal where nothing is hotter
    double length() const { return end - begin; }
  };
  // Crossings are interpolated by cubics. Collective.
  Part of_field(std::span<const double> field) const;     ///< of the owned points
  Part of_temperatures(std::span<const double> T) const;  ///< T: see Probes::temperatures
  const std::string& name() const { return name_; }

 private:
  Part of(const std::vector<double>& on_line) const;

  std::string name_;
  double isotherm_, step_;
  Probes line_;  ///< equally spaced
};

class WeldResults {
 public:
  /// By [weld]; nothing where the case has none. `start_E`: enthalpies before walls were imposed, J. Collective; throws
  /// Error.
  static std::unique_ptr<WeldResults> make(const Case& c, HeatSystem& system, const Probes& probes, const State& start,
                                           const std::vector<double>& start_E);
  /// From now on writes weld.csv and, in the end, cooling.csv; an empty folder writes nothing. Collective; throws
  /// Error.
  void open(const std::string& folder);

  // T: temperatures of the owned points, as HeatSystem::values gives them from those of the state.
  void observe(const State& state, std::span<const double> T);  ///< After every step. Collective.
  /// A row of weld.csv: time, average, theory, extents. Collective.
  void record(const State& state, std::span<const double> T);
  /// cooling.csv and numbers for the report. Collective.
  std::map<std::string, double> finish(const State& state, std::span<const double> T);

  const std::vector<Extent>& extents() const { return extents_; }
  /// Average temperature of the body, weighted by heat capacity; by volume where that depends on temperature or the
  /// subdomains of the points overlap. K.
  double average(const State& state, std::span<const double> T) const;
  /// What it would be without losses: that of the start and the heat asked of the sources over the heat capacity.
  std::optional<double> theory(double t) const;
  const ThermalHistory& points() const { return points_; }
  const ThermalHistory& probes() const { return at_probes_; }
  bool has_cooling() const { return has_cooling_; }

 private:
  WeldResults(const Case& c, HeatSystem& system, const Probes& probes, const State& start,
              const std::vector<double>& start_E);

  HeatSystem& system_;
  const Probes& probes_;
  std::string folder_, header_;
  bool has_cooling_;
  std::vector<Extent> extents_;
  std::vector<double> largest_;  ///< extents so far, m
  ThermalHistory points_, at_probes_;
  std::vector<double> start_E_;
  double start_mean_, capacity_;  ///< K, J/K
  CsvLog log_;
};

void declare_weld(Schema& schema);

}  // namespace calor
