#include "cloud/search.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>

#include "base/lanes.hpp"

namespace calor {
namespace {

/// Of every set of eight lanes, one a bit: which they are, in ascending order.
constexpr auto lanes_of_bits = [] {
  std::array<std::array<std::uint8_t, 8>, 256> lanes{};
  for (std::size_t bits = 0; bits < lanes.size(); ++bits)
    for (std::uint8_t lane = 0, n = 0; lane < 8; ++lane)
      if (bits >> lane & 1) lanes[bits][n++] = lane;
  return lanes;
}();

/// Bit l: is flag l set?
template <int width>
CALOR_ALWAYS_INLINE inline std::uint32_t bits_of(const typename Vectors<width>::Flags& flags) {
  using Bytes __attribute__((vector_size(width))) = std::int8_t;
  const Bytes bytes = __builtin_convertvector(flags, Bytes);
  std::uint64_t all = 0;
  std::memcpy(&all, &bytes, sizeof bytes);
  return static_cast<std::uint32_t>((all & 0x8040201008040201) * 0x0101010101010101 >> 56);
}

/// Writes first + lane for the lanes of a set, and more that does not count, to out[0 .. 8).
CALOR_ALWAYS_INLINE inline void append_lanes(std::uint32_t bits, std::int32_t first, std::int32_t* out) {
  using Bytes __attribute__((vector_size(8))) = std::uint8_t;
  using Numbers __attribute__((vector_size(32))) = std::int32_t;
  Bytes lanes;
  std::memcpy(&lanes, lanes_of_bits[bits].data(), sizeof lanes);
  const Numbers numbers = __builtin_convertvector(lanes, Numbers) + first;
  std::memcpy(out, &numbers, sizeof numbers);
}

}  // namespace

Search::Search(const Cloud& cloud, const Support& support)
    : half_reach_(0.5 * support.over_spacing * (1 - 1e-9)),
      length_(support.length * (1 - 1e-9)),
      isotropic_(cloud.isotropic) {
  const std::size_t n = cloud.x.size();
  if (n == 0) return;
  for (const Vec3& s : cloud.metric)
    for (int a = 0; a < 3; ++a) largest_[a] = std::max(largest_[a], s[a]);
  for (auto* v : {&x_, &y_, &z_}) v->reserve(n + widest);
  if (isotropic_)
    d_.reserve(n + widest);
  else
    metric_.reserve(n);
  id_.reserve(n), local_.reserve(n);
  std::map<std::array<int, 3>, std::vector<std::int32_t>> members;
  const auto octave = [&](const Vec3& s, int a) {
    return s[a] > 0.5 * largest_[a] ? 0 : std::ilogb(largest_[a] / s[a]);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& s = cloud.metric[i];
    members[{octave(s, 0), octave(s, 1), octave(s, 2)}].push_back(static_cast<std::int32_t>(i));
  }
  for (const auto& [octaves, points] : members) add_class(cloud, points);
  for (auto* v : {&x_, &y_, &z_, &d_}) v->resize(v->size() + widest);
  const auto [least, most] = std::ranges::minmax(id_);
  if (most - least > std::numeric_limits<std::int32_t>::max()) return;
  short_id_.reserve(n);
  for (const std::int64_t id : id_) short_id_.push_back(static_cast<std::int32_t>(id - least));
}

void Search::add_class(const Cloud& cloud, std::span<const std::int32_t> members) {
  std::vector<Vec3> x;
  x.reserve(members.size());
  Vec3 sum, largest;
  for (std::int32_t i : members) {
    x.push_back(cloud.x[i]);
    sum += cloud.metric[i];
    for (int a = 0; a < 3; ++a) largest[a] = std::max(largest[a], cloud.metric[i][a]);
  }
  const Vec3 mean = (1 / static_cast<double>(x.size())) * sum;
  Class c{.largest = largest, .cells = Cells(x, mean), .start = {}, .rows = {}};
  CellOrder order = order_by_cells(c.cells, x);
  const auto before = static_cast<std::int32_t>(local_.size());
  c.start = std::move(order.start);
  for (std::int32_t& s : c.start) s += before;
  c.rows.resize(c.cells.along(1) * c.cells.along(2));
  for (std::int32_t k : order.order) {
    const std::int32_t i = members[k];
    const Vec3& p = cloud.x[i];
    x_.push_back(p.x), y_.push_back(p.y), z_.push_back(p.z);
    if (isotropic_)
      d_.push_back(cloud.spacing[i]);
    else
      metric_.push_back(cloud.metric[i]);
    id_.push_back(cloud.id[i]);
    local_.push_back(i);
    RowExtent& row = c.rows[c.cells.index(1, p.y) + c.cells.along(1) * c.cells.index(2, p.z)];
    row.y_low = std::min(row.y_low, p.y), row.y_high = std::max(row.y_high, p.y);
    row.z_low = std::min(row.z_low, p.z), row.z_high = std::max(row.z_high, p.z);
  }
  classes_.push_back(std::move(c));
}

std::span<std::int32_t> Search::find(const Vec3& p, const Vec3& metric, std::vector<std::int32_t>& buffer,
                                     int& coincident) const {
  Hits hits;
  for (const Class& c : classes_) search(c, p, metric, buffer, hits);
  coincident = hits.coincident;
  const std::size_t count = hits.count;
  const auto id = [&](std::int32_t k) { return id_[k]; };
  if (std::ranges::is_sorted(std::span(buffer).first(count), {}, id)) return std::span(buffer).first(count);
  if (count > most_counted || short_id_.empty()) {
    std::ranges::sort(std::span(buffer).first(count), {}, id);
    return std::span(buffer).first(count);
  }
  if (buffer.size() < 2 * count) buffer.resize(2 * count);
  sort_by_counting(std::span(buffer).first(count), std::span(buffer).subspan(count, count));
  return std::span(buffer).subspan(count, count);
}

/// The place of every one is the number of those with a lower id: some n^2 / 16 steps without a branch, faster than
/// sorting by exchanges.
void Search::sort_by_counting(std::span<const std::int32_t> found, std::span<std::int32_t> sorted) const {
  constexpr std::size_t room = most_counted + 2 * widest;
  std::array<std::int32_t, room> id, place;
  const std::size_t n = found.size();
  for (std::size_t k = 0; k < n; ++k) id[k] = short_id_[found[k]];
  std::fill_n(id.begin() + n, 2 * widest, 0);
  run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
    constexpr std::size_t lanes = 2 * width;
    using Numbers __attribute__((vector_size(4 * lanes))) = std::int32_t;
    for (std::size_t k = 0; k < n; k += lanes) {
      Numbers own, lower{};
      std::memcpy(&own, &id[k], sizeof own);
      for (std::size_t m = 0; m < n; ++m) lower -= id[m] < own;
      std::memcpy(&place[k], &lower, sizeof lower);
    }
  });
  for (std::size_t k = 0; k < n; ++k) sorted[place[k]] = found[k];
}

