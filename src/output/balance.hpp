#pragma once
// The balance of a body: the heat that flows through its faces and from its sources, and how warm its parts and faces
// are.
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "output/report.hpp"
#include "solve/heat_system.hpp"

namespace calor {

class Balance {
 public:
  /// Points of a material, weighted by their volume, or of a face, weighted by their area on it. A material that lies
  /// between the points has those next to it.
  struct Zone {
    std::string name;
    std::vector<int> point = {};      ///< index into Balance::temperatures
    std::vector<double> weight = {};  ///< m^3 or m^2
    double whole = 0;                 ///< weight of all points, on all ranks
    std::size_t inside = 0;           ///< so many of the points count for extremes; 0: all, or none on this rank
  };
  /// Temperatures of a zone, K.
  struct Summary {
    double mean, minimum, maximum;
  };

  /// Zones: the materials of the body, where there are several the "body" as a whole, the sections of [boundary.*] and
  /// the other faces of the cloud. A face that has the name of a material is called "face NAME". Both must outlive
  /// this. Collective.
  explicit Balance(HeatSystem& system);

  /// Boundary sections, then sources.
  const std::vector<std::string>& accounts() const { return system_.accounts(); }
  const std::vector<Zone>& zones() const { return zones_; }
  /// Heat flow into the body by every account, W; `u`: see State::T. Collective.
  std::vector<double> heat_flows(double t, std::span<const double> u) const;
  /// Its numbers in the report: heat_flow.NAME of the accounts; mean.NAME, minimum.NAME, maximum.NAME of the zones.
  std::vector<ReportNumber> listed() const;
  /// In this order; `u`: see State::T. Collective.
  std::vector<double> numbers(double t, std::span<const double> u) const;
  /// Of the owned points, then of the walls at the facets of this rank, K; `u`: see State::T. Collective.
  std::vector<double> temperatures(double t, std::span<const double> u) const;
  /// `T`: see temperatures. Collective.
  Summary summary(const Zone& zone, std::span<const double> T) const;

 private:
  void add_materials();
  void add_body();
  void add_sections();
  void add_faces();
  /// Keeps the zone where any rank has points of it. Collective.
  void keep(Zone zone);

  HeatSystem& system_;
  std::vector<Zone> zones_;
};

}  // namespace calor
