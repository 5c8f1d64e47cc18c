#include "cloud/lattice.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace calor {

Lattice::Lattice(const BoxLattice& box) : box_(box) {
  for (int a = box.dimension; a < 3; ++a) box_.points[a] = 1, box_.size[a] = 0;
  for (int a = 0; a < box.dimension; ++a) {
    if (!graded(a)) continue;
    const std::vector<double>& x = box.coordinates[a];
    box_.origin[a] = x.front(), box_.size[a] = x.back() - x.front();
    box_.points[a] = static_cast<std::int64_t>(x.size()) - (box.on_walls ? 0 : 1);
  }
  for (int a = 0; a < box.dimension; ++a) dx_[a] = box_.size[a] / static_cast<double>(cells(a));
}

void Lattice::end_cells_at(int axis, std::span<const double> places) {
  const double close = 1e-9 * box_.size[axis];
  std::vector<double> ends;
  for (std::int64_t i = 0; i + 1 < box_.points[axis]; ++i) {
    const double low = coordinate(axis, i), high = coordinate(axis, i + 1);
    std::vector<double> here;
    for (const double x : places)
      if (x >= low - close && x < high - close) here.push_back(std::max(x, low));
    ends.push_back(here.size() == 1 ? here.front() : cell(axis, i).second);
  }
  ends_[axis] = std::move(ends);
}

LatticeIndex Lattice::index(std::int64_t id) const {
  const auto& n = box_.points;
  return {id % n[0], id / n[0] % n[1], id / (n[0] * n[1])};
}

double Lattice::largest_dx() const { return *std::max_element(dx_.begin(), dx_.begin() + box_.dimension); }

double Lattice::least_dx() const { return *std::min_element(dx_.begin(), dx_.begin() + box_.dimension); }

double Lattice::spacing(int axis, std::int64_t i) const {
  if (!graded(axis)) return dx_[axis];
  const double below = i > 0 ? coordinate(axis, i) - coordinate(axis, i - 1) : 0;
  const double above = i + 1 < box_.points[axis] ? coordinate(axis, i + 1) - coordinate(axis, i) : 0;
  return std::max(below, above) > 0 ? std::max(below, above) : box_.size[axis];
}

double Lattice::coordinate(int axis, std::int64_t i) const {
  if (axis >= box_.dimension) return 0;
  if (graded(axis)) {
    const std::vector<double>& x = box_.coordinates[axis];
    return box_.on_walls ? x[i] : 0.5 * (x[i] + x[i + 1]);
  }
  if (!box_.on_walls) return box_.origin[axis] + (static_cast<double>(i) + 0.5) * dx_[axis];
  // The last point lies on the wall to the last bit.
  if (i == box_.points[axis] - 1) return box_.origin[axis] + box_.size[axis];
  return box_.origin[axis] + static_cast<double>(i) * dx_[axis];
}

double Lattice::width(int axis, std::int64_t i) const {
  if (axis >= box_.dimension) return 1;
  if (graded(axis) || !ends_[axis].empty()) {
    const auto [low, high] = cell(axis, i);
    return high - low;
  }
  const bool half = box_.on_walls && (i == 0 || i == box_.points[axis] - 1);
  return half ? 0.5 * dx_[axis] : dx_[axis];
}

double Lattice::full_width(int axis, std::int64_t i) const {
  if (!graded(axis) && ends_[axis].empty()) return dx_[axis];
  const bool half = box_.on_walls && (i == 0 || i == box_.points[axis] - 1);
  return (half ? 2 : 1) * width(axis, i);
}

std::pair<double, double> Lattice::cell(int axis, std::int64_t i) const {
  auto [low, high] = cell_to_middles(axis, i);
  if (axis >= box_.dimension || ends_[axis].empty()) return {low, high};
  if (i > 0) low = ends_[axis][i - 1];
  if (i < box_.points[axis] - 1) high = ends_[axis][i];
  return {low, high};
}

std::pair<double, double> Lattice::cell_to_middles(int axis, std::int64_t i) const {
  if (axis >= box_.dimension) return {0, 0};
  if (graded(axis) && !box_.on_walls) return {box_.coordinates[axis][i], box_.coordinates[axis][i + 1]};
  if (graded(axis)) {
    const double x = coordinate(axis, i);
    return {i == 0 ? x : 0.5 * (coordinate(axis, i - 1) + x),
            i == box_.points[axis] - 1 ? x : 0.5 * (x + coordinate(axis, i + 1))};
  }
  const double low = box_.origin[axis], high = low + box_.size[axis];
  const double centre = low + (static_cast<double>(i) + (box_.on_walls ? 0 : 0.5)) * dx_[axis];
  return {i == 0 ? low : centre - 0.5 * dx_[axis], i == box_.points[axis] - 1 ? high : centre + 0.5 * dx_[axis]};
}

bool Lattice::moves(const LatticeIndex& i, int axis) const {
  if (box_.jitter == 0 || axis >= box_.dimension) return false;
  if (box_.on_walls) return !lowest(i, axis) && !highest(i, axis);
  // The area vectors of outermost cells only balance about their centres.
  for (int a = 0; a < box_.dimension; ++a)
    if (lowest(i, a) || highest(i, a)) return false;
  return true;
}

