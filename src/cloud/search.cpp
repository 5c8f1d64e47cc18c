#include "cloud/search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "base/lanes.hpp"

namespace calor {

Search::Search(const Cloud& cloud, const Support& support)
    : half_reach_(0.5 * support.over_spacing * (1 - 1e-9)),
      length_(support.length * (1 - 1e-9)),
      isotropic_(cloud.isotropic) {
  const std::size_t n = cloud.x.size();
  if (n == 0) return;
  for (const Vec3& s : cloud.metric)
    for (int a = 0; a < 3; ++a) largest_[a] = std::max(largest_[a], s[a]);
  for (auto* v : {&x_, &y_, &z_}) v->reserve(n);
  if (isotropic_)
    d_.reserve(n);
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
  if (count > most_counted) {
    std::ranges::sort(std::span(buffer).first(count), {}, id);
    return std::span(buffer).first(count);
  }
  if (buffer.size() < 2 * count) buffer.resize(2 * count);
  sort_by_counting(std::span(buffer).first(count), std::span(buffer).subspan(count, count));
  return std::span(buffer).subspan(count, count);
}

/// The place of every one is the number of those with a lower id: some n^2 / 8 steps without a branch, faster than
/// sorting by exchanges.
void Search::sort_by_counting(std::span<const std::int32_t> found, std::span<std::int32_t> sorted) const {
  constexpr int widest = 8;
  std::array<double, most_counted + widest> id;  // exact in a double
  std::array<std::int64_t, most_counted + widest> place;
  const std::size_t n = found.size();
  for (std::size_t k = 0; k < n; ++k) id[k] = static_cast<double>(id_[found[k]]);
  std::fill_n(id.begin() + n, widest, 0.0);
  run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
    for (std::size_t k = 0; k < n; k += width) {
      const Doubles<width> own = Consecutive<width>{static_cast<std::int64_t>(k)}(id.data());
      typename Vectors<width>::Flags lower{};
      for (std::size_t m = 0; m < n; ++m) lower -= id[m] < own;
      std::memcpy(&place[k], &lower, sizeof lower);
    }
  });
  for (std::size_t k = 0; k < n; ++k) sorted[place[k]] = found[k];
}

void Search::search(const Class& c, const Vec3& p, const Vec3& metric, std::vector<std::int32_t>& buffer,
                    Hits& hits) const {
  const Vec3 far = reach(metric, c.largest);
  const Cells& cells = c.cells;
  const std::int64_t x_low = cells.index(0, p.x - far.x), x_high = cells.index(0, p.x + far.x);
  const std::int64_t y_low = cells.index(1, p.y - far.y), y_high = cells.index(1, p.y + far.y);
  const std::int64_t z_low = cells.index(2, p.z - far.z), z_high = cells.index(2, p.z + far.z);
  for (std::int64_t z = z_low; z <= z_high; ++z) {
    for (std::int64_t y = y_low; y <= y_high; ++y) {
      const std::int64_t row = y + cells.along(1) * z;
      const RowExtent& e = c.rows[row];
      const double gap_y = std::max({0.0, e.y_low - p.y, p.y - e.y_high}) / far.y;
      const double gap_z = std::max({0.0, e.z_low - p.z, p.z - e.z_high}) / far.z;
      if (!(gap_y * gap_y + gap_z * gap_z < 1)) continue;
      const std::int32_t* start = c.start.data() + cells.along(0) * row;
      const std::size_t most = hits.count + static_cast<std::size_t>(start[x_high + 1] - start[x_low]);
      if (buffer.size() < most) buffer.resize(2 * most);
      if (isotropic_)
        scan(start[x_low], start[x_high + 1], p, metric.x, buffer.data(), hits);
      else
        scan_metric(start[x_low], start[x_high + 1], p, metric, buffer.data(), hits);
    }
  }
}

/// Adds the points of positions begin .. end that are within reach.
void Search::scan(std::int32_t begin, std::int32_t end, const Vec3& p, double d, std::int32_t* out, Hits& hits) const {
  const double *x = x_.data(), *y = y_.data(), *z = z_.data(), *dj = d_.data();
  int n = hits.count, coincident = hits.coincident;
  for (std::int32_t k = begin; k < end; ++k) {  // no branch: a hit is kept by moving on
    const double dx = x[k] - p.x, dy = y[k] - p.y, dz = z[k] - p.z, r = half_reach_ * (d + dj[k]) + length_;
    const double square = dx * dx + dy * dy + dz * dz, limit = r * r;
    out[n] = k;
    n += square < limit;
    coincident += square < 1e-18 * limit;
  }
  hits = {n, coincident};
}

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
