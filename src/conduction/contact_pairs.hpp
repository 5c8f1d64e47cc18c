#pragma once
// Pairs beside contacts that run between the points of a cloud in any way (Solids::sides).
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/correction.hpp"
#include "geometry/parts.hpp"

namespace calor {

/// Do contacts end the cells of the cloud between its points?
bool contacts_end_cells(const Cloud& cloud);

/// Changes the weights G of the whole body such that each side of a contact conducts along it by itself, as beside a
/// cut. The pairs across keep theirs: they hand over the heat that crosses, in series with the contact. On each side
/// the two together are exact for linear temperatures. Collective; throws Error.
void cut_at_contacts(const Cloud& cloud, const Parts& parts, const Neighbours& neighbours, std::vector<double>& G,
                     CorrectionReport& report);

}  // namespace calor
