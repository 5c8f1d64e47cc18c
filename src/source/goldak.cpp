// The double ellipsoid of Goldak, Chakravarti & Bibby, Metall. Trans. B 15 (1984) 299:
//   Q = 6 sqrt(3) f q / (a b c pi sqrt(pi)) exp(-3 (xi^2/c^2 + eta^2/a^2 + zeta^2/b^2)),   zeta >= 0 into the body,
// with c and f of the front for xi > 0 and of the rear behind; f_f + f_r = 2, and f = 2 c / (c_f + c_r) makes Q
// continuous.
#include <algorithm>
#include <cmath>

#include "source/kinds.hpp"
#include "source/moving_source.hpp"

namespace calor {

const SourceKind goldak_source = {
    .key = "goldak",
    .declare =
        [](Schema& schema) {
          schema.add({.path = "source.*",
                      .sentence = "Goldak's double ellipsoid.",
                      .keys = {{"goldak", Kind::table, "", optional, "Goldak's double ellipsoid."}}});
          schema.add(
              {.path = "source.*.goldak",
               .sentence =
                   "Goldak's double ellipsoid in a body of three dimensions. Its semi-axes are where the heat per "
                   "volume has fallen to 5 %: sqrt(6) standard deviations. Its place is the middle of the surface.",
               .keys = {
                   {"width", Kind::quantity, "m", required, "Semi-axis across the motion."},
                   {"depth", Kind::quantity, "m", required, "Semi-axis into the body."},
                   {"front", Kind::quantity, "m", required, "Semi-axis ahead."},
                   {"rear", Kind::quantity, "m", required, "Semi-axis behind."},
                   {"into", Kind::choice, "", "-z", "Direction into the body.", {"x", "-x", "y", "-y", "z", "-z"}}}});
        },
    .make = [](const std::string& name, const Table& table, const Cloud& cloud) -> std::unique_ptr<Source> {
      const Table goldak = table.sub("goldak");
      if (cloud.dimension != 3)
        table.refuse("goldak", "a double ellipsoid needs a body of three dimensions", "take 'column' in a plate");
      const Direction into = direction_of(goldak, "into", 3);
      const auto sigma = [&](const char* key) { return positive_length(goldak, key) / std::sqrt(6); };
      const double front = sigma("front"), rear = sigma("rear"), width = sigma("width"), depth = sigma("depth");
      return make_moving_source(name, table, cloud,
                                {.along = SourceProfile::gaussian(front, rear, front / (front + rear)),
                                 .across = SourceProfile::gaussian(width),
                                 .is_round = front == rear && front == width,
                                 .axis = into.axis,
                                 .into = into.sign,
                                 .depth = SourceProfile::gaussian(depth, depth, 1),
                                 .radius = std::sqrt(6) * std::min({front, rear, width, depth}),
                                 .sigma = std::min(front, rear)});
    }};

}  // namespace calor
