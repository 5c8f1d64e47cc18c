// The double ellipsoid of Goldak, Chakravarti & Bibby, Metall. Trans. B 15 (1984) 299:
//   Q = 6 sqrt(3) f q / (a b c pi sqrt(pi)) exp(-3 (xi^2/c^2 + eta^2/a^2 + zeta^2/b^2)),   zeta >= 0 into the body,
// with c and f of the front for xi > 0 and of the rear behind; f_f + f_r = 2, and f = 2 c / (c_f + c_r) makes Q
// continuous.
#include <algorithm>
#include <cmath>

#include "case/lengths.hpp"
#include "source/source_profile.hpp"

namespace calor {

SourceProfileKind goldak_profile() {
  return {.name = "goldak",
          .sentence =
              "Goldak's double ellipsoid in a body of three dimensions. Its semi-axes are where the heat per volume "
              "has fallen to 5 %: sqrt(6) standard deviations. Its position is the middle of the surface",
          .keys = {{"width", Kind::quantity, "m", required, "Semi-axis across the motion."},
                   {"depth", Kind::quantity, "m", required, "Semi-axis into the body."},
                   {"front", Kind::quantity, "m", required, "Semi-axis ahead."},
                   {"rear", Kind::quantity, "m", required, "Semi-axis behind."},
                   {"into", Kind::choice, "", "-z", "Direction into the body.", {"x", "-x", "y", "-y", "z", "-z"}}},
          .make = [](const Table& goldak, const Cloud& cloud) -> SourceProfile {
            if (cloud.dimension != 3)
              goldak.refuse("", "a double ellipsoid needs a body of three dimensions", "take 'column' in a plate");
            const std::string into = goldak.text("into");
            const auto sigma = [&](const char* key) { return positive_length(goldak, key) / std::sqrt(6); };
            const double front = sigma("front"), rear = sigma("rear"), width = sigma("width"), depth = sigma("depth");
            return {.along = AxisProfile::gaussian(front, rear, front / (front + rear)),
                    .across = AxisProfile::gaussian(width),
                    .is_round = front == rear && front == width,
                    .axis = into.back() - 'x',
                    .into = into.front() == '-' ? -1.0 : 1.0,
                    .depth = AxisProfile::gaussian(depth, depth, 1),
                    .radius = std::sqrt(6) * std::min({front, rear, width, depth}),
                    .sigma = std::min(front, rear)};
          }};
}

}  // namespace calor