template <class Scan>
CALOR_ALWAYS_INLINE inline void Search::for_each_row(const Class& c, const Vec3& p, const Vec3& metric,
                                                     std::vector<std::int32_t>& buffer, const Hits& hits,
                                                     const Scan& scan) const {
  constexpr double rounding = 1 + 1e-12;
  const Vec3 far = reach(metric, c.largest);
  const double per_y = 1 / far.y, per_z = 1 / far.z;
  const Cells& cells = c.cells;
  const std::int64_t x_low = cells.index(0, p.x - far.x), x_high = cells.index(0, p.x + far.x);
  const std::int64_t y_low = cells.index(1, p.y - far.y), y_high = cells.index(1, p.y + far.y);
  const std::int64_t z_low = cells.index(2, p.z - far.z), z_high = cells.index(2, p.z + far.z);
  const std::int64_t along_x = cells.along(0), along_y = cells.along(1);
  for (std::int64_t z = z_low; z <= z_high; ++z) {
    const RowExtent* extent = c.rows.data() + along_y * z + y_low;
    const std::int32_t* start = c.start.data() + along_x * (along_y * z + y_low);
    for (std::int64_t y = y_low; y <= y_high; ++y, ++extent, start += along_x) {
      const RowExtent& e = *extent;
      const double gap_y = per_y * std::max(0.0, std::max(e.y_low - p.y, p.y - e.y_high));
      const double gap_z = per_z * std::max(0.0, std::max(e.z_low - p.z, p.z - e.z_high));
      if (!(gap_y * gap_y + gap_z * gap_z < rounding)) continue;
      const std::size_t most = hits.count + static_cast<std::size_t>(start[x_high + 1] - start[x_low]) + widest;
      if (buffer.size() < most) buffer.resize(2 * most);
      scan(start[x_low], start[x_high + 1], buffer.data());
    }
  }
}

void Search::search(const Class& c, const Vec3& p, const Vec3& metric, std::vector<std::int32_t>& buffer,
                    Hits& hits) const {
  if (!isotropic_) {
    for_each_row(c, p, metric, buffer, hits, [&](std::int32_t begin, std::int32_t end, std::int32_t* out) {
      scan_metric(begin, end, p, metric, out, hits);
    });
    return;
  }
  run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
    using Flags = typename Vectors<width>::Flags;
    Doubles<width> lane;
    for (int l = 0; l < width; ++l) lane[l] = l;
    Flags coincident{};
    // The rows are short: mostly one vector each.
    const double *x = x_.data(), *y = y_.data(), *z = z_.data(), *spacing = d_.data();
    const double half_reach = half_reach_, length = length_, d = metric.x;
    const auto scan = [&](std::int32_t begin, std::int32_t end, std::int32_t* out) CALOR_ALWAYS_INLINE {
      int n = hits.count;
      for (std::int32_t k = begin; k < end; k += width) {
        const Consecutive<width> here{k};
        const Doubles<width> dx = here(x) - p.x, dy = here(y) - p.y, dz = here(z) - p.z;
        const Doubles<width> r = half_reach * (d + here(spacing)) + length;
        const Doubles<width> square = dx * dx + dy * dy + dz * dz, limit = r * r;
        const Flags is_there = lane < static_cast<double>(end - k);
        const Flags is_near = (square < limit) & is_there;
        coincident -= (square < 1e-18 * limit) & is_there;
        const std::uint32_t hit = bits_of<width>(is_near);
        append_lanes(hit, k, out + n);
        n += std::popcount(hit);
      }
      hits.count = n;
    };
    for_each_row(c, p, metric, buffer, hits, scan);
    for (int l = 0; l < width; ++l) hits.coincident += static_cast<int>(coincident[l]);
  });
}

/// Adds the points of positions begin .. end that are within reach.
void Search::scan_metric(std::int32_t begin, std::int32_t end, const Vec3& p, const Vec3& metric, std::int32_t* out,
                         Hits& hits) const {
  int n = hits.count, coincident = hits.coincident;
  for (std::int32_t k = begin; k < end; ++k) {
    const Vec3 scaled = quotient({x_[k] - p.x, y_[k] - p.y, z_[k] - p.z}, reach(metric, metric_[k]));
    const double square = dot(scaled, scaled);
    out[n] = k;
    n += square < 1;
    coincident += square < 1e-18;
  }
  hits = {n, coincident};
}

}  // namespace calor
