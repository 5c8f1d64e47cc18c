#pragma once
// What an [[expect]] can compare: temperatures, properties, results of welds, the balance. A quantity is one function
// and one line in a registry.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/registry.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "material/material_field.hpp"
#include "output/balance.hpp"
#include "output/probes.hpp"
#include "output/weld.hpp"

namespace calor {

class ThermalStress;

/// What quantities are computed from. It outlives what is made of it.
struct Results {
  const Cloud& cloud;
  const MaterialField& material;
  const Probes& probes;
  std::shared_ptr<const WeldResults> weld = {};      ///< null where the case has no [weld]
  std::shared_ptr<const Balance> balance = {};       ///< null where no balance is kept
  std::shared_ptr<const ThermalStress> stress = {};  ///< null where the case has no [stress]
};

/// Computes the quantity of one [[expect]]. Collective; throws Error.
struct Measure {
  /// At the owned points, or the one number of the body. T: temperatures of the owned points, K.
  std::function<std::vector<double>(const State&, std::span<const double> T)> values;
  /// At the probes; where absent, the values at the points are interpolated.
  std::function<std::vector<double>(const State&)> at_probes = {};
};

struct Quantity {
  std::string name;
  std::string plural;          ///< in sentences
  std::string unit;            ///< SI
  std::string column;          ///< its name in the files of compared points
  bool is_of_body = false;     ///< one number, rather than one a point
  std::vector<Key> keys = {};  ///< of its [[expect]], besides the value
  /// Refuses what the results do not have. Collective.
  std::function<Measure(const Table& expect, const Results&)> make;
};

Registry<Quantity>& quantities();
/// The quantity of an [[expect]]: named, or chosen by a key of its name.
const Quantity& quantity_of(const Table& table);
/// Refuses the name that `key` gives where it is none of those known.
void require_name(const Table& table, const std::string& key, const std::string& what,
                  const std::vector<std::string>& known);

// The quantities, those of a kind in one file.
Quantity temperature_quantity();
Quantity conductivity_quantity();
Quantity heat_capacity_quantity();
Quantity volume_fraction_quantity();
Quantity peak_temperature_quantity();
Quantity cooling_time_quantity();
Quantity extent_quantity();
Quantity average_temperature_quantity();
Quantity heat_flow_quantity();
Quantity mean_quantity();
Quantity minimum_quantity();
Quantity maximum_quantity();
Quantity stress_quantity();
Quantity radial_stress_quantity();
Quantity hoop_stress_quantity();
Quantity lowest_stress_quantity();
Quantity highest_stress_quantity();
Quantity strain_quantity();
Quantity curvature_quantity();

}  // namespace calor
