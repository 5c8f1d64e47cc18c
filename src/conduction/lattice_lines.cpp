// Weights of lattices of unequal spacings: every line of points along an axis is a rod.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "conduction/correction.hpp"
#include "conduction/lattice_index.hpp"

namespace calor {
namespace {

/// Points p < q of a line, by their indices; those below 0 and beyond the last are mirror images.
using LinePair = std::pair<std::int64_t, std::int64_t>;

/// Which ends of a line have images beyond them.
struct Ends {
  bool low = false, high = false;
};

/// A line of points along an axis: the forces of its pairs. Along a radius the thickness of the body grows: there
/// forces are those of a thickness 1 times that at the middle of the pair, and those across an interval add up to that
/// of the face in it.
class Line {
 public:
  /// For pairs of the points first .. last, `most` intervals apart at most.
  Line(const Lattice& lattice, int axis, bool is_radius, const LineForce& force, std::int64_t most, LinePair range)
      : lattice_(lattice), axis_(axis), is_radius_(is_radius), n_(lattice.box().points[axis]), force_(force) {
    // The scale is that of a line with images beyond both ends, whether they are there or not: so it is the same for
    // points that see the end and points that do not. Points on the walls have none, nor has a radius.
    const std::int64_t beyond = lattice.box().on_walls || is_radius ? 0 : most;
    begin_ = std::max(range.first - 3 * most, -beyond);
    const std::int64_t end = std::min(range.second + 3 * most, n_ - 1 + beyond);
    const auto intervals = static_cast<std::size_t>(std::max<std::int64_t>(0, end - begin_));
    stress_.assign(intervals, 0), carried_.assign(intervals, {});
    const auto for_each_pair = [&](const auto& use) {
      for (std::int64_t p = begin_; p < end; ++p)
        for (std::int64_t q = p + 1; q <= std::min(end, p + most); ++q) use(p, q);
    };
    for_each_pair([&](std::int64_t p, std::int64_t q) {
      const double f = unscaled(p, q);
      for (std::int64_t k = p; k < q; ++k) stress_[k - begin_] += f;
    });
    for_each_pair([&](std::int64_t p, std::int64_t q) {
      const double f = scaled(p, q);
      for (std::int64_t k = p; k < q; ++k) {
        Carried& c = carried_[k - begin_];
        (p < 0 ? c.by_low : q >= n_ ? c.by_high : c.inside) += f;
      }
    });
  }

  double force(LinePair pair, const Ends& ends) const {
    // Pairs that are each other's image are one, so that (i, j) and (j, i) have the same bits.
    auto [p, q] = pair;
    if (p < 0 && -1 - p < q) std::tie(p, q) = std::pair(-1 - q, -1 - p);
    if (q >= n_ && 2 * n_ - 1 - q > p) std::tie(p, q) = std::pair(2 * n_ - 1 - q, 2 * n_ - 1 - p);
    const double f = scaled(p, q);
    if (q > p + 1) return f;
    const Carried& c = carried_[p - begin_];
    return f + std::max(0.0, thickness(p) - c.inside - (ends.low ? c.by_low : 0) - (ends.high ? c.by_high : 0));
  }

 private:
  /// Sums of the scaled forces across an interval, of pairs of points and of pairs with images.
  struct Carried {
    double inside = 0, by_low = 0, by_high = 0;
  };

  /// The point whose image it is, or itself.
  std::int64_t original(std::int64_t p) const { return p < 0 ? -1 - p : p >= n_ ? 2 * n_ - 1 - p : p; }
  double coordinate(std::int64_t p) const {
    const auto& box = lattice_.box();
    const double x = lattice_.coordinate(axis_, original(p)), low = box.origin[axis_];
    return p < 0 ? 2 * low - x : p >= n_ ? 2 * (low + box.size[axis_]) - x : x;
  }
  double unscaled(std::int64_t p, std::int64_t q) const {
    const double s = 0.5 * (lattice_.spacing(axis_, original(p)) + lattice_.spacing(axis_, original(q)));
    const double f = force_(q - p, coordinate(q) - coordinate(p), s);
    return is_radius_ ? 0.5 * (coordinate(p) + coordinate(q)) * f : f;
  }
  /// Of the body at the face between p and p + 1, over that of its section.
  double thickness(std::int64_t p) const { return is_radius_ ? lattice_.cell(axis_, p).second : 1; }
  double scaled(std::int64_t p, std::int64_t q) const {
    const double f = unscaled(p, q);
    if (f == 0) return 0;
    double largest = 0;
    for (std::int64_t k = p; k < q; ++k) largest = std::max(largest, stress_[k - begin_] / thickness(k));
    return f / largest;
  }

