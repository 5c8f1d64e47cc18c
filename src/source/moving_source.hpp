#pragma once
// Sources that are small and may move. Heat goes in as means over the cells of the points, and its sum is the power
// asked for.
#include <memory>
#include <string>

#include "source/source.hpp"
#include "source/source_profile.hpp"

namespace calor {

/// The source of [source.NAME] with its power and path, in a run to time `end`, s. Warns where the cloud is too coarse
/// for it, and of what of its path lies beside the body or after the end; refuses one that never touches the body, and
/// a bad efficiency. The cloud must outlive it. Collective; throws Error.
std::unique_ptr<Source> make_moving_source(const std::string& name, const Table& table, const Cloud& cloud,
                                           const SourceProfile& profile, double end);

}  // namespace calor
