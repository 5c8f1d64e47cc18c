// `calor cloud`: the points alone, to be looked at before a case runs.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "app/verbs.hpp"
#include "base/parallel.hpp"
#include "cloud/neighbours.hpp"
#include "cloud/points.hpp"
#include "cloud/shapes.hpp"
#include "conduction/method.hpp"
#include "output/files.hpp"
#include "output/vtu.hpp"
#include "surface/body.hpp"

namespace calor {
namespace {

/// How a point sees its neighbours, and the body around it.
struct Quality {
  std::vector<double> neighbours;
  std::vector<double> evenness;  ///< 1: they lie alike in all directions, 0: in a plane
  std::vector<double> lean;      ///< mean of the unit vectors to them: 0 inside, 0.5 on a flat wall
  std::vector<double> walls;     ///< of points on one wall: way through the body to the opposite one, spacings
};

/// Walls farther away than this many spacings are not looked for.
constexpr double farthest = 5;

/// Way from a point on a wall along its inward normal to the opposite wall, in spacings.
double thickness(const Cloud& cloud, const Facet& facet) {
  const double d = cloud.spacing[facet.point];
  const Vec3& from = cloud.inside[facet.point];
  const auto reaches = [&](double spacings) { return cloud.body->sees(from, from - spacings * d * facet.normal); };
  if (reaches(farthest)) return farthest;
  double low = 0, high = farthest;
  for (int halving = 0; halving < 20; ++halving) (reaches(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return low + Body::skin;
}

Quality quality_of(const Cloud& cloud, const Neighbours& neighbours) {
  Quality q;
  for (int i = 0; i < cloud.owned; ++i) {
    Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
    Vec3 sum;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 x = neighbours.x_ji(cloud.x, i, n), e = (1 / norm(x)) * x;
      M += Eigen::Vector3d(e.x, e.y, e.z) * Eigen::RowVector3d(e.x, e.y, e.z);
      sum += e;
    }
    const double count = static_cast<double>(neighbours.of(i).size()), few = std::max(1.0, count);
    const int D = cloud.dimension;
    const Eigen::MatrixXd of_body = M.topLeftCorner(D, D);
    q.neighbours.push_back(count);
    q.evenness.push_back(D * Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(of_body).eigenvalues()[0] / few);
    q.lean.push_back(norm(sum) / few);
  }
  q.walls.assign(cloud.owned, farthest);
  if (!cloud.body) return q;
  std::vector<int> facets(cloud.owned);
  for (const Facet& facet : cloud.facets) ++facets[facet.point];
  for (const Facet& facet : cloud.facets)
    if (facets[facet.point] == 1) q.walls[facet.point] = thickness(cloud, facet);
  return q;
}

/// A value and the place where it is.
struct Placed {
  double value;
  Vec3 x;
};

/// The lowest of the values of all ranks. Collective.
Placed lowest_of(const Cloud& cloud, const std::vector<double>& values) {
  Placed mine{std::numeric_limits<double>::max(), {}};
  for (int i = 0; i < cloud.owned; ++i)
    if (values[i] < mine.value) mine = {values[i], cloud.x[i]};
  const std::vector<Placed> all = gather(cloud.comm, std::vector<Placed>{mine});
  return *std::ranges::min_element(all, {}, &Placed::value);
}

std::string told(const Vec3& x) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", x.x, x.y, x.z); }

/// Lines of the table, on all ranks. Collective.
std::vector<std::pair<std::string, std::string>> table(const Cloud& cloud, const Quality& q) {
  std::vector<std::pair<std::string, std::string>> lines;
  const auto line = [&](const std::string& what, const std::string& value) { lines.emplace_back(what, value); };
  const CloudCheck sound = check(cloud);
  const Bounds bounds = bounds_of_all(cloud);
  std::vector<std::string> extents;
  for (int a = 0; a < cloud.dimension; ++a) extents.push_back(fmt::format("{:.6g}", bounds.high[a] - bounds.low[a]));
  std::int64_t on_surface = 0;
  std::vector<std::int64_t> points(cloud.tags.size());
  std::vector<double> negative_spacing, negative_neighbours;
  for (int i = 0; i < cloud.owned; ++i) {
    on_surface += cloud.on_faces[i] != 0;
    ++points[cloud.tag[i]];
    negative_spacing.push_back(-cloud.spacing[i]);
  }
  line("points", fmt::format("{} in {}D, {} of them on the surface", cloud.count, cloud.dimension,
                             total(cloud.comm, on_surface)));
  line("size", fmt::format("{} m between the outermost points", fmt::join(extents, " x ")));
  const std::span<const double> spacing(cloud.spacing.data(), cloud.owned);
  const Placed finest = lowest_of(cloud, {spacing.begin(), spacing.end()}),
               coarsest = lowest_of(cloud, negative_spacing);
  line("spacing", fmt::format("{:.6g} m to {:.6g} m", finest.value, -coarsest.value));
  line("volume", fmt::format("{:.9g} m^3{}", sound.volume,
                             cloud.exact.volume > 0 ? fmt::format(", off by {:.1e}", sound.volume_error) : ""));
  line("boundary areas",
       fmt::format("sum {:.1e}, moment {:.1e} (both should vanish)", sound.area_sum, sound.moment_sum));
  if (cloud.tags.size() > 1) {
    add_up(cloud.comm, points);
    for (std::size_t t = 0; t < cloud.tags.size(); ++t)
      line("tag", fmt::format("{}: {} points", cloud.tags[t].empty() ? "none" : cloud.tags[t], points[t]));
  }
  for (std::size_t f = 0; f < cloud.faces.size(); ++f) {
    std::vector<double> area;
    for (const Facet& facet : cloud.facets)
      if (facet.face == static_cast<int>(f)) area.push_back(facet.area);
    const double whole = sum(cloud.comm, area);
    const std::int64_t pieces = total(cloud.comm, static_cast<std::int64_t>(area.size()));
    if (pieces > 0) line("face", fmt::format("{}: {:.6g} m^2 of {} points", cloud.faces[f], whole, pieces));
  }
  for (const double n : q.neighbours) negative_neighbours.push_back(-n);
  const Placed fewest = lowest_of(cloud, q.neighbours), most = lowest_of(cloud, negative_neighbours);
  line("neighbours", fmt::format("{} to {}, fewest at {}", fewest.value, -most.value, told(fewest.x)));
  const Placed flattest = lowest_of(cloud, q.evenness);
  line("evenness", fmt::format("at least {:.2g} (1: neighbours all around alike, 0: in one plane), at {}",
                               flattest.value, told(flattest.x)));
  constexpr double one_side = 0.4;  // a point on a flat wall has 0.5
  std::int64_t one_sided = 0;
  Placed worst{0, {}};
  for (int i = 0; i < cloud.owned; ++i)
    if (cloud.on_faces[i] == 0 && q.lean[i] > one_side) {
      ++one_sided;
      if (q.lean[i] > worst.value) worst = {q.lean[i], cloud.x[i]};
    }
  const std::vector<Placed> leaning = gather(cloud.comm, std::vector<Placed>{worst});
  one_sided = total(cloud.comm, one_sided);
  line("one-sided", one_sided == 0
                        ? "no point inside sees its neighbours on one side only"
                        : fmt::format("{} points inside see their neighbours on one side only, worst at {}", one_sided,
                                      told(std::ranges::max_element(leaning, {}, &Placed::value)->x)));
  if (cloud.body) {
    const Placed thin = lowest_of(cloud, q.walls);
    line("thinnest wall", thin.value < farthest ? fmt::format("{:.2g} spacings, at {}", thin.value, told(thin.x))
                                                : fmt::format("more than {} spacings", farthest));
  }
  for (const std::string& note : cloud.notes) line("note", note);
  return lines;
}

}  // namespace

int show_cloud(const Case& c, const std::string& name, MPI_Comm comm) {
  const Method& method = chosen_method(c);
  const Table section = c.section("cloud");
  const SourceLocation location = location_of_points(section);
  const Support support = method.support(c);
  std::unique_ptr<Cloud> cloud;
  located(location, [&] { cloud = std::make_unique<Cloud>(make_cloud(comm, c, support)); });
  const Quality q = quality_of(*cloud, find_neighbours(*cloud, support));
  std::vector<double> area;
  for (int i = 0; i < cloud->owned; ++i)
    area.insert(area.end(), {cloud->area[i].x, cloud->area[i].y, cloud->area[i].z});
  const auto lines = table(*cloud, q);
  make_folder(comm, std::filesystem::path(name).parent_path().string());
  write_cloud(*cloud, name,
              {{.name = "evenness", .values = q.evenness},
               {.name = "neighbours", .values = q.neighbours},
               {.name = "lean", .values = q.lean},
               {.name = "wall thickness [spacings]", .values = q.walls},
               {.name = "area vector [m^2]", .components = 3, .values = area}});
  if (rank_of(comm) != 0) return 0;
  fmt::print("{:<16}{}\n", "case", c.name());
  for (const auto& [what, value] : lines) fmt::print("{:<16}{}\n", what, value);
  fmt::print("points in {0}.{1}, surface in {0}-surface.{2}\n", name, size_of(comm) > 1 ? "pvtu" : "vtu",
             size_of(comm) > 1 ? "pvtp" : "vtp");
  return 0;
}

}  // namespace calor