  const Lattice& lattice_;
  int axis_;
  bool is_radius_;
  std::int64_t n_;
  const LineForce& force_;
  std::int64_t begin_;
  std::vector<double> stress_;  // of the intervals from begin_ on: the sum of the forces across them
  std::vector<Carried> carried_;
};

/// A pair of points on a line along an axis.
struct OnLine {
  int axis;
  LinePair pair;
};

/// Entry n in row i, if both its points lie on a line.
std::optional<OnLine> on_line(const Lattice& lattice, const Cloud& cloud, const Neighbours& neighbours, int i,
                              std::int64_t n) {
  // Coordinates along the axes are the same to the last bit, so most pairs are told by a look.
  const Vec3 x_ji = neighbours.x_ji(cloud.x, i, n);
  if ((x_ji.x != 0) + (x_ji.y != 0) + (x_ji.z != 0) != 1) return std::nullopt;
  const LatticeIndex at_i = lattice.index(cloud.id[i]);
  const LatticeIndex at_j = index_of_neighbour(lattice, cloud, neighbours, n);
  const int axis = x_ji.x != 0 ? 0 : x_ji.y != 0 ? 1 : 2;
  return OnLine{axis, std::minmax(at_i[axis], at_j[axis])};
}

/// Calls use(n, its line) for the entries of row i whose points lie on a line.
template <class Use>
void for_each_on_line(const Lattice& lattice, const Cloud& cloud, const Neighbours& neighbours, int i, const Use& use) {
  for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
    if (const auto found = on_line(lattice, cloud, neighbours, i, n)) use(n, *found);
}

/// Refuses points next to each other along an axis that are no neighbours, as a horizon in metres may leave them.
void require_next(const Cloud& cloud, const Neighbours& neighbours) {
  const Lattice& lattice = *cloud.lattice;
  collective_try(cloud.comm, [&] {
    for (int i = 0; i < cloud.owned; ++i) {
      const LatticeIndex at = lattice.index(cloud.id[i]);
      std::array<bool, 3> next = {};
      for_each_on_line(lattice, cloud, neighbours, i, [&](std::int64_t, const OnLine& is) {
        next[is.axis] |= is.pair == LinePair{at[is.axis], at[is.axis] + 1};
      });
      for (int a = 0; a < cloud.dimension; ++a) {
        if (next[a] || lattice.highest(at, a)) continue;
        throw Error(
            Fault::bad_case,
            fmt::format("points along {} are {:.6g} m apart at {:.6g} m, farther than a point sees", "xyz"[a],
                        lattice.coordinate(a, at[a] + 1) - lattice.coordinate(a, at[a]), lattice.coordinate(a, at[a])),
            "use a larger horizon, or give it as a multiple of the spacing");
      }
    }
  });
}

/// The rods of a body and what ties them together.
class Rods {
 public:
  Rods(const Cloud& cloud, std::vector<Line> lines)
      : cloud_(cloud), lattice_(*cloud.lattice), lines_(std::move(lines)) {}

  /// Weight of a pair on a line through the point with the numbers `at`.
  double weight(LatticeIndex at, const OnLine& is, const Ends& ends, double distance) const {
    double face = cloud_.cross_section;
    for (int a = 0; a < cloud_.dimension; ++a)
      if (a != is.axis) face *= lattice_.width(a, at[a]);
    if (const auto [low, high] = lattice_.cell(0, at[0]); cloud_.axisymmetric && is.axis != 0)
      face *= 0.5 * (low + high);
    return face * lines_[is.axis].force(is.pair, ends) / distance;
  }

  /// Of the two braces of a rectangle between next points along axes a and b, the lowest of them `low`.
  double brace(const LatticeIndex& low, int a, int b) const {
    return std::min({share(low, a), share(moved(low, b), a), share(low, b), share(moved(low, a), b)});
  }
  /// What all braces take from the pair of next points `low` and the one after it along axis a.
  double taken(const LatticeIndex& low, int a) const {
    double sum = 0;
    for (int b = 0; b < cloud_.dimension; ++b) {
      if (b == a) continue;
      if (!lattice_.lowest(low, b)) sum += brace(moved(low, b, -1), a, b);
      if (!lattice_.highest(low, b)) sum += brace(low, a, b);
    }
    return sum;
  }

 private:
  static LatticeIndex moved(LatticeIndex at, int axis, int by = 1) {
    at[axis] += by;
    return at;
  }
  /// What a pair of next points can give to every rectangle that it is a side of. A third of it makes squares of equal
  /// spacing a scheme of fourth order, that of brick_weights.hpp.
  double share(const LatticeIndex& low, int a) const {
    int rectangles = 0;
    for (int b = 0; b < cloud_.dimension; ++b)
      if (b != a) rectangles += !lattice_.lowest(low, b) + !lattice_.highest(low, b);
    const double distance = lattice_.coordinate(a, low[a] + 1) - lattice_.coordinate(a, low[a]);
    return weight(low, {a, {low[a], low[a] + 1}}, {}, distance) / (3 * rectangles);
  }

