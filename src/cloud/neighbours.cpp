#include "cloud/neighbours.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/cells.hpp"

namespace calor {
namespace {

/// Local points in the order of the cells, coordinates apart, so that the search reads memory in sequence.
struct Sorted {
  std::vector<double> x, y, z, d;
  std::vector<std::int64_t> id;
  std::vector<std::int32_t> local;
};

/// Extent in y and z of a row of cells along x: most rows of a lattice are ruled out by it at once.
struct RowExtent {
  double y_low = std::numeric_limits<double>::infinity(), y_high = -y_low, z_low = y_low, z_high = -y_low;
};

class Search {
 public:
  Search(const Cloud& cloud, double reach)
      : half_reach_(0.5 * reach * (1 - 1e-9)), cells_(cloud.x, mean(cloud.spacing)) {
    CellOrder order = order_by_cells(cells_, cloud.x);
    start_ = std::move(order.start);
    sorted_.local = std::move(order.order);
    const std::size_t n = cloud.x.size();
    for (auto* v : {&sorted_.x, &sorted_.y, &sorted_.z, &sorted_.d}) v->resize(n);
    sorted_.id.resize(n);
    rows_.resize(cells_.along(1) * cells_.along(2));
    for (std::size_t k = 0; k < n; ++k) {
      const int i = sorted_.local[k];
      const Vec3& p = cloud.x[i];
      sorted_.x[k] = p.x, sorted_.y[k] = p.y, sorted_.z[k] = p.z;
      sorted_.d[k] = cloud.spacing[i];
      sorted_.id[k] = cloud.id[i];
      largest_ = std::max(largest_, cloud.spacing[i]);
      RowExtent& row = rows_[cells_.index(1, p.y) + cells_.along(1) * cells_.index(2, p.z)];
      row.y_low = std::min(row.y_low, p.y), row.y_high = std::max(row.y_high, p.y);
      row.z_low = std::min(row.z_low, p.z), row.z_high = std::max(row.z_high, p.z);
    }
  }

  /// Positions in the sorted arrays of all points within reach of a point, itself included, by ascending id.
  /// `coincident` counts those at (almost) no distance.
  std::span<std::int32_t> find(const Vec3& p, double d, std::vector<std::int32_t>& buffer, int& coincident) const {
    const double reach = half_reach_ * (d + largest_);
    const std::int64_t x_low = cells_.index(0, p.x - reach), x_high = cells_.index(0, p.x + reach);
    const std::int64_t y_low = cells_.index(1, p.y - reach), y_high = cells_.index(1, p.y + reach);
    const std::int64_t z_low = cells_.index(2, p.z - reach), z_high = cells_.index(2, p.z + reach);
    Hits hits;
    for (std::int64_t z = z_low; z <= z_high; ++z) {
      for (std::int64_t y = y_low; y <= y_high; ++y) {
        const std::int64_t row = y + cells_.along(1) * z;
        const RowExtent& e = rows_[row];
        const double gap_y = std::max({0.0, e.y_low - p.y, p.y - e.y_high});
        const double gap_z = std::max({0.0, e.z_low - p.z, p.z - e.z_high});
        if (!(gap_y * gap_y + gap_z * gap_z < reach * reach)) continue;
        const std::int32_t* start = start_.data() + cells_.along(0) * row;
        const std::size_t most = hits.count + static_cast<std::size_t>(start[x_high + 1] - start[x_low]);
        if (buffer.size() < most) buffer.resize(2 * most);
        scan(start[x_low], start[x_high + 1], p, d, buffer.data(), hits);
      }
    }
    coincident = hits.coincident;
    const auto id = [&](std::int32_t k) { return sorted_.id[k]; };
    const auto found = std::span(buffer).first(hits.count);
    if (!std::ranges::is_sorted(found, {}, id)) std::ranges::sort(found, {}, id);
    return found;
  }

  double largest_reach() const { return 2 * half_reach_ * largest_; }
  std::int32_t local(std::int32_t k) const { return sorted_.local[k]; }

 private:
  struct Hits {
    int count = 0, coincident = 0;
  };