Vec3 Lattice::position(const LatticeIndex& i) const {
  Vec3 x;
  for (int a = 0; a < box_.dimension; ++a) x[a] = coordinate(a, i[a]);
  if (box_.jitter == 0) return x;
  const Vec3 u = hashed_uniform(box_.seed, id(i));
  for (int a = 0; a < box_.dimension; ++a)
    if (moves(i, a)) x[a] += box_.jitter * dx_[a] * (2 * u[a] - 1);
  return x;
}

double Lattice::wall_area(const LatticeIndex& i, int axis) const {
  double area = 1;
  if (box_.jitter == 0 || !box_.on_walls) {
    for (int a = 0; a < box_.dimension; ++a)
      if (a != axis) area *= width(a, i[a]);
    return area;
  }
  if (box_.dimension == 1) return 1;
  const int b = axis == 0 ? 1 : 0;
  const auto at = [&](LatticeIndex j, int a, int step) { return j[a] += step, j; };
  const auto inside = [&](int a, int step) { return i[a] + step >= 0 && i[a] + step < box_.points[a]; };
  if (box_.dimension == 2) {  // half of both segments
    area = 0;
    for (int s : {-1, 1})
      if (inside(b, s)) area += 0.5 * s * (position(at(i, b, s))[b] - position(i)[b]);
    return area;
  }
  // A third of the triangles around the point; every quadrilateral of the wall is split along both diagonals and the
  // two splittings averaged.
  const int c = axis == 2 ? 1 : 2;
  const Vec3 p = position(i);
  const auto triangle = [&](const Vec3& u, const Vec3& v, const Vec3& w) {
    return 0.5 * ((v[b] - u[b]) * (w[c] - u[c]) - (w[b] - u[b]) * (v[c] - u[c]));
  };
  area = 0;
  for (int s : {-1, 1}) {
    for (int t : {-1, 1}) {
      if (!inside(b, s) || !inside(c, t)) continue;
      const Vec3 q = position(at(i, b, s)), r = position(at(at(i, b, s), c, t)), o = position(at(i, c, t));
      area += s * t * (triangle(p, q, r) + triangle(p, r, o) + triangle(p, q, o)) / 6;
    }
  }
  return area;
}

Vec3 hashed_uniform(std::uint64_t seed, std::uint64_t counter) {
  // Finalizer of SplitMix64 (Steele, Lea & Flood, Fast splittable pseudorandom number generators, OOPSLA 2014).
  const auto mix = [](std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  };
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15ull, low_bits = (1u << 21) - 1;
  const std::uint64_t h = mix(mix(seed + golden) + (counter + 1) * golden);
  const auto uniform = [](std::uint64_t bits) { return static_cast<double>(bits) * 0x1p-21; };
  return {uniform(h & low_bits), uniform(h >> 21 & low_bits), uniform(h >> 43)};
}

Points lattice_points(MPI_Comm comm, const BoxLattice& asked) {
  const Lattice lattice(asked);
  const BoxLattice& box = lattice.box();
  const int D = box.dimension;
  double count = 1;
  for (const std::int64_t points : box.points) count *= static_cast<double>(points);
  refuse_too_many(comm, count);
  Points out;
  out.dimension = D;
  out.section = box.section;
  out.points_on_walls = box.on_walls;
  out.exact.volume = box.section;
  for (int a = 0; a < D; ++a) {
    const std::string axis(1, "xyz"[a]);
    out.faces.insert(out.faces.end(), {axis + "min", axis + "max"});
    out.walls.insert(out.walls.end(), {box.origin[a], box.origin[a] + box.size[a]});
    out.exact.volume *= box.size[a];
  }
  const double most = lattice.largest_dx(), least = lattice.least_dx();
  if (box.jitter == 0) out.lattice = std::make_shared<const Lattice>(lattice);
  out.box_lattice = box.jitter == 0 && !lattice.graded() && most - least <= 1e-9 * most;

  const Slice mine = slice(comm, lattice.count());
  if (box.jitter > 0) out.jittered = std::make_shared<const Lattice>(lattice);
  out.points.reserve(mine.end - mine.begin);
  LatticeIndex i = lattice.index(mine.begin);
  for (std::int64_t id = mine.begin; id < mine.end; ++id) {
    double v = box.section, full = box.section, spacing = 0;
    Vec3 metric;
    for (int a = 0; a < D; ++a) {
      v *= lattice.width(a, i[a]);
      full *= lattice.full_width(a, i[a]);
      metric[a] = lattice.spacing(a, i[a]);
      spacing = std::max(spacing, metric[a]);
    }
    out.points.push_back(
        {.id = id, .x = lattice.position(i), .volume = v, .full_volume = full, .spacing = spacing, .metric = metric});
    for (int a = 0; a < D; ++a) {
      Vec3 normal;
      if (lattice.lowest(i, a)) normal[a] = -1, out.add_patch(2 * a, box.section * lattice.wall_area(i, a), normal);
      if (lattice.highest(i, a)) normal[a] = 1, out.add_patch(2 * a + 1, box.section * lattice.wall_area(i, a), normal);
    }
    for (int a = 0; a < 3 && ++i[a] == box.points[a]; ++a) i[a] = 0;
  }
  return out;
}

Points make_box(MPI_Comm comm, const BoxLattice& box) {
  Points points = lattice_points(comm, box);
  if (points.jittered)
    set_volumes(points, nearest_point_volumes(*points.jittered, slice(comm, points.jittered->count())));
  return points;
}

void set_volumes(Points& points, std::span<const double> volume) {
  for (std::size_t n = 0; n < volume.size(); ++n) points.points[n].volume = points.section * volume[n];
  points.jittered = nullptr;
}

}  // namespace calor
