#pragma once
// Points of prescribed temperature. The wall's reaction is what is missing between the enthalpy that the heat balance
// alone gives a point and the one that belongs to its temperature.
#include <memory>
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "conduction/capacity.hpp"
#include "conduction/constraint.hpp"
#include "conduction/dofs.hpp"

namespace calor {

/// The constraint of [boundary.*] temperatures on points, as the degrees of freedom take it; null where no point of any
/// rank has one. All arguments must outlive it. Collective.
std::unique_ptr<Constraint> prescribed_points(const Cloud& cloud, std::span<const PrescribedTerm> temperatures,
                                              Dofs& dofs, Capacity& capacity);

/// Owned points that the terms prescribe, ascending.
std::vector<int> points_of(std::span<const PrescribedTerm> temperatures);

}  // namespace calor
