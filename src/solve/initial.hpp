#pragma once
// The temperature at the start: a number, a formula, a CSV file, or the end of another result.
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// Temperatures of the owned points, K; empty on all ranks where the case has no [initial] and needs none ([steady]).
/// Collective; throws Error.
std::vector<double> initial_temperatures(const Case& c, const Cloud& cloud);

void declare_initial(Schema& schema);

}  // namespace calor
