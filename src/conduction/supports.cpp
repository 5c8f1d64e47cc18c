#include "conduction/supports.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>

#include "base/error.hpp"
#include "base/lanes.hpp"
#include "base/parallel.hpp"

namespace calor {

namespace {

constexpr double beyond_nearest = 1.15, beyond_counted = 1.1;
constexpr int most_rounds = 4;

Vec3 mean(std::span<const Vec3> v) {
  Vec3 sum;
  for (const Vec3& a : v) sum += a;
  return v.empty() ? Vec3{1, 1, 1} : (1 / static_cast<double>(v.size())) * sum;
}

/// Distance in spacings of point j.
double distance(const Cloud& cloud, int j, const Vec3& x) { return norm(quotient(cloud.x[j] - x, cloud.metric[j])); }

std::vector<double> radii(const Cloud& cloud, const SupportSize& size) {
  std::vector<double> R(cloud.local(), size.spacings);
  if (size.neighbours == 0) return R;
  const Supports search(cloud, std::vector<double>(cloud.local(), 0.0));
  collective_try(cloud.comm, [&] {
    for (int j = 0; j < cloud.owned; ++j) {
      const double reach = size.limit() / beyond_counted;
      const Vec3& metric = cloud.metric[j];
      const auto near = search.nearest(cloud.x[j], size.neighbours + 1, reach * metric, metric);  // first j itself
      if (static_cast<int>(near.size()) <= size.neighbours)
        throw Error(
            Fault::bad_case,
            fmt::format("point {} at ({:.6g}, {:.6g}, {:.6g}) m has {} neighbours within {:.3g} spacings, not {}",
                        cloud.id[j], cloud.x[j].x, cloud.x[j].y, cloud.x[j].z, near.size() - 1, reach, size.neighbours),
            "ask for fewer [mlpg] neighbours, or give the support in spacings");
      R[j] = beyond_counted * distance(cloud, j, cloud.x[near.back()]);
    }
  });
  cloud.halo.update(std::span<double>(R));
  return R;
}

/// Rows of shape functions, made for several places at once.
class RowWriter {
 public:
  /// `places`: how many rows there will be.
  RowWriter(const Supports& supports, const MovingLeastSquares& mls, int least, std::size_t places, ShapeRows& rows)
      : supports_(supports), mls_(mls), least_(least), places_(places), rows_(rows) {}

  /// Adds the rows of places that are near to each other, with slopes unless `along` is empty. Returns the bits of
  /// those whose supports are too small.
  unsigned add(std::span<const Vec3> places, std::span<const Vec3> along) {
    MlsPlaces at;
    for (std::size_t l = 0; l < places.size(); ++l) at.add(places[l], along.empty() ? Vec3{} : along[l]);
    supports_.covering(at, around_);
    const std::size_t n = around_.points.size();
    if (phi_.size() < n) phi_.resize(n), slope_.resize(n);
    const auto slope = std::span(slope_).first(along.empty() ? 0 : n);
    unsigned fitted = mls_.evaluate(at, around_.nodes, around_.sees, phi_, slope);
    std::size_t entries = rows_.phi.column.size();
    for (const std::uint8_t sees : around_.sees) entries += std::popcount(sees);
    resize(entries + 1, !along.empty());  // what is no part of the last row is written behind it
    for (int l = 0; l < at.count; ++l)
      if (write(l, !along.empty()) < least_) fitted &= ~(1u << l);
    resize(entries, !along.empty());
    return ~fitted & ((1u << at.count) - 1);
  }

 private:
  void resize(std::size_t entries, bool with_slope) {
    resize(rows_.phi.column, entries), resize(rows_.phi.value, entries);
    if (with_slope) resize(rows_.slope, entries);
  }
  /// Takes room for all rows from what those so far took, so that long lists are moved once or twice only: for twice as
  /// much, as the first rows may be those of a wall, which are short. Room that is never used costs no memory.
  template <class T>
  void resize(std::vector<T>& list, std::size_t entries) const {
    const std::size_t done = rows_.phi.count();
    if (list.capacity() < entries) {
      const double all = done < 1000 ? 1 : static_cast<double>(places_) / static_cast<double>(done);
      list.reserve(static_cast<std::size_t>(2 * all * static_cast<double>(entries)));
    }
    list.resize(entries);
  }

