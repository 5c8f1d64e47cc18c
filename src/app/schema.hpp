#pragma once
// All of calor's keys: one line per module.
#include "case/schema.hpp"

namespace calor {

/// The keys of all rooms; what was added to a registry is among them.
Schema schema();
/// [fit] and [study].
void declare_studies(Schema& schema);

}  // namespace calor
