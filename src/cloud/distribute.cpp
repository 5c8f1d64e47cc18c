#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/parallel.hpp"
#include "cloud/bisection.hpp"
#include "cloud/cells.hpp"
#include "cloud/points.hpp"
#include "cloud/search.hpp"

namespace calor {
namespace {

void refuse_bad_points(MPI_Comm comm, const Points& points) {
  if (total(comm, static_cast<std::int64_t>(points.points.size())) == 0)
    throw Error(Fault::bad_case, "the cloud has no points", "give it some");
  const auto refuse = [](const Point& p, const std::string& what, const std::string& cure) {
    throw Error(Fault::bad_case,
                fmt::format("point {} at ({:.6g}, {:.6g}, {:.6g}) m {}", p.id, p.x.x, p.x.y, p.x.z, what), cure);
  };
  collective_try(comm, [&] {
    for (const Point& p : points.points) {
      if (!std::isfinite(p.x.x + p.x.y + p.x.z)) refuse(p, "has no finite place", "give it numbers");
      if (!(p.volume > 0 && std::isfinite(p.volume)))
        refuse(p, fmt::format("has a volume of {:.6g} m^3", p.volume),
               "give every point the volume of the body that it stands for");
      if (!(p.spacing > 0 && std::isfinite(p.spacing)))
        refuse(p, fmt::format("has a spacing of {:.6g} m", p.spacing), "give every point its distance to the next");
    }
  });
}

/// Offsets of every point's facets.
std::vector<std::int32_t> patch_offsets(const std::vector<Point>& points) {
  std::vector<std::int32_t> at(points.size() + 1, 0);
  for (std::size_t i = 0; i < points.size(); ++i) at[i + 1] = at[i] + points[i].facets;
  return at;
}

void send_to_blocks(MPI_Comm comm, Points& points) {
  const int ranks = size_of(comm);
  if (ranks == 1) return;
  const std::vector<int> rank = bisect(comm, points.points);
  const std::vector<std::int32_t> at = patch_offsets(points.points);
  std::vector<int> point_count(ranks, 0), patch_count(ranks, 0);
  for (std::size_t i = 0; i < rank.size(); ++i) {
    ++point_count[rank[i]];
    patch_count[rank[i]] += points.points[i].facets;
  }
  std::vector<std::int64_t> next_point(ranks, 0), next_patch(ranks, 0);
  std::exclusive_scan(point_count.begin(), point_count.end(), next_point.begin(), std::int64_t{0});
  std::exclusive_scan(patch_count.begin(), patch_count.end(), next_patch.begin(), std::int64_t{0});
  std::vector<Point> packed(points.points.size());
  std::vector<SurfacePiece> packed_patches(points.facets.size());
  for (std::size_t i = 0; i < rank.size(); ++i) {
    packed[next_point[rank[i]]++] = points.points[i];
    for (std::int32_t n = at[i]; n < at[i + 1]; ++n) packed_patches[next_patch[rank[i]]++] = points.facets[n];
  }
  points.points = std::vector<Point>();  // {} would keep their memory
  points.facets = std::vector<SurfacePiece>();
  points.points = exchange(comm, packed, point_count);
  points.facets = exchange(comm, packed_patches, patch_count);
}

/// Spacings along the axes that the body does not have; those that differ by rounding alone become one.
void complete_metric(std::vector<Point>& points, int dimension) {
  for (Point& p : points) {
    if (p.metric == Vec3{}) p.metric = {p.spacing, p.spacing, p.spacing};
    p.spacing = 0;
    for (int a = 0; a < dimension; ++a) p.spacing = std::max(p.spacing, p.metric[a]);
    for (int a = 0; a < 3; ++a)
      if (a >= dimension || p.spacing - p.metric[a] <= 1e-9 * p.spacing) p.metric[a] = p.spacing;
  }
}

/// Moves this rank's points into the arrays of the cloud, in the order of cells of one (mean) spacing.
void fill_owned(Cloud& cloud, Points& points) {
  const std::vector<Point>& p = points.points;
  const std::size_t n = p.size();
  std::vector<std::int32_t> by_id(n);
  std::iota(by_id.begin(), by_id.end(), 0);
  if (!std::ranges::is_sorted(p, {}, &Point::id)) std::ranges::sort(by_id, {}, [&](std::int32_t i) { return p[i].id; });
  std::vector<Vec3> x(n);
  Vec3 sum;
  for (std::size_t i = 0; i < n; ++i) x[i] = p[i].x, sum += p[i].metric;
  const Cells cells(x, (1 / static_cast<double>(std::max<std::size_t>(1, n))) * sum);
  const std::vector<std::int32_t> order = order_by_cells(cells, x, by_id).order;
  by_id = std::vector<std::int32_t>();
  x = std::vector<Vec3>();

  const std::vector<std::int32_t> at = patch_offsets(p);
  cloud.owned = static_cast<int>(n);
  cloud.first = offset(cloud.comm, cloud.owned);
  cloud.count = total(cloud.comm, cloud.owned);
  const auto fill = [&](auto& array, auto Point::*member) {
    array.reserve(n);
    for (std::int32_t i : order) array.push_back(p[i].*member);
  };
  fill(cloud.id, &Point::id);
  fill(cloud.x, &Point::x);
  fill(cloud.volume, &Point::volume);
  fill(cloud.full_volume, &Point::full_volume);
  fill(cloud.metric, &Point::metric);
  fill(cloud.spacing, &Point::spacing);
  fill(cloud.area, &Point::area);
  fill(cloud.on_faces, &Point::on_faces);
  fill(cloud.tag, &Point::tag);
  cloud.global.resize(n);
  std::iota(cloud.global.begin(), cloud.global.end(), cloud.first);
  cloud.facets.reserve(points.facets.size());
  for (std::size_t k = 0; k < n; ++k)
    for (std::int32_t m = at[order[k]]; m < at[order[k] + 1]; ++m)
      cloud.facets.push_back(
          {static_cast<int>(k), points.facets[m].face, points.facets[m].area, points.facets[m].normal});
  points.points = std::vector<Point>();  // {} would keep their memory
  points.facets = std::vector<SurfacePiece>();
}

/// A copy of a point for another rank.
struct Ghost {
  std::int64_t id, global;
  Vec3 x;
  double volume, full_volume, spacing;
  Vec3 metric, area;
  std::uint32_t on_faces;
  int tag;
};

/// Square of the distance over `reach`, axis by axis.
double square_distance(const Vec3& x, const Bounds& box, const Vec3& reach) {
  double square = 0;
  for (int a = 0; a < 3; ++a) {
    const double d = std::max({0.0, box.low[a] - x[a], x[a] - box.high[a]}) / reach[a];
    square += d * d;
  }
  return square;
}

/// The block of a rank and the largest spacings in it.
struct Block {
  Bounds box;
  Vec3 metric = {};
};

void add_ghosts(Cloud& cloud) {
  const int ranks = size_of(cloud.comm), rank = rank_of(cloud.comm);
  if (ranks == 1) return;
  Block mine{.box = bounds_of(cloud.owned_points())};
  for (const Vec3& s : cloud.metric)
    for (int a = 0; a < 3; ++a) mine.metric[a] = std::max(mine.metric[a], s[a]);
  const std::vector<Block> blocks = gather(cloud.comm, std::vector{mine});
  // Rounding must not lose a point at exactly the support.
  const auto reach = [&](const Vec3& s_i, const Vec3& s_j) {
    Vec3 r = cloud.halo_support.radius(0.5 * (s_i + s_j));
    for (int a = 0; a < 3; ++a) r[a] = std::min(cloud.halo_width, r[a]) * (1 + 1e-9);
    return r;
  };
  std::vector<Ghost> packed;
  std::vector<int> counts(ranks, 0);
  for (int r = 0; r < ranks; ++r) {
    const auto& [box, metric] = blocks[r];
    const Vec3 most = reach(mine.metric, metric);
    bool far = r == rank;
    for (int a = 0; a < 3; ++a)
      far = far || !(mine.box.low[a] <= box.high[a] + most[a] && mine.box.high[a] >= box.low[a] - most[a]);
    if (far) continue;
    const std::size_t before = packed.size();
    for (int i = 0; i < cloud.owned; ++i) {
      if (square_distance(cloud.x[i], box, reach(cloud.metric[i], metric)) > 1) continue;
      packed.push_back({cloud.id[i], cloud.global[i], cloud.x[i], cloud.volume[i], cloud.full_volume[i],
                        cloud.spacing[i], cloud.metric[i], cloud.area[i], cloud.on_faces[i], cloud.tag[i]});
    }
    counts[r] = static_cast<int>(packed.size() - before);
  }
  // They arrive in the order of their global numbers.
  std::vector<Ghost> ghosts = exchange(cloud.comm, packed, counts);
  if (std::isfinite(cloud.halo_support.over_spacing)) {
    // The block is larger than the support of most of its points: keep what one of them sees.
    const Search search(cloud, {(1 + 2e-9) * cloud.halo_support.over_spacing, (1 + 2e-9) * cloud.halo_support.length});
    std::vector<std::int32_t> buffer;
    int coincident = 0;
    std::erase_if(ghosts, [&](const Ghost& g) { return search.find(g.x, g.metric, buffer, coincident).empty(); });
  }
  for (const Ghost& g : ghosts) {
    cloud.id.push_back(g.id);
    cloud.global.push_back(g.global);
    cloud.x.push_back(g.x);
    cloud.volume.push_back(g.volume);
    cloud.full_volume.push_back(g.full_volume);
    cloud.metric.push_back(g.metric);
    cloud.spacing.push_back(g.spacing);
    cloud.area.push_back(g.area);
    cloud.on_faces.push_back(g.on_faces);
    cloud.tag.push_back(g.tag);
  }
  cloud.halo = Halo(cloud.comm, cloud.owned, std::span(cloud.global).subspan(cloud.owned));
}

Cloud distribute(MPI_Comm comm, Points points, double width, const Support& support) {
  refuse_bad_points(comm, points);
  Cloud cloud;
  cloud.comm = comm;
  cloud.dimension = points.dimension;
  cloud.cross_section = points.section;
  cloud.faces = std::move(points.faces);
  cloud.tags = std::move(points.tags);
  cloud.lattice = std::move(points.lattice);
  cloud.disc = cloud.rings = std::move(points.rings);
  cloud.walls = std::move(points.walls);
  cloud.body = std::move(points.body);
  cloud.solids = std::move(points.solids);
  cloud.box_lattice = points.box_lattice;
  cloud.nearest_volumes = points.nearest_volumes;
  cloud.points_on_walls = points.points_on_walls;
  cloud.has_areas = points.has_areas;
  cloud.exact = points.exact;
  cloud.notes = std::move(points.notes);
  complete_metric(points.points, cloud.dimension);
  const auto is_isotropic = [](const Point& p) { return p.metric == Vec3{p.spacing, p.spacing, p.spacing}; };
  cloud.isotropic = !any(comm, !std::ranges::all_of(points.points, is_isotropic));
  send_to_blocks(comm, points);
  fill_owned(cloud, points);
  cloud.halo_width = width;
  cloud.halo_support = support;
  add_ghosts(cloud);
  cloud.open_eyes();
  return cloud;
}

}  // namespace

Cloud distribute(MPI_Comm comm, Points points, double support) {
  return distribute(comm, std::move(points), support, std::numeric_limits<double>::infinity());
}

Cloud distribute(MPI_Comm comm, Points points, const Support& support) {
  double spacing = 0;
  for (const Point& p : points.points) spacing = std::max(spacing, p.spacing);
  return distribute(comm, std::move(points), support.radius(max(comm, spacing)), support);
}

Points owned_points(const Cloud& cloud) {
  Points out;
  out.dimension = cloud.dimension;
  out.section = cloud.cross_section;
  out.faces = cloud.faces;
  out.tags = cloud.tags;
  out.solids = cloud.solids;
  out.lattice = cloud.lattice;
  out.rings = cloud.rings;
  out.walls = cloud.walls;
  out.box_lattice = cloud.box_lattice;
  out.nearest_volumes = cloud.nearest_volumes;
  out.points_on_walls = cloud.points_on_walls;
  out.has_areas = cloud.has_areas;
  out.exact = cloud.exact;
  out.notes = cloud.notes;
  out.points.reserve(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i)
    out.points.push_back({.id = cloud.id[i],
                          .x = cloud.x[i],
                          .volume = cloud.volume[i],
                          .full_volume = cloud.full_volume[i],
                          .spacing = cloud.spacing[i],
                          .area = cloud.area[i],
                          .metric = cloud.metric[i],
                          .on_faces = cloud.on_faces[i],
                          .tag = cloud.tag[i]});
  for (const Facet& facet : cloud.facets) {
    ++out.points[facet.point].facets;
    out.facets.push_back({.face = facet.face, .area = facet.area, .normal = facet.normal});
  }
  return out;
}

}  // namespace calor
