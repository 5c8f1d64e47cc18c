#pragma once
// Pair weights of a body that surfaces cut, from those of the whole body: cracks that insulate, and contacts between
// parts. The pairs across are cut. What they carried along the faces is given back to the pairs that are left, so that
// heat runs beside the cut as in the rest of the body; what they carried across becomes the area vectors of the faces,
// equal and opposite; then the weights are made consistent again. Without these areas that last step would heal the
// cut: the remaining pairs would take over what the others carried.
#include <vector>

#include "cloud/cracks.hpp"
#include "conduction/correction.hpp"

namespace calor {

/// Surfaces inside the body, and the pairs that cross them, sorted by entry.
struct SurfaceCuts {
  struct Surface {
    bool is_full;  ///< it cuts right through, or closes: each of its sides is in balance
    /// By the pairs that are cut, which know the areas of the faces: what a side lacks in balance is made up along
    /// them.
    bool heat_crosses;
  };
  std::vector<Surface> surfaces;
  std::vector<Crossing> crossings;  ///< Crossing::crack: of which surface
  /// Of every crossing: area of the surface there over that of the pairs across, sum G |x_ji . n|: 1 on planes, more
  /// where pairs cross a curved surface twice and so have the rest.
  std::vector<double> area_over_pair;
  /// Of every crossing: the share of its flux in an unbroken body that a cut pair still conducts, 0 where no heat
  /// crosses: as much of its force stays on the faces, along them too.
  std::vector<double> conducts;
};

/// What is left of the pairs: those that no surface cuts as a whole.
struct CutWeights {
  Neighbours neighbours;
  std::vector<double> G;
};

/// `neighbours` and G: consistent, of the whole body. `report` gets the numbers of the last correction. Collective;
/// throws Error.
CutWeights cut_weights(const Cloud& cloud, const SurfaceCuts& cuts, const Neighbours& neighbours, std::vector<double> G,
                       CorrectionReport& report);

}  // namespace calor
