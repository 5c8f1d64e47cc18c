#pragma once
// Plane walls of cell-centred boxes ("fictitious layers"): the body goes on beyond them as its mirror image. The
// weights are then made as if there were no wall, and the images are folded back: beyond an insulated wall an image has
// the temperature of its point, beyond a wall of prescribed temperature T* it is 2 T* less that (odd reflection). Where
// heat fluxes enter, no images lie, and the wall keeps its boundary area.
#include <array>
#include <memory>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/discretisation.hpp"
#include "conduction/pair_conduction.hpp"
#include "conduction/wall_terms.hpp"

namespace calor {

/// Temperature of the images beyond walls of prescribed temperature T*: 2 T* - T of the point, which puts T* on the
/// wall, or T* in the whole layer, which is of first order only.
enum class Layers { odd, constant };

struct MirroredNeighbours {
  Neighbours neighbours;
  /// Of every image, in the order of the entries: for every axis across which it lies the condition of the wall it is
  /// seen through (see WallSection::condition); `not_across` for the other axes.
  std::vector<std::array<int, 3>> walls = {};
  static constexpr int not_across = -3;
};

/// Neighbours with the images beyond walls of prescribed temperature and, with `insulated_too`, of insulated walls. An
/// image is seen through the wall at the place where the bond crosses it, so that both ends agree on its condition.
/// Clouds with points on the walls have no images. Collective; throws Error.
MirroredNeighbours find_mirrored_neighbours(const Cloud& cloud, const Support& support, const Conditions& conditions,
                                            bool insulated_too);

struct PairTerms {
  std::unique_ptr<PairConduction> pairs;
  std::unique_ptr<ImageConduction> images;  ///< null where no rank has images beyond walls of prescribed temperature
};

/// The terms of the weights of all pairs, images included. `temperatures` must outlive them. Collective.
PairTerms fold_images(const Cloud& cloud, const Parts& parts, MirroredNeighbours mirrored, std::vector<double> G,
                      Layers layers, std::span<const PrescribedTerm> temperatures,
                      const PairDirections& directions = {});

/// The same as a discretisation.
Discretisation pair_discretisation(const Cloud& cloud, const Parts& parts, const Conditions& conditions,
                                   MirroredNeighbours mirrored, std::vector<double> G, Layers layers,
                                   const PairDirections& directions = {});

}  // namespace calor
