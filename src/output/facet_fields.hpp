#pragma once
// What a run tells of the parts of the body and of its surface.
#include <span>
#include <vector>

#include "output/vtu.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// Of every owned point the part of the body that fills most of its cell, by its material. Throws Error, maybe on one
/// rank alone.
Label part_of_points(const HeatSystem& system);

/// Of every facet of this rank the section of [boundary.*] that holds there; -1: insulated. Throws Error, maybe on one
/// rank alone.
Label condition_of_facets(const HeatSystem& system);

/// Heat flux into the body through the facets of this rank, W/m^2: that of the condition at the temperatures `T` of the
/// facets (HeatSystem::wall_temperatures); where the temperature is prescribed, what the body conducts away at the
/// point, whose heat flux vector is in `q`. So the fluxes of a section with `flux`, `convection` or `radiation` add up
/// to its heat flow. `condition`: see condition_of_facets. Throws Error, maybe on one rank alone.
std::vector<double> heat_flux_of_facets(const HeatSystem& system, double t, const Label& condition,
                                        std::span<const double> T, std::span<const Vec3> q);

}  // namespace calor
