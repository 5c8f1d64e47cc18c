// Sources through the whole body along an axis, the thickness of a plate: a Gaussian column, and a line as narrow as
// the points can tell, spread evenly over one spacing around its position. The temperature on a line has no limit as
// the spacing shrinks; farther away it has.
#include <cmath>

#include "source/source_profile.hpp"

namespace calor {

SourceProfileKind line_profile() {
  return {.name = "line",
          .sentence =
              "A line of heat through the body along an axis: through the thickness of a plate. Its power is "
              "spread over one spacing",
          .keys = {{"along", Kind::choice, "", "z", "Axis of the line in 3D.", {"x", "y", "z"}}},
          .make = [](const Table& line, const Cloud& cloud) -> SourceProfile {
            const AxisProfile narrow = AxisProfile::box(0);  // as the spacing on its path allows
            return {.along = narrow, .across = narrow, .is_round = true, .axis = axis_through(line, cloud.dimension)};
          }};
}

/// Q = q / (2 pi sigma^2 h) exp(-r^2 / (2 sigma^2)), h the thickness.
SourceProfileKind column_profile() {
  return {.name = "column",
          .sentence = "A Gaussian column through the body along an axis: through the thickness of a plate",
          .keys = sigma_keys({{"along", Kind::choice, "", "z", "Axis of the column in 3D.", {"x", "y", "z"}}}),
          .make = [](const Table& column, const Cloud& cloud) -> SourceProfile {
            const double sigma = sigma_of(column);
            return {.along = AxisProfile::gaussian(sigma),
                    .across = AxisProfile::gaussian(sigma),
                    .is_round = true,
                    .axis = axis_through(column, cloud.dimension),
                    .radius = std::sqrt(6) * sigma,
                    .sigma = sigma};
          }};
}

}  // namespace calor
