#include "output/quantities.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.hpp"

namespace calor {

Registry<Quantity>& quantities() {
  static Registry<Quantity> all{
      temperature_quantity(),      conductivity_quantity(),  heat_capacity_quantity(), volume_fraction_quantity(),
      peak_temperature_quantity(), cooling_time_quantity(),  extent_quantity(),        average_temperature_quantity(),
      heat_flow_quantity(),        mean_quantity(),          minimum_quantity(),       maximum_quantity(),
      stress_quantity(),           radial_stress_quantity(), hoop_stress_quantity(),   lowest_stress_quantity(),
      highest_stress_quantity(),   strain_quantity(),        curvature_quantity()};
  return all;
}

const Quantity& quantity_of(const Table& table) {
  if (!table.has("quantity"))
    for (const Quantity& q : quantities())
      if (table.has(q.name)) return q;
  return quantities().chosen(table, "quantity");
}

void require_name(const Table& table, const std::string& key, const std::string& what,
                  const std::vector<std::string>& known) {
  const std::string name = table.text(key);
  if (std::ranges::count(known, name)) return;
  const std::string near = nearest(name, known);
  table.refuse(
      key, fmt::format("there is no {} '{}'", what, name),
      near.empty() ? fmt::format("there are {}", fmt::join(known, ", ")) : fmt::format("did you mean '{}'?", near));
}

}  // namespace calor