  /// Adds the points of positions begin .. end that are within reach.
  void scan(std::int32_t begin, std::int32_t end, const Vec3& p, double d, std::int32_t* out, Hits& hits) const {
    const double *x = sorted_.x.data(), *y = sorted_.y.data(), *z = sorted_.z.data(), *dj = sorted_.d.data();
    int n = hits.count, coincident = hits.coincident;
    for (std::int32_t k = begin; k < end; ++k) {  // no branch: a hit is kept by moving on
      const double dx = x[k] - p.x, dy = y[k] - p.y, dz = z[k] - p.z, r = half_reach_ * (d + dj[k]);
      const double square = dx * dx + dy * dy + dz * dz, limit = r * r;
      out[n] = k;
      n += square < limit;
      coincident += square < 1e-18 * limit;
    }
    hits = {n, coincident};
  }

  static double mean(const std::vector<double>& v) {
    double sum = 0;
    for (double a : v) sum += a;
    return v.empty() ? 1 : sum / static_cast<double>(v.size());
  }

  double half_reach_, largest_ = 0;
  Cells cells_;
  std::vector<std::int32_t> start_;
  std::vector<RowExtent> rows_;
  Sorted sorted_;
};

std::string point_text(const Cloud& cloud, int i) {
  return fmt::format("{} at ({:.6g}, {:.6g}, {:.6g}) m", cloud.id[i], cloud.x[i].x, cloud.x[i].y, cloud.x[i].z);
}

[[noreturn]] void refuse_coincident(const Cloud& cloud, int i, std::span<const std::int32_t> near) {
  const auto distance = [&](int j) {
    return j == i ? std::numeric_limits<double>::infinity() : norm(cloud.x[j] - cloud.x[i]);
  };
  const int j = *std::ranges::min_element(near, {}, distance);
  const auto [first, second] = std::minmax(cloud.id[i], cloud.id[j]);
  const Vec3& x = cloud.x[i];
  throw Error(
      Fault::bad_case,
      fmt::format("points {} and {} (from 0) coincide at ({:.6g}, {:.6g}, {:.6g}) m", first, second, x.x, x.y, x.z),
      "remove one of them");
}

}  // namespace

Neighbours find_neighbours(const Cloud& cloud, double reach) {
  const Search search(cloud, reach);
  Neighbours out;
  out.row.reserve(cloud.owned + 1);
  out.row.push_back(0);
  together(cloud.comm, [&] {
    if (size_of(cloud.comm) > 1 && search.largest_reach() > cloud.halo_width)
      throw Error(Fault::numbers, "the ghosts do not reach as far as the neighbours",
                  "distribute the cloud with a larger support");
    std::vector<std::int32_t> buffer;
    for (int i = 0; i < cloud.owned; ++i) {
      int coincident = 0;
      const auto found = search.find(cloud.x[i], cloud.spacing[i], buffer, coincident);
      for (std::int32_t& k : found) k = search.local(k);
      if (coincident > 1) refuse_coincident(cloud, i, found);
      const std::size_t size = out.column.size(), needed = size + found.size();
      if (out.column.capacity() < needed) {
        // From what the rows so far took, so that large lists are moved once or twice only.
        const double rows = static_cast<double>(cloud.owned) / (i + 1.0);
        out.column.reserve(
            i < 1000 ? 2 * needed : static_cast<std::size_t>(1.02 * rows * static_cast<double>(needed)) + found.size());
      }
      const auto self = std::ranges::find(found, i);
      out.column.insert(out.column.end(), found.begin(), self);
      out.column.insert(out.column.end(), self + 1, found.end());
      out.row.push_back(static_cast<std::int64_t>(out.column.size()));
    }
  });
  return out;
}

void require_neighbours(const Cloud& cloud, const Neighbours& neighbours) {
  together(cloud.comm, [&] {
    for (int i = 0; i < cloud.owned; ++i) {
      const int n = static_cast<int>(neighbours.of(i).size()), least = cloud.dimension;
      if (n < least)
        throw Error(Fault::bad_case,
                    fmt::format("point {} has {} neighbour{}, fewer than {}", point_text(cloud, i), n,
                                n == 1 ? "" : "s", least),
                    "give it neighbours: more points, a larger support, or volumes that fit the distances");
    }
  });
}

}  // namespace calor
