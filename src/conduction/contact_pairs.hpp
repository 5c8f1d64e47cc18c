#pragma once
// Pairs beside contacts that run between the points of a cloud in any way (Solids::sides).
#include <optional>
#include <string>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/correction.hpp"
#include "material/material_field.hpp"

namespace calor {

/// Do contacts end the cells of the cloud between its points?
bool contacts_end_cells(const Cloud& cloud);

/// Changes the weights G of the whole body such that each side of a contact conducts along it by itself, as beside a
/// cut, as far as the contact hinders heat. The pairs across hand over the heat that crosses, in series with the
/// contact. On each side all together are exact for linear temperatures. Where a side has no such weights, as one row
/// of points between two contacts, G stays as it is, and a note says so. Collective; throws Error. `material` at T (K)
/// tells how much of a pair's resistance is the contact's.
std::optional<std::string> cut_at_contacts(const Cloud& cloud, const MaterialField& material, double T,
                                           const Neighbours& neighbours, std::vector<double>& G,
                                           CorrectionReport& report);

/// The share of its flux that a pair still conducts across a contact. K: conductivity between the points, W/(m K);
/// `h_length`: conductance of the contact times |x_ji . n|.
inline double conducted_by_contact(double K, double h_length) { return h_length / (K + h_length); }

}  // namespace calor
