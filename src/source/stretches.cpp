#include "source/stretches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "base/parallel.hpp"
#include "base/reduce.hpp"
#include "cloud/cells.hpp"

namespace calor {
namespace {

/// The path as straight lines, short segments taken together where they stay within `near` of a line.
std::vector<Stretch> coarse(const Path& path, double near) {
  std::vector<Stretch> lines;
  for (const Path::Segment& p : path.segments()) {
    const bool heats = path.is_heated(p);
    const bool continues = !lines.empty() && lines.back().to == p.from && lines.back().heats == heats &&
                           norm(p.to - lines.back().from) < near;
    if (continues)
      lines.back().to = p.to;
    else
      lines.push_back({.from = p.from, .to = p.to, .begin = p.begin, .heats = heats});
  }
  return lines;
}

/// Finds the spacings of the points of this rank that are touched from the lines.
void find_spacings(std::vector<Stretch>& lines, const Cloud& cloud, double radius, double widest,
                   const std::array<bool, 3>& varies) {
  constexpr double rounding = 1e-9;  // spacings
  const double near = radius + (1 + rounding) * widest;
  const Bounds bounds = bounds_of(cloud.owned_points());
  for (Stretch& line : lines) {
    const Vec3 &a = line.from, &b = line.to;
    bool is_far = false;
    for (int axis = 0; axis < 3; ++axis)
      is_far = is_far || (varies[axis] && (std::max(a[axis], b[axis]) < bounds.low[axis] - near ||
                                           std::min(a[axis], b[axis]) > bounds.high[axis] + near));
    if (is_far) continue;
    const Vec3 way = b - a;
    const double square = dot(way, way);
    for (int i = 0; i < cloud.owned; ++i) {
      const double s = square > 0 ? std::clamp(dot(cloud.x[i] - a, way) / square, 0.0, 1.0) : 0;
      Vec3 r = cloud.x[i] - (a + s * way);
      for (int axis = 0; axis < 3; ++axis) r[axis] *= varies[axis];
      if (norm(r) <= radius + (1 + rounding) * cloud.spacing[i])
        line.spacing = std::max(line.spacing, cloud.spacing[i]);
    }
  }
}

}  // namespace

std::vector<Stretch> stretches_of(const Path& path, const Cloud& cloud, double radius,
                                  const std::array<bool, 3>& varies) {
  const ValueRange spacing = range_of(std::span<const double>(cloud.spacing).first(cloud.owned));
  const double least = min(cloud.comm, spacing.low), widest = max(cloud.comm, spacing.high);
  std::vector<Stretch> lines = coarse(path, 0.5 * (radius + least));
  find_spacings(lines, cloud, radius, widest, varies);
  return lines;
}

std::vector<std::string> notes_on_path(const std::vector<Stretch>& lines, const std::string& source, double end,
                                       MPI_Comm comm) {
  std::vector<std::int64_t> touching(lines.size());
  for (std::size_t n = 0; n < lines.size(); ++n) touching[n] = lines[n].spacing > 0;
  add_up(comm, touching);
  std::size_t heating = 0, beside = 0, late = 0;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    if (!lines[n].heats) continue;
    ++heating, beside += touching[n] == 0, late += lines[n].begin >= end;
  }
  std::vector<std::string> notes;
  const auto part = [&](std::size_t some) {
    return some == heating ? std::string("its path") : fmt::format("{} of the {} lines of its path", some, heating);
  };
  if (beside > 0) notes.push_back(fmt::format("the source '{}' does not touch the body on {}", source, part(beside)));
  if (late > 0)
    notes.push_back(
        fmt::format("the source '{}' begins {} no earlier than the run ends, at {:g} s", source, part(late), end));
  return notes;
}

}  // namespace calor
