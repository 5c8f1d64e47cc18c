#pragma once
// What a weld is judged by: the extent of the melt along lines, peak temperatures, cooling times, the average
// temperature against the theory.
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "output/probes.hpp"
#include "output/report.hpp"
#include "solve/heat_system.hpp"

namespace calor {

class Archive;

/// What temperatures went through: their peaks, and the time they took to cool between two levels (t8/5).
class ThermalHistory {
 public:
  /// Cooling is from `high` to `low`, K; without them only peaks are kept.
  struct Levels {
    double high, low;
  };
  ThermalHistory(std::size_t count, std::optional<Levels> levels);

  /// Adds temperatures at a later time. Between the times a parabola through three of them gives peaks and crossings.
  void observe(double t, std::span<const double> T);

  /// `values` exchanges what there is one of for each temperature.
  using Values = std::function<void(const std::string& name, std::span<double> values)>;
  void exchange(Archive& archive, const std::string& of, const Values& values);

  std::span<const double> peak() const { return peak_; }
  /// From the last crossing of `high` to the first one of `low` after it, s; of several times the last one counts.
  /// -1 where that has not happened.
  std::span<const double> cooling() const { return cooling_; }

 private:
  std::optional<Levels> levels_;
  double t1_ = 0, t0_ = 0;  ///< times before
  int known_ = 0;           ///< how many of them there are
  std::vector<double> T1_, T0_, peak_, below_high_, cooling_;
};

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
  static std::shared_ptr<WeldResults> make(const Case& c, HeatSystem& system, const Probes& probes, const State& start,
                                           const std::vector<double>& start_E);

  // T: temperatures of the owned points, as HeatSystem::temperatures gives them from those of the state.
  void observe(const State& state, std::span<const double> T);  ///< After every step. Collective.

  void exchange(Archive& archive);

  const std::vector<Extent>& extents() const { return extents_; }
  const std::vector<double>& largest_extents() const { return largest_; }  ///< so far, m
  /// Average temperature of the body, weighted by heat capacity; by volume where that depends on temperature or the
  /// subdomains of the points overlap. K.
  double average(const State& state, std::span<const double> T) const;
  /// The average at the start, K.
  double start_average() const { return start_mean_; }
  /// What it would be without losses: that of the start and the heat asked of the sources over the heat capacity.
  std::optional<double> theory(double t) const;
  const ThermalHistory& points() const { return points_; }
  const ThermalHistory& probes() const { return at_probes_; }
  bool has_cooling() const { return has_cooling_; }
  /// Its numbers in the report: largest_NAME and peak_NAME of the extents, peak.NAME of the probes.
  std::vector<ReportNumber> listed() const;
  /// In this order, so far. Collective.
  std::vector<double> numbers() const;

 private:
  WeldResults(const Case& c, HeatSystem& system, const Probes& probes, const State& start, std::vector<double> start_E);

  HeatSystem& system_;
  const Probes& probes_;
  bool has_cooling_;
  std::vector<Extent> extents_;
  std::vector<double> largest_;
  ThermalHistory points_, at_probes_;
  std::vector<double> start_E_;
  double start_mean_, capacity_;  ///< K, J/K
};

void declare_weld(Schema& schema);

}  // namespace calor