  const Cloud& cloud_;
  const Lattice& lattice_;
  std::vector<Line> lines_;
};

/// The axes along which two points differ by one interval each, if those are two and the points no images.
std::optional<std::pair<int, int>> across(const LatticeIndex& i, const LatticeIndex& j, int dimension) {
  std::vector<int> axes;
  for (int a = 0; a < dimension; ++a) {
    if (std::abs(i[a] - j[a]) > 1) return std::nullopt;
    if (i[a] != j[a]) axes.push_back(a);
  }
  if (axes.size() != 2) return std::nullopt;
  return std::pair(axes[0], axes[1]);
}

/// Puts two braces of equal weight w into every rectangle of next points and takes w from its four sides: at every
/// corner w (dx, dy) - w (dx, 0) - w (0, dy) = 0, so that (L) holds as before, and (M) too. A truss of rods alone is a
/// mechanism, which carries no shear; that at the end of a crack needs it. Nothing where points do not see across.
void add_braces(const Cloud& cloud, const Neighbours& neighbours, const Rods& rods, std::vector<double>& G) {
  const Lattice& lattice = *cloud.lattice;
  struct Entry {
    std::int64_t n;
    double change;
  };
  std::vector<Entry> entries;
  std::int64_t missing = 0;  // braces
  for (int i = 0; i < cloud.owned; ++i) {
    const LatticeIndex at = lattice.index(cloud.id[i]);
    std::int64_t ways = 0;
    for (int a = 0; a < cloud.dimension; ++a)
      for (int b = 0; b < a; ++b)
        ways +=
            (2 - lattice.lowest(at, a) - lattice.highest(at, a)) * (2 - lattice.lowest(at, b) - lattice.highest(at, b));
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      if (neighbours.is_image(n)) continue;
      const LatticeIndex to = index_of_neighbour(lattice, cloud, neighbours, n);
      LatticeIndex low = at;
      for (int a = 0; a < cloud.dimension; ++a) low[a] = std::min(at[a], to[a]);
      if (const auto axes = across(at, to, cloud.dimension)) {
        entries.push_back({n, rods.brace(low, axes->first, axes->second)});
        --ways;
      } else if (const auto is = on_line(lattice, cloud, neighbours, i, n);
                 is && is->pair.second == is->pair.first + 1) {
        entries.push_back({n, -rods.taken(low, is->axis)});
      }
    }
    missing += ways;
  }
  if (total(cloud.comm, missing) > 0) return;
  for (const auto& [n, change] : entries) G[n] += change;
}

}  // namespace

std::vector<double> lattice_line_weights(const Cloud& cloud, const Neighbours& neighbours, const LineForce& force,
                                         CorrectionReport& report) {
  const Lattice& lattice = *cloud.lattice;
  require_next(cloud, neighbours);
  std::array<LinePair, 3> range;
  range.fill({std::numeric_limits<std::int64_t>::max(), -1});
  std::int64_t most = 1;
  for (int i = 0; i < cloud.owned; ++i) {
    const LatticeIndex at = lattice.index(cloud.id[i]);
    for (int a = 0; a < 3; ++a) range[a] = {std::min(range[a].first, at[a]), std::max(range[a].second, at[a])};
    for_each_on_line(lattice, cloud, neighbours, i,
                     [&](std::int64_t, const OnLine& is) { most = std::max(most, is.pair.second - is.pair.first); });
  }
  most = max(cloud.comm, most);
  std::vector<Line> lines;
  lines.reserve(cloud.dimension);
  for (int a = 0; a < cloud.dimension; ++a)
    lines.emplace_back(lattice, a, cloud.axisymmetric && a == 0, force, most, range[a]);
  const Rods rods(cloud, std::move(lines));

  std::vector<double> G(neighbours.column.size());
  for (int i = 0; i < cloud.owned; ++i) {
    const LatticeIndex at = lattice.index(cloud.id[i]);
    // A point that no image reaches has no pair on whose force images bear.
    std::array<Ends, 3> ends = {};
    for_each_on_line(lattice, cloud, neighbours, i, [&](std::int64_t, const OnLine& is) {
      ends[is.axis].low |= is.pair.first < 0;
      ends[is.axis].high |= is.pair.second >= lattice.box().points[is.axis];
    });
    for_each_on_line(lattice, cloud, neighbours, i, [&](std::int64_t n, const OnLine& is) {
      G[n] = rods.weight(at, is, ends[is.axis], std::abs(neighbours.x_ji(cloud.x, i, n)[is.axis]));
    });
  }
  if (cloud.whole) add_braces(cloud, neighbours, rods, G);
  report = {.lattice_shortcut = true, .pairs = total(cloud.comm, static_cast<std::int64_t>(G.size()))};
  report.residual = largest_residual(cloud, neighbours, G);
  return G;
}

std::vector<double> neighbour_line_weights(const Cloud& cloud, const Neighbours& neighbours, CorrectionReport& report) {
  const LineForce force = [](std::int64_t steps, double /*distance*/, double /*spacing*/) {
    return steps == 1 ? 1.0 : 0.0;
  };
  return lattice_line_weights(cloud, neighbours, force, report);
}

}  // namespace calor
