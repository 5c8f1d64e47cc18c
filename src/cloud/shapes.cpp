#include "cloud/shapes.hpp"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/cache.hpp"
#include "base/parallel.hpp"
#include "case/json.hpp"
#include "cloud/lattice.hpp"

namespace calor {
CloudShape box_shape(), disc_shape(), cylinder_shape(), rows_shape(), csv_shape(), surface_shape(), mesh_shape();
void declare_surface(Schema& schema);

Registry<CloudShape>& cloud_shapes() {
  static Registry<CloudShape> all = {box_shape(), disc_shape(),    cylinder_shape(), rows_shape(),
                                     csv_shape(), surface_shape(), mesh_shape()};
  return all;
}

void Points::add_patch(int face, double area, const Vec3& normal, const Vec3& area_vector) {
  Point& p = points.back();
  p.on_faces |= std::uint32_t{1} << face;
  p.area += area_vector;
  ++p.facets;
  facets.push_back({face, area, normal});
}

void refuse_too_many(MPI_Comm comm, double count) {
  constexpr double bytes = 200;  // of a point, at least
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  const int ranks = size_of(comm);
  const double most = std::min<double>(std::numeric_limits<std::int32_t>::max(), memory / bytes);
  if (!(count / ranks < most))
    throw Error(Fault::bad_case,
                fmt::format("the cloud has {:.6g} points, too many for {} process{} and {:.3g} GB of memory", count,
                            ranks, ranks > 1 ? "es" : "", memory / 1e9),
                "take a larger spacing, or more machines");
}

Slice slice(MPI_Comm comm, std::int64_t count) {
  refuse_too_many(comm, static_cast<double>(count));
  const std::int64_t ranks = size_of(comm), rank = rank_of(comm);
  // count * rank / ranks without overflow.
  const auto cut = [&](std::int64_t r) { return count / ranks * r + count % ranks * r / ranks; };
  return {cut(rank), cut(rank + 1)};
}

double section_of(const Table& cloud, int dimension) {
  if (dimension != 2 && cloud.has("thickness"))
    cloud.refuse("thickness",
                 fmt::format("a body of {} dimension{} has no thickness", dimension, dimension > 1 ? "s" : ""),
                 "remove it");
  if (dimension != 1 && cloud.has("section"))
    cloud.refuse("section", fmt::format("a body of {} dimensions has no cross-section", dimension), "remove it");
  if (dimension == 3) return 1;
  const std::string key = dimension == 2 ? "thickness" : "section";
  if (!(cloud.number(key) > 0))
    cloud.refuse(key, fmt::format("{} = {} is not positive", key, cloud.number(key)), "give a positive one");
  return cloud.number(key);
}

std::int64_t intervals(const Table& cloud, double length, double spacing) {
  if (!(spacing > 0))
    cloud.refuse("spacing", fmt::format("a spacing of {} m is not positive", spacing), "give a positive one");
  const double ratio = length / spacing;
  const double n = std::max(1.0, std::round(ratio));
  if (!(n < std::numeric_limits<std::int32_t>::max()))
    cloud.refuse(
        "spacing",
        fmt::format("a spacing of {:.6g} m divides a length of {:.6g} m into {:.3g} parts", spacing, length, n),
        "take a larger one");
  if (std::abs(ratio - n) > 1e-6 * n)
    cloud.refuse(
        "spacing", fmt::format("a spacing of {:.6g} m does not divide a length of {:.6g} m", spacing, length),
        ratio < 1 ? fmt::format("take {:.10g} m", length)
                  : fmt::format("take {:.10g} m or {:.10g} m", length / std::floor(ratio), length / std::ceil(ratio)));
  return static_cast<std::int64_t>(n);
}

namespace {

/// Volumes of a jittered lattice: weights of a quadrature, or those of the nearest points.
void set_volumes(MPI_Comm comm, Points& points, bool are_quadrature, Cache* cache) {
  const Lattice& lattice = *points.jittered;
  const Slice mine = slice(comm, lattice.count());
  std::vector<double> volume;
  const auto make = [&] {
    volume = are_quadrature ? linearly_exact_volumes(lattice, mine) : nearest_point_volumes(lattice, mine);
  };
  if (cache) {
    const BoxLattice& box = lattice.box();
    Fingerprint from;
    from.add(are_quadrature)
        .add(box.dimension)
        .add(std::span<const double>(box.size))
        .add(std::span<const std::int64_t>(box.points));
    from.add(std::span(&box.origin, 1)).add(box.on_walls).add(box.jitter).add(box.seed);
    from.add(mine.begin).add(mine.end);
    cache->get(comm, "volumes", Cache::Owner::rank, from, {&volume}, make);
  } else {
    make();
  }
  set_volumes(points, volume);
}

/// Has every point on the axis a piece of the cut along it? Without one its cell would go on beyond the axis.
bool is_cut_along_axis(MPI_Comm comm, const Points& points) {
  bool is_open = false;
  auto piece = points.facets.begin();
  for (const Point& p : points.points) {
    const auto end = piece + p.facets;
    is_open =
        is_open || (p.x.x == 0 && std::none_of(piece, end, [](const SurfacePiece& s) { return s.normal.x < -0.9; }));
    piece = end;
  }
  return !any(comm, is_open);
}

/// Refuses what cannot be revolved about the y axis; points that rounding keeps from it lie on it. Collective.
void require_section(MPI_Comm comm, const Table& table, Points& points) {
  const std::string shape = table.text("shape");
  if (points.dimension != 2)
    table.refuse(
        "axisymmetric",
        fmt::format("an axisymmetric body is described by two coordinates, x = r and y = z, and this cloud has "
                    "{}",
                    points.dimension),
        "describe half of its axial section, or leave axisymmetric out");
  if (shape == "disc")
    table.refuse("axisymmetric", "a disc does not lie on one side of an axis",
                 "describe half of the axial section by a box, rows or a CSV file");
  if (table.has("thickness"))
    table.refuse("thickness", "an axisymmetric body has no thickness: it goes all around", "remove it");
  double lowest = points.walls.empty() ? 0 : points.walls[0], farthest = 0;
  for (const Point& p : points.points) farthest = std::max(farthest, p.x.x);
  farthest = max(comm, farthest);
  for (Point& p : points.points) {
    if (std::abs(p.x.x) < 1e-12 * farthest) p.x.x = 0;
    lowest = std::min(lowest, p.x.x);
  }
  lowest = min(comm, lowest);
  if (lowest < 0)
    table.refuse("axisymmetric", fmt::format("the cloud reaches to x = {:.6g} m, beyond the axis at x = 0", lowest),
                 "x is the distance from the axis: shift the cloud");
  if (points.has_areas && !is_cut_along_axis(comm, points))
    table.refuse("axisymmetric", "points on the axis lack a piece of surface along it",
                 "give the cut along the axis its areas, as every wall of the section: they vanish all around");
}

/// Names come from files, and go into others.
void require_plain_text(std::span<const std::string> names) {
  const auto bad = std::ranges::find_if_not(names, is_plain_text);
  if (bad != names.end())
    throw Error(Fault::bad_case,
                fmt::format("the name {} of a face or tag has bytes that are no text in UTF-8", json_string(*bad)),
                "save the file that names it as UTF-8, without control characters");
}

}  // namespace

std::shared_ptr<Cache> cache_of(const Table& cloud) {
  return cloud.flag("keep") ? std::make_shared<Cache>(Cache::users_folder()) : nullptr;
}

SourceLocation location_of_points(const Table& cloud) {
  if (cloud.has("file")) return cloud.location("file");
  if (cloud.text("shape") == "surface") return cloud.location(cloud.has("points") ? "points" : "spacing");
  return cloud.location("shape");
}

Cloud make_cloud(MPI_Comm comm, const Case& c, const Support& support) {
  const Table table = c.section("cloud");
  const std::string shape = table.text("shape");
  for (const std::string key : {"part", "near"})
    if (const std::vector<Table> list = table.list(key); !list.empty() && shape != "surface")
      list.front().refuse("", fmt::format("[[cloud.{}]] has no effect on a cloud of shape \"{}\"", key, shape),
                          "remove it, or take shape = \"surface\"");
  if (table.has("distance") && shape != "surface")
    table.refuse("distance", fmt::format("[cloud.distance] has no effect on a cloud of shape \"{}\"", shape),
                 "remove it, or take shape = \"surface\"");
  Points points = cloud_shapes().chosen(table, "shape").make(comm, table);
  const bool axisymmetric = table.flag("axisymmetric");
  if (axisymmetric) require_section(comm, table, points);
  // The weights of pairs want volumes that are a quadrature at the points; MLPG balances cells.
  const bool is_quadrature = points.jittered && points.points_on_walls && c.root().text("method") != "mlpg";
  const std::shared_ptr<Cache> cache = cache_of(table);
  if (points.jittered) set_volumes(comm, points, is_quadrature, cache.get());
  const bool are_cells = !is_quadrature && !points.estimated_spacings && !points.body;
  if (points.estimated_spacings) points = settle_spacings(comm, std::move(points));
  Cloud cloud = distribute(comm, std::move(points), support);
  for (const auto* names : {&cloud.tags, &cloud.faces}) require_plain_text(*names);
  cloud.cache = cache;
  if (!axisymmetric) return cloud;
  if (!cloud.points_on_walls && !cloud.lattice)
    table.refuse("axisymmetric", "the points of an axisymmetric cloud that is no lattice have to lie on its walls",
                 table.has("file") ? "put points on the walls" : "use at = \"walls\", or leave out jitter");
  revolve(cloud, are_cells);
  return cloud;
}

void declare_cloud(Schema& schema) {
  schema.add({.path = "cloud",
              .sentence = "The points that stand for the body.",
              .keys = {{"shape", Kind::choice, "", required, "What makes the points.", cloud_shapes().names()},
                       {"thickness", Kind::quantity, "m", "1 m", "Thickness of a body of two dimensions."},
                       {"section", Kind::quantity, "m^2", "1 m^2", "Cross-section of a body of one dimension."},
                       {"axisymmetric", Kind::flag, "", "false",
                        "The body is the revolution of a two-dimensional cloud about the y axis: x is the distance "
                        "from the axis, y the height. Areas, powers and energies are those of the whole body; the "
                        "volumes and areas of a CSV file are those of the plane cloud with a thickness of 1 m."},
                       {"keep", Kind::flag, "", "false",
                        "Keep volumes, areas and weights of pairs, which take long on irregular clouds, for the next "
                        "run that makes the same cloud: in the folder that CALOR_CACHE in the environment names, or "
                        "~/.cache/calor, up to 10 GiB. What is kept is found by a hash of all that it follows from, "
                        "so that results are the same to the last bit; the folder may be deleted at any time."}}});
  for (const CloudShape& shape : cloud_shapes())
    schema.add({.path = "cloud",
                .sentence = shape.sentence + ".",
                .keys = shape.keys,
                .when_key = "shape",
                .when_value = shape.name});
  declare_surface(schema);
}

}  // namespace calor
