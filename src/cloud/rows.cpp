// Rows of points, thinned where little happens: every row along x has its own number of equally spaced points.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cloud/convex_cell.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

class RowLattice {
 public:
  explicit RowLattice(const Rows& rows) : rows_(rows), first_(1, 0) {
    for (std::int64_t n : rows.points) first_.push_back(first_.back() + n);
  }

  std::int64_t count() const { return first_.back(); }
  int rows() const { return static_cast<int>(rows_.y.size()); }
  int row(std::int64_t id) const { return static_cast<int>(std::ranges::upper_bound(first_, id) - first_.begin()) - 1; }
  std::int64_t location(std::int64_t id) const { return id - first_[row(id)]; }
  double dx(int row) const { return rows_.length / static_cast<double>(rows_.points[row] - 1); }
  Vec3 position(int row, std::int64_t i) const {
    // The last point lies on the wall to the last bit.
    return {i == rows_.points[row] - 1 ? rows_.length : static_cast<double>(i) * dx(row), rows_.y[row], 0};
  }
  double gap_below(int row) const { return row > 0 ? rows_.y[row] - rows_.y[row - 1] : 0; }
  double gap_above(int row) const { return row + 1 < rows() ? rows_.y[row + 1] - rows_.y[row] : 0; }

  /// Area of the part of the body that is nearest to a point: the rectangle, cut by the bisectors with its neighbours.
  double nearest_area(int row, std::int64_t i) const {
    const Vec3 p = position(row, i);
    ConvexCell cell;
    cell.set(Vec3{0, rows_.y.front()} - p, Vec3{rows_.length, rows_.y.back()} - p, 2);
    const auto reach = [&] { return 2 * cell.reach(); };  // points farther than this cannot cut the cell
    const auto cut = [&](int r, std::int64_t k) { cell.keep_nearer_than(position(r, k) - p); };
    if (i > 0) cut(row, i - 1);
    if (i + 1 < rows_.points[row]) cut(row, i + 1);
    for (const int step : {-1, 1}) {
      for (int r = row + step; r >= 0 && r < rows() && std::abs(rows_.y[r] - p.y) < reach(); r += step) {
        const double width = reach();
        const auto begin = static_cast<std::int64_t>(std::max(0.0, std::floor((p.x - width) / dx(r))));
        const auto end = static_cast<std::int64_t>(std::ceil((p.x + width) / dx(r)));
        for (std::int64_t k = begin; k <= std::min(end, rows_.points[r] - 1); ++k) cut(r, k);
      }
    }
    return cell.volume();
  }

 private:
  Rows rows_;
  std::vector<std::int64_t> first_;  // id of the first point of every row, and the end
};

}  // namespace

Points make_rows(MPI_Comm comm, const Rows& rows) {
  const RowLattice lattice(rows);
  Points out;
  out.dimension = 2;
  out.section = rows.thickness;
  out.exact.volume = rows.length * (rows.y.back() - rows.y.front()) * rows.thickness;
  out.faces = {"xmin", "xmax", "ymin", "ymax"};
  const Slice mine = slice(comm, lattice.count());
  for (std::int64_t id = mine.begin; id < mine.end; ++id) {
    const int row = lattice.row(id);
    const std::int64_t i = lattice.location(id);
    const double below = lattice.gap_below(row), above = lattice.gap_above(row), dx = lattice.dx(row);
    const bool first = i == 0, last = i == rows.points[row] - 1, lowest = row == 0, highest = row == lattice.rows() - 1;
    const double volume = rows.thickness * lattice.nearest_area(row, i);
    out.points.push_back({.id = id,
                          .x = lattice.position(row, i),
                          .volume = volume,
                          .full_volume = volume * (first || last ? 2 : 1) * (lowest || highest ? 2 : 1),
                          .spacing = std::max({dx, below, above}),
                          .metric = {dx, std::max(below, above), 0}});
    // The trapezoidal rule on every wall, which gives linear functions their exact integrals.
    const double height = rows.thickness * 0.5 * (below + above);
    const double width = rows.thickness * (first || last ? 0.5 * dx : dx);
    if (first) out.add_patch(0, height, {-1, 0, 0});
    if (last) out.add_patch(1, height, {1, 0, 0});
    if (lowest) out.add_patch(2, width, {0, -1, 0});
    if (highest) out.add_patch(3, width, {0, 1, 0});
  }
  return out;
}

namespace {

Points rows_from(MPI_Comm comm, const Table& cloud) {
  Rows rows{.length = cloud.number("length"), .y = cloud.numbers("y"), .points = {}, .thickness = section_of(cloud, 2)};
  if (!(rows.length > 0))
    cloud.refuse("length", fmt::format("a length of {} m is not positive", rows.length), "give a positive one");
  if (rows.y.size() < 2) cloud.refuse("y", "fewer than 2 rows", "give the y of every row: bottom and top at least");
  for (std::size_t r = 1; r < rows.y.size(); ++r)
    if (!(rows.y[r] > rows.y[r - 1]))
      cloud.refuse("y", fmt::format("y = {} m follows {} m", rows.y[r], rows.y[r - 1]), "give them in ascending order");
  const std::vector<long> points = cloud.integers("points");
  if (points.size() != rows.y.size())
    cloud.refuse("points", fmt::format("{} numbers of points for {} rows", points.size(), rows.y.size()),
                 "give one per row of y");
  for (long n : points) {
    if (n < 2) cloud.refuse("points", fmt::format("a row of {} points", n), "give at least 2: the ends of the row");
    rows.points.push_back(n);
  }
  return make_rows(comm, rows);
}

}  // namespace

CloudShape rows_shape() {
  return {.name = "rows",
          .sentence =
              "A rectangle filled with rows of points along x, from x = 0, each with its own number of them. "
              "Faces: xmin, xmax, ymin, ymax",
          .keys = {{"length", Kind::quantity, "m", required, "Length of the rows."},
                   {"y", Kind::quantities, "m", required, "Where the rows are, the first and the last on the walls."},
                   {"points", Kind::integers, "", required, "Points of every row, equally spaced, ends included."}},
          .make = rows_from};
}

}  // namespace calor
