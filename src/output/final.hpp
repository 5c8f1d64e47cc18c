#pragma once
// The end of a run, for a run that starts from it.
#include <span>
#include <string>

#include "cloud/cloud.hpp"

namespace calor {

/// Writes final.csv (id,x [m],y [m],z [m],T [K]) with all digits; ranks write in turn. T: owned points. An empty folder
/// writes nothing. Throws Error(file). Collective.
void write_final(const Cloud& cloud, std::span<const double> T, const std::string& folder);

}  // namespace calor
