#pragma once
// Where heat enters by a section of [boundary.*]: the parts of facets, or of a plate's cells, on which it holds.
#include <optional>
#include <span>
#include <vector>

#include "base/function.hpp"
#include "boundary/conditions.hpp"
#include "cloud/cell_integrals.hpp"

namespace calor {

/// Places of this rank, each with a piece of area.
struct Segments {
  std::vector<int> point;    ///< owned points
  std::vector<int> facet;    ///< index into Cloud::facets; none on the faces of a plate
  std::vector<double> area;  ///< m^2
  std::vector<Vec3> x;       ///< of the place; of the point where nothing depends on the place
};

/// What a section selects.
struct Selection {
  std::span<const int> facets;           ///< of its faces
  const std::optional<Function>& where;  ///< not 0 where it holds; nothing: everywhere
};

/// One entry a facet that is selected in part: for fluxes that are the same everywhere on it. Throws Error.
Segments selected_facets(const CellIntegrals& integrals, const Cloud& cloud, const Selection& selection);
/// Entries at the places of a quadrature that follows the jumps of the selection and of the flux. Throws Error.
Segments selected_facets(const CellIntegrals& integrals, const Cloud& cloud, const Selection& selection,
                         const SurfaceFlux& flux);
/// The same of the cells of a plate of which `faces` faces, 1 or 2, belong to the section.
Segments selected_plate(const CellIntegrals& integrals, const Cloud& cloud, int faces,
                        const std::optional<Function>& where);
Segments selected_plate(const CellIntegrals& integrals, const Cloud& cloud, int faces,
                        const std::optional<Function>& where, const SurfaceFlux& flux);

}  // namespace calor