  /// The row of place l; returns its length.
  int write(int l, bool with_slope) {
    const auto before = rows_.phi.row.back();
    auto end = before;
    for (std::size_t k = 0; k < around_.points.size(); ++k) {  // no branch: what the place sees is kept by moving on
      rows_.phi.column[end] = around_.points[k], rows_.phi.value[end] = phi_[k][l];
      if (with_slope) rows_.slope[end] = slope_[k][l];
      end += around_.sees[k] >> l & 1;
    }
    rows_.phi.row.push_back(end);
    return static_cast<int>(end - before);
  }

  const Supports& supports_;
  const MovingLeastSquares& mls_;
  const int least_;
  const std::size_t places_;
  ShapeRows& rows_;
  Covering around_;
  std::vector<MlsPlaces::Lanes> phi_, slope_;  ///< of the points around
};

/// Fills the rows and returns the places where the supports are too small.
std::vector<std::size_t> fill(const MovingLeastSquares& mls, const Supports& supports, std::span<const Vec3> places,
                              std::span<const Vec3> along, int least, ShapeRows& rows) {
  rows = {};
  rows.phi.row.reserve(places.size() + 1);
  std::vector<std::size_t> failed;
  RowWriter writer(supports, mls, least, places.size(), rows);
  const auto add = [&](std::size_t begin, std::size_t end, bool with_slope) {
    for (std::size_t q = begin, count = 0; q < end; q += count) {
      count = supports.batch(places.subspan(q, end - q));
      const auto directions = with_slope ? along.subspan(q, count) : std::span<const Vec3>();
      const unsigned too_small = writer.add(places.subspan(q, count), directions);
      for (std::size_t l = 0; l < count; ++l)
        if (too_small >> l & 1) failed.push_back(q + l);
    }
  };
  add(0, along.size(), true);
  add(along.size(), places.size(), false);
  return failed;
}

[[noreturn]] void refuse(const MovingLeastSquares& mls, const Supports& supports, const Vec3& x) {
  MlsPlaces place;
  place.add(x);
  Covering around;
  supports.covering(place, around);
  throw Error(
      Fault::bad_case,
      fmt::format("moving least squares: no fit at ({:.6g}, {:.6g}, {:.6g}) m from the {} points whose supports "
                  "reach it: the condition number is {:.2g}",
                  x.x, x.y, x.z, around.points.size(), mls.condition(x, around.nodes)),
      "the points there are too few or lie on a line or plane: add points, or ask for a larger [mlpg] support");
}

}  // namespace

double SupportSize::limit() const {
  if (neighbours == 0) return std::max(1.4 * spacings, 2.5);
  // A square lattice has that many points in a circle of this radius, and a corner of it in one of twice the radius.
  return std::max(2.2 * beyond_counted * std::sqrt((neighbours + 1) / std::numbers::pi), 2.5);
}

Supports::Supports(const Cloud& cloud, std::vector<double> R)
    : cloud_(cloud), cells_(cloud.x, mean(cloud.metric)), order_(order_by_cells(cells_, cloud.x)) {
  set_radius(R);
}

void Supports::set_radius(std::span<const double> R) {
  R_.assign(R.begin(), R.end());
  largest_ = {};
  for (int a = 0; a < 3; ++a) {
    constexpr std::size_t widest = 8;  // vectors may begin at the last point
    x_[a].resize(R_.size() + widest), by_R_[a].resize(R_.size() + widest);
    for (std::size_t n = 0; n < R_.size(); ++n) {
      const std::int32_t j = order_.order[n];
      const double axis = R_[j] * cloud_.metric[j][a];
      largest_[a] = std::max(largest_[a], axis);
      x_[a][n] = cloud_.x[j][a], by_R_[a][n] = 1 / axis;
    }
  }
}

template <class Use>
void Supports::for_each_row(const Vec3& low, const Vec3& high, const Use& use) const {
  const std::int64_t x0 = cells_.index(0, low.x), x1 = cells_.index(0, high.x);
  const std::int64_t y0 = cells_.index(1, low.y), y1 = cells_.index(1, high.y);
  const std::int64_t z0 = cells_.index(2, low.z), z1 = cells_.index(2, high.z);
  for (std::int64_t z = z0; z <= z1; ++z) {
    for (std::int64_t y = y0; y <= y1; ++y) {
      const std::int64_t row = cells_.along(0) * (y + cells_.along(1) * z);
      use(order_.start[row + x0], order_.start[row + x1 + 1]);
    }
  }
}

template <class Use>
void Supports::for_each_near(const Vec3& x, const Vec3& reach, const Use& use) const {
  for_each_row(x - reach, x + reach, [&](std::int32_t begin, std::int32_t end) {
    for (std::int32_t n = begin; n < end; ++n) use(order_.order[n], x - cloud_.x[order_.order[n]]);
  });
}

std::size_t Supports::batch(std::span<const Vec3> places) const {
  constexpr double widest = 0.7;  // extent of a batch, in the largest supports
  Vec3 low = places[0], high = low;
  const std::size_t most = std::min<std::size_t>(places.size(), MlsPlaces::most);
  for (std::size_t l = 1; l < most; ++l) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], places[l][a]), high[a] = std::max(high[a], places[l][a]);
      if (high[a] - low[a] > widest * largest_[a]) return l;
    }
  }
  return most;
}

