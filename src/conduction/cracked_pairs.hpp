#pragma once
// Pair weights of bodies with cracks, from the weights of the intact body. Two treatments:
// - Cracks that are open from the start are surface, and cut the pairs across (cut_weights.hpp), those with a contact
//   as far as it hinders heat: what it cuts conducts in series with it.
// - Cracks that open while running act on single pairs, whose weights stay those of the intact body: a failed pair
//   conducts no more, or in series with the contact. Always stable, of first order.
#include <memory>

#include "cloud/cracks.hpp"
#include "conduction/correction.hpp"
#include "conduction/method.hpp"
#include "conduction/mirror_images.hpp"
#include "conduction/pair_conduction.hpp"

namespace calor {

/// Conduction in a cracked body from the neighbours and consistent weights of the intact one. `report` gets the
/// numbers of the last correction. k: of the local points, W/(m K), beside which contacts hinder heat. Collective;
/// throws Error.
PairConduction cracked_pairs(const Cloud& cloud, const Parts& parts, const Cracks& cracks, Neighbours neighbours,
                             std::vector<double> G, std::span<const double> k, CorrectionReport& report);

/// Do images lie beyond walls off the points? Not where a crack would end at its own, nor where walls cut through the
/// parts of a lattice: there walls are in series with the way to them.
bool has_images(const Case& c, const Cloud& cloud, const Parts& parts);
/// find_mirrored_neighbours, or without images. Collective; throws Error.
MirroredNeighbours neighbours_of_body(const Case& c, const Cloud& cloud, const Parts& parts, const Support& support,
                                      const Conditions& conditions, bool insulated_too);

/// The discretisation of a pair method: for the [[crack]] entries of a case, which it notes in the log; without entries
/// from all pairs, images folded, with the directions that they conduct by. Collective; throws Error.
Discretisation with_cracks(const Case& c, const Cloud& cloud, const MaterialField& material,
                           const Conditions& conditions, MirroredNeighbours mirrored, std::vector<double> G,
                           Layers layers, CorrectionReport& done, MethodReport& report,
                           const PairDirections& directions = {});

}  // namespace calor
