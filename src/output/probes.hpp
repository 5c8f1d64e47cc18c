#pragma once
// Temperatures at given places: by the method's own shape functions, or interpolated from the nearest points (cubic
// where the points allow) that lie in the same part of the body: neither across interfaces, where the gradient jumps,
// nor across contacts and cracks, where the temperature does. See interpolation.hpp.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "cloud/cracks.hpp"
#include "conduction/dofs.hpp"
#include "geometry/parts.hpp"
#include "output/interpolation.hpp"

namespace calor {

class Probes {
 public:
  /// Probes of [probe]. Refuses a probe outside the body. `dofs`: what gives the temperatures; without them
  /// these are fields like any other. `parts`: null for a body of one part. Collective.
  Probes(const Case& c, const Cloud& cloud, const Dofs* dofs = nullptr, const Parts* parts = nullptr);
  /// At given places (m), for other users. Collective.
  Probes(const Cloud& cloud, std::vector<std::string> names, std::vector<Vec3> places, const Dofs* dofs = nullptr,
         const Parts* parts = nullptr);

  const std::vector<std::string>& names() const { return names_; }
  const std::vector<Vec3>& places() const { return places_; }
  /// What a user should know: probes that sit on a contact or a crack.
  const std::vector<std::string>& notes() const { return notes_; }
  /// One value per probe from a field of the owned points, on every rank; the same bits on any number of ranks.
  /// Collective.
  std::vector<double> sample(std::span<const double> field) const;
  /// The temperatures of the probes from the unknowns, as HeatSystem::values leaves them (ghosts up to date).
  /// Collective.
  std::vector<double> temperatures(std::span<const double> T) const;
  /// Adds this rank's part of the weights w of a probe to those of the local points: its temperature is w . u.
  void add_weights(int probe, std::span<double> w) const;

 private:
  void ask(const Dofs* dofs);
  void add(const Cloud& cloud, const Obstacles& obstacles, const Vec3& place, const std::string& name,
           const SourceLocation& in_case);

  std::vector<std::string> names_, notes_;
  std::vector<Vec3> places_;
  MPI_Comm comm_;
  struct Entry {
    int slot;   // place among the products of all probes, in the order they are summed
    int point;  // owned point of this rank
    double weight;
  };
  std::vector<Entry> entries_;
  std::vector<int> first_slot_;           // of every probe, and the number of all slots
  std::vector<int> own_;                  // probes next to points of this rank
  std::optional<SparseRows> value_rows_;  // of these
};

/// The place, m, that a key of a case gives by as many lengths as the body has dimensions.
Vec3 place_of(const Table& table, const std::string& key, const Cloud& cloud);
/// The smallest spacing of all points, m. Collective.
double finest_spacing(const Cloud& cloud);

void declare_probes(Schema& schema);

}  // namespace calor
