#include "conduction/supports.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/error.hpp"
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

/// Gathers the points around a place for the fit.
class Gathered {
 public:
  Gathered(const Cloud& cloud, const Supports& supports) : cloud_(cloud), supports_(supports) {}

  int at(const Vec3& x) {
    supports_.covering(x, points);
    nodes.clear(), R.clear();
    for (const int j : points) nodes.push_back(cloud_.x[j]), R.push_back(supports_.radius()[j] * cloud_.metric[j]);
    return static_cast<int>(points.size());
  }

  std::vector<std::int32_t> points;
  std::vector<Vec3> nodes, R;

 private:
  const Cloud& cloud_;
  const Supports& supports_;
};

/// Fills the rows and returns the places where the supports are too small.
std::vector<std::size_t> fill(const Cloud& cloud, const MovingLeastSquares& mls, const Supports& supports,
                              std::span<const Vec3> places, std::span<const Vec3> along, int least, ShapeRows& rows) {
  rows = {};
  SparseRows& phi = rows.phi;
  phi.row.reserve(places.size() + 1);
  std::vector<std::size_t> failed;
  std::vector<Vec3> gradient;
  Gathered around(cloud, supports);
  for (std::size_t q = 0; q < places.size(); ++q) {
    const std::size_t n = around.at(places[q]), before = phi.column.size();
    if (q == 1000) {  // so that long rows are moved once or twice only
      const std::size_t expected = before / q * places.size();
      phi.column.reserve(expected), phi.value.reserve(expected);
      if (!along.empty()) rows.slope.reserve(before / q * along.size());
    }
    phi.column.insert(phi.column.end(), around.points.begin(), around.points.end());
    phi.value.resize(before + n);
    gradient.resize(q < along.size() ? n : 0);
    if (static_cast<int>(n) < least ||
        !mls.evaluate(places[q], around.nodes, around.R, std::span(phi.value).subspan(before), gradient))
      failed.push_back(q);
    for (const Vec3& g : gradient) rows.slope.push_back(dot(g, along[q]));
    phi.close_row();
  }
  return failed;
}

[[noreturn]] void refuse(const Cloud& cloud, const MovingLeastSquares& mls, const Supports& supports, const Vec3& x) {
  Gathered around(cloud, supports);
  const int n = around.at(x);
  throw Error(
      Fault::bad_case,
      fmt::format("moving least squares: no fit at ({:.6g}, {:.6g}, {:.6g}) m from the {} points whose supports "
                  "reach it: the condition number is {:.2g}",
                  x.x, x.y, x.z, n, mls.condition(x, around.nodes, around.R)),
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
  for (std::size_t j = 0; j < R_.size(); ++j)
    for (int a = 0; a < 3; ++a) largest_[a] = std::max(largest_[a], R_[j] * cloud_.metric[j][a]);
}

template <class Use>
void Supports::for_each_near(const Vec3& x, const Vec3& reach, const Use& use) const {
  const auto low = [&](int a) { return cells_.index(a, x[a] - reach[a]); };
  const auto high = [&](int a) { return cells_.index(a, x[a] + reach[a]); };
  const std::int64_t x0 = low(0), x1 = high(0), y0 = low(1), y1 = high(1), z0 = low(2), z1 = high(2);
  for (std::int64_t z = z0; z <= z1; ++z) {
    for (std::int64_t y = y0; y <= y1; ++y) {
      const std::int64_t row = cells_.along(0) * (y + cells_.along(1) * z);
      for (std::int32_t n = order_.start[row + x0]; n < order_.start[row + x1 + 1]; ++n) {
        const std::int32_t j = order_.order[n];
        use(j, x - cloud_.x[j]);
      }
    }
  }
}

void Supports::covering(const Vec3& x, std::vector<std::int32_t>& found) const {
  found.clear();
  // Points at the rim would be in or out by rounding alone.
  for_each_near(x, largest_, [&](std::int32_t j, const Vec3& r) {
    const Vec3 scaled = quotient(r, cloud_.metric[j]);
    if (dot(scaled, scaled) < R_[j] * R_[j] * (1 - 1e-9)) found.push_back(j);
  });
  keep_seen(x, found);
  const auto id = [&](std::int32_t j) { return cloud_.id[j]; };
  if (!std::ranges::is_sorted(found, {}, id)) std::ranges::sort(found, {}, id);
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
    const auto failed = fill(cloud, mls, supports, places, along, round == 1 ? least : mls.terms(), rows);
    if (!any(cloud.comm, !failed.empty())) break;
    collective_try(cloud.comm, [&] {
      for (const std::size_t q : failed) {
        if (round > most_rounds) refuse(cloud, mls, supports, places[q]);
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
