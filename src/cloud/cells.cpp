#include "cloud/cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace calor {

Bounds bounds_of(std::span<const Vec3> x) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  Bounds b{{inf, inf, inf}, {-inf, -inf, -inf}};
  for (const Vec3& p : x) {
    for (int a = 0; a < 3; ++a) {
      b.low[a] = std::min(b.low[a], p[a]);
      b.high[a] = std::max(b.high[a], p[a]);
    }
  }
  return b;
}

Cells::Cells(std::span<const Vec3> x, const Vec3& asked) {
  if (x.empty()) return;
  const Bounds b = bounds_of(x);
  low_ = b.low;
  const double most = 4.0 * static_cast<double>(x.size()) + 64;
  std::array<double, 3> n;
  Vec3 size = asked;
  for (;; size *= 1.2) {
    for (int a = 0; a < 3; ++a) n[a] = std::floor((b.high[a] - b.low[a]) / size[a] + 0.5) + 1;
    if (n[0] * n[1] * n[2] <= most) break;
  }
  for (int a = 0; a < 3; ++a)
    along_[a] = static_cast<std::int64_t>(n[a]), last_[a] = n[a] - 1, inverse_[a] = 1 / size[a];
}

CellOrder order_by_cells(const Cells& cells, std::span<const Vec3> x, std::span<const std::int32_t> first) {
  CellOrder out;
  out.start.assign(cells.count() + 1, 0);
  std::vector<std::int32_t> cell(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    cell[i] = static_cast<std::int32_t>(cells.cell(x[i]));
    ++out.start[cell[i] + 1];
  }
  for (std::size_t c = 1; c < out.start.size(); ++c) out.start[c] += out.start[c - 1];
  out.order.resize(x.size());
  for (std::size_t n = 0; n < x.size(); ++n) {
    const std::int32_t i = first.empty() ? static_cast<std::int32_t>(n) : first[n];
    out.order[out.start[cell[i]]++] = i;
  }
  // Every start has moved to the start of the next cell.
  std::copy_backward(out.start.begin(), out.start.end() - 1, out.start.end());
  out.start[0] = 0;
  return out;
}

}  // namespace calor
