#include "conduction/discretisation.hpp"

#include <utility>

#include "conduction/constraint.hpp"

namespace calor {

Discretisation nodal_discretisation(const Cloud& cloud, const Conditions& conditions,
                                    std::unique_ptr<Conduction> conduction,
                                    std::vector<std::unique_ptr<HeatTerm>> walls,
                                    std::unique_ptr<Constraint> massless) {
  std::vector<double> volume(cloud.volume.begin(), cloud.volume.begin() + cloud.owned);
  if (massless)
    for (const int i : massless->points()) volume[i] = 0;
  Discretisation d;
  if (conduction->ends()) d.locations.push_back(conduction->ends());
  d.conduction = std::move(conduction), d.walls = std::move(walls);
  d.dofs = std::make_unique<Dofs>(cloud);
  d.capacity = std::make_unique<LumpedCapacity>(std::move(volume));
  if (auto prescribed = prescribed_points(cloud, conditions.temperatures, *d.dofs, *d.capacity))
    d.constraints.push_back(std::move(prescribed));
  if (massless) d.constraints.push_back(std::move(massless));
  return d;
}

}  // namespace calor
