#pragma once
// Where heat enters by a section of [boundary.*] or by a source on faces: the parts of facets, or of a plate's cells.
#include <optional>
#include <span>
#include <vector>

#include "base/function.hpp"
#include "cloud/cell_integrals.hpp"

namespace calor {

/// Places of this rank, each with a piece of area.
struct Segments {
  std::vector<int> point;    ///< owned points
  std::vector<int> facet;    ///< index into Cloud::facets; none on the faces of a plate
  std::vector<double> area;  ///< m^2
  std::vector<Vec3> x;       ///< of the place; of the point where segments are whole facets
};

/// What is selected of faces, or of a plate.
struct Selection {
  std::vector<int> facets;          ///< indices into Cloud::facets
  int plate = 0;                    ///< instead: how many faces of a plate, each as large as the cells
  std::optional<Function> where{};  ///< not 0 where it holds; nothing: everywhere
};

/// One entry a facet that is selected, wholly or in part. Throws Error where the formula fails.
Segments selected_facets(const CellIntegrals& integrals, const Cloud& cloud, const Selection& selection);
/// Entries at the places of a quadrature that follows the jumps of the selection and of f. Throws Error.
Segments selected_places(const CellIntegrals& integrals, const Cloud& cloud, const Selection& selection,
                         const Integrand& f);

}  // namespace calor
