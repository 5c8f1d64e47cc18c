// A Gaussian column through the body: Q = q / (2 pi sigma^2 h) exp(-r^2 / (2 sigma^2)), h the thickness.
#include <cmath>

#include "source/kinds.hpp"
#include "source/moving_source.hpp"

namespace calor {

const SourceKind column_source = {
    .key = "column",
    .declare =
        [](Schema& schema) {
          schema.add({.path = "source.*",
                      .sentence = "A Gaussian column through the body.",
                      .keys = {{"column", Kind::table, "", optional, "A Gaussian column along an axis."}}});
          std::vector<Key> keys = sigma_keys();
          keys.push_back({"along", Kind::choice, "", "z", "Axis of the column in 3D.", {"x", "y", "z"}});
          schema.add({.path = "source.*.column",
                      .sentence = "A Gaussian column through the body along an axis: through the thickness of a plate.",
                      .keys = keys});
        },
    .make = [](const std::string& name, const Table& table, const Cloud& cloud) -> std::unique_ptr<Source> {
      const Table column = table.sub("column");
      const double sigma = sigma_of(column);
      return make_moving_source(name, table, cloud,
                                {.along = SourceProfile::gaussian(sigma),
                                 .across = SourceProfile::gaussian(sigma),
                                 .is_round = true,
                                 .axis = axis_through(column, cloud.dimension),
                                 .radius = std::sqrt(6) * sigma,
                                 .sigma = sigma});
    }};

}  // namespace calor