void Supports::covering(const MlsPlaces& places, Covering& found) const {
  Vec3 low, high;
  for (int a = 0; a < 3; ++a) {
    const auto [least, most] = std::minmax_element(places.x[a].begin(), places.x[a].begin() + places.count);
    low[a] = *least, high[a] = *most;
  }
  std::vector<Covering::Hit>& hits = found.hits;
  std::size_t count = 0;
  for_each_row(low - largest_, high + largest_, [&](std::int32_t begin, std::int32_t end) {
    if (hits.size() < count + (end - begin)) hits.resize(2 * (count + (end - begin)));
    count = scan(places, begin, end, hits.data() + count) - hits.data();
  });
  for (Covering::Hit& hit : std::span(hits).first(count)) hit.id = cloud_.id[order_.order[hit.position]];
  const auto used = std::span(hits).first(count);
  if (cloud_.body) keep_seen(places, used);
  if (!std::ranges::is_sorted(used, {}, &Covering::Hit::id)) std::ranges::sort(used, {}, &Covering::Hit::id);
  found.points.resize(count), found.nodes.resize(count), found.sees.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::int32_t n = used[k].position;
    found.points[k] = order_.order[n], found.sees[k] = used[k].sees;
    found.nodes[k] = {{x_[0][n], x_[1][n], x_[2][n]}, {by_R_[0][n], by_R_[1][n], by_R_[2][n]}};
  }
}

Covering::Hit* Supports::scan(const MlsPlaces& places, std::int32_t begin, std::int32_t end, Covering::Hit* out) const {
  run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
    using Flags = typename Vectors<width>::Flags;
    for (std::int32_t n = begin; n < end; n += width) {
      const Consecutive<width> points{n};
      const Doubles<width> x = points(x_[0].data()), y = points(x_[1].data()), z = points(x_[2].data());
      const Doubles<width> by_x = points(by_R_[0].data()), by_y = points(by_R_[1].data()),
                           by_z = points(by_R_[2].data());
      Flags sees{};
      for (int l = 0; l < places.count; ++l) {
        const Doubles<width> u = (x - places.x[0][l]) * by_x, v = (y - places.x[1][l]) * by_y,
                             w = (z - places.x[2][l]) * by_z;
        // Points at the rim would be in or out by rounding alone.
        sees |= (u * u + v * v + w * w < 1 - 1e-9) & (std::int64_t{1} << l);
      }
      std::array<std::int64_t, width> bits;
      std::memcpy(bits.data(), &sees, sizeof bits);
      for (std::int32_t k = 0; k < std::min(width, end - n); ++k) {  // no branch: a hit is kept by moving on
        *out = {.id = 0, .position = n + k, .sees = static_cast<std::uint8_t>(bits[k])};
        out += bits[k] != 0;
      }
    }
  });
  return out;
}

void Supports::keep_seen(const MlsPlaces& places, std::span<Covering::Hit> hits) const {
  std::vector<std::int32_t> points;
  for (int l = 0; l < places.count; ++l) {
    points.clear();
    for (const Covering::Hit& hit : hits)
      if (hit.sees >> l & 1) points.push_back(order_.order[hit.position]);
    keep_seen({places.x[0][l], places.x[1][l], places.x[2][l]}, points);
    auto seen = points.begin();
    for (Covering::Hit& hit : hits) {
      if (!(hit.sees >> l & 1)) continue;
      if (seen != points.end() && *seen == order_.order[hit.position])
        ++seen;
      else
        hit.sees &= static_cast<std::uint8_t>(~(1u << l));
    }
  }
}

