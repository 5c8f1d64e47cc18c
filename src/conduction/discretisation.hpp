#pragma once
// What a method makes of a cloud: the terms of conduction, the degrees of freedom and what they hold. Nothing that
// takes it asks which method made it.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cell_samples.hpp"
#include "conduction/capacity.hpp"
#include "conduction/constraint.hpp"
#include "conduction/dofs.hpp"
#include "conduction/heat_term.hpp"
#include "conduction/wall_layers.hpp"

namespace calor {

struct Discretisation {
  std::unique_ptr<Conduction> conduction;        ///< between the points
  std::vector<std::unique_ptr<HeatTerm>> walls;  ///< heat through walls of prescribed temperature that no point holds
  std::vector<std::unique_ptr<Constraint>> constraints;  ///< in the order in which they are imposed
  std::unique_ptr<WallLayers> wall_layers;               ///< between points and walls; null: a point's own part alone
  std::unique_ptr<Dofs> dofs;
  std::unique_ptr<Capacity> capacity;
  /// Where properties are wanted besides the nodes: these are the locations 1, 2, ... of an Evaluation.
  std::vector<const QuadraturePoints*> locations;
  /// The subdomains of the owned points, over which sources are integrated; null: the points' cells.
  std::unique_ptr<CellSamples> subdomains;
  /// Are all weights of the conduction positive, so that it takes no temperature above or below those around it?
  bool weights_are_positive = false;
  std::vector<std::string> notes;  ///< what a user should know about it
};

/// For methods whose degrees of freedom are the temperatures of points that hold the heat of their cells: adds to
/// their conduction what is the same for all. `massless`: rows of points that hold no heat, or null; `layers`: see
/// Discretisation. Collective.
Discretisation nodal_discretisation(const Cloud& cloud, const Conditions& conditions,
                                    std::unique_ptr<Conduction> conduction,
                                    std::vector<std::unique_ptr<HeatTerm>> walls = {},
                                    std::unique_ptr<Constraint> massless = {}, std::unique_ptr<WallLayers> layers = {});

/// A note where the conductivities of neighbours in one part differ by more than a factor of 3: a formula that jumps,
/// at an interface that nobody knows of. `T` of the owned points, K. Collective.
std::optional<std::string> note_of_jumps(const Cloud& cloud, const Conduction& conduction,
                                         const MaterialField& material, std::span<const double> T);

}  // namespace calor
