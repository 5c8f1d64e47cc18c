#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "cloud/cells.hpp"
#include "cloud/cloud.hpp"

namespace calor {

CloudCheck check(const Cloud& cloud) {
  Bounds box = bounds_of(cloud.owned_points());
  for (int a = 0; a < 3; ++a) {
    box.low[a] = min(cloud.comm, box.low[a]);
    box.high[a] = max(cloud.comm, box.high[a]);
  }
  const Vec3 middle = 0.5 * (box.low + box.high);
  const double size = norm(box.high - box.low);

  constexpr int columns = 8;  // V, |A|, A, x cross A
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(columns) * cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3& A = cloud.area[i];
    const Vec3 moment = cross(cloud.x[i] - middle, A);
    values.insert(values.end(), {cloud.volume[i], norm(A), A.x, A.y, A.z, moment.x, moment.y, moment.z});
  }
  const std::vector<double> s = sums(cloud.comm, values, columns);
  const double area = s[1] > 0 ? s[1] : 1;
  return {.volume = s[0],
          .volume_error = cloud.exact.volume > 0 ? std::abs(s[0] - cloud.exact.volume) / cloud.exact.volume : 0,
          .area_sum = norm({s[2], s[3], s[4]}) / area,
          .moment_sum = size > 0 ? norm({s[5], s[6], s[7]}) / (area * size) : 0};
}

}  // namespace calor