void Supports::keep_seen(const Vec3& x, std::vector<std::int32_t>& points) const {
  if (!cloud_.body || points.empty()) return;
  // The next point, whatever the order in which this rank found them.
  const auto by_distance = [&](std::int32_t j) { return std::pair(norm(cloud_.x[j] - x), cloud_.id[j]); };
  const Vec3 eye = cloud_.eye_at(x, cloud_.spacing[*std::ranges::min_element(points, {}, by_distance)]);
  std::erase_if(points, [&](std::int32_t j) { return !cloud_.is_seen_from(eye, j); });
}

std::vector<std::int32_t> Supports::nearest(const Vec3& x, int count, const Vec3& reach, const Vec3& metric) const {
  struct Near {
    double square;
    std::int64_t id;
    std::int32_t point;
    auto operator<=>(const Near&) const = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 reads a 0 into it
  };
  std::vector<Near> near;
  for_each_near(x, reach, [&](std::int32_t j, const Vec3& r) {
    const Vec3 scaled = quotient(r, metric);
    if (norm(quotient(r, reach)) <= 1) near.push_back({dot(scaled, scaled), cloud_.id[j], j});
  });
  // Where points may be out of sight, all are looked at.
  const std::size_t n = cloud_.body ? near.size() : std::min<std::size_t>(count, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(n), near.end());
  std::vector<std::int32_t> points;
  for (std::size_t k = 0; k < n; ++k) points.push_back(near[k].point);
  keep_seen(x, points);
  if (points.size() > static_cast<std::size_t>(count)) points.resize(count);
  return points;
}

const Vec3& Supports::metric_at(const Vec3& x, const Vec3& reach) const {
  std::pair nearest{std::numeric_limits<double>::infinity(), std::numeric_limits<std::int64_t>::max()};
  int point = 0;
  for_each_near(x, reach, [&](std::int32_t j, const Vec3&) {
    const std::pair here{distance(cloud_, j, x), cloud_.id[j]};
    if (here < nearest) nearest = here, point = j;
  });
  return cloud_.metric[point];
}

ShapeRows shape_rows(const Cloud& cloud, const MovingLeastSquares& mls, const SupportSize& size,
                     std::span<const Vec3> places, std::span<const Vec3> along, SupportReport& report) {
  const std::vector<double> R_first = radii(cloud, size);
  report = {.R = R_first};
  std::vector<double>& R = report.R;
  ShapeRows rows = shape_rows(cloud, mls, size, R, places, along);
  for (int j = 0; j < cloud.owned; ++j) {
    report.enlarged += R[j] > R_first[j];
    report.largest = std::max(report.largest, R[j]);
  }
  report.enlarged = total(cloud.comm, report.enlarged);
  report.largest = max(cloud.comm, report.largest);
  return rows;
}

ShapeRows shape_rows(const Cloud& cloud, const MovingLeastSquares& mls, const SupportSize& size, std::vector<double>& R,
                     std::span<const Vec3> places, std::span<const Vec3> along) {
  const int least = std::max(size.least, mls.terms());
  Vec3 farthest;
  for (int a = 0; a < 3; ++a) {
    for (const Vec3& s : cloud.metric) farthest[a] = std::max(farthest[a], size.limit() * s[a]);
    farthest[a] = max(cloud.comm, farthest[a]);
  }

  Supports supports(cloud, R);
  ShapeRows rows;
  for (int round = 1;; ++round) {
    // `least` is what the first round aims at; after that, a fit is a fit.
    const auto failed = fill(mls, supports, places, along, round == 1 ? least : mls.terms(), rows);
    if (!any(cloud.comm, !failed.empty())) break;
    collective_try(cloud.comm, [&] {
      for (const std::size_t q : failed) {
        if (round > most_rounds) refuse(mls, supports, places[q]);
        const Vec3& metric = supports.metric_at(places[q], farthest);
        for (const int j : supports.nearest(places[q], round * least, farthest, metric))
          R[j] = std::max(R[j], std::min(beyond_nearest * distance(cloud, j, places[q]), size.limit()));
      }
    });
    cloud.halo.raise(R);
    supports.set_radius(R);
  }
  return rows;
}

}  // namespace calor
