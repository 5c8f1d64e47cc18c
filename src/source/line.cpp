// A line of heat through the body: as narrow as the points can tell, spread evenly over one spacing around its place.
// Its temperature there has no limit as the spacing shrinks; farther away it has.
#include <algorithm>

#include "base/parallel.hpp"
#include "source/kinds.hpp"
#include "source/moving_source.hpp"

namespace calor {

const SourceKind line_source = {
    .key = "line",
    .declare =
        [](Schema& schema) {
          schema.add({.path = "source.*",
                      .sentence = "A line through the body.",
                      .keys = {{"line", Kind::table, "", optional, "A line of heat along an axis."}}});
          schema.add({.path = "source.*.line",
                      .sentence =
                          "A line of heat through the body along an axis: through the thickness of a plate. Its "
                          "power is spread over one spacing.",
                      .keys = {{"along", Kind::choice, "", "z", "Axis of the line in 3D.", {"x", "y", "z"}}}});
        },
    .make = [](const std::string& name, const Table& table, const Cloud& cloud) -> std::unique_ptr<Source> {
      const Table line = table.sub("line");
      double spacing = 0;
      for (int i = 0; i < cloud.owned; ++i) spacing = std::max(spacing, cloud.spacing[i]);
      const SourceProfile narrow = SourceProfile::box(max(cloud.comm, spacing));
      return make_moving_source(
          name, table, cloud,
          {.along = narrow, .across = narrow, .is_round = true, .axis = axis_through(line, cloud.dimension)});
    }};

}  // namespace calor
