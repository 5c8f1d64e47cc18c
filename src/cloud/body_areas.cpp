#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "cloud/body_measures.hpp"
#include "cloud/linear_shares.hpp"

namespace calor {
namespace {

struct Sample {
  Vec3 x;
  double weight;
};

/// Appends triangles with edges of at most `most` that fill a triangle.
void split(const std::array<Vec3, 3>& v, double most, std::vector<std::array<Vec3, 3>>& out) {
  int longest = 0;
  double length = 0;
  for (int n = 0; n < 3; ++n)
    if (const double l = norm(v[(n + 1) % 3] - v[n]); l > length) length = l, longest = n;
  if (length <= most) return out.push_back(v);
  const Vec3 &a = v[longest], &b = v[(longest + 1) % 3], &c = v[(longest + 2) % 3], middle = 0.5 * (a + b);
  split({a, middle, c}, most, out);
  split({middle, b, c}, most, out);
}

/// Quadrature of a facet, exact for squares, fine enough for shape functions of points at the distance d.
void sample_facet(const Surface& surface, int facet, double d, std::vector<Sample>& out) {
  out.clear();
  const auto& vertex = surface.facets[facet].vertex;
  const Vec3 &a = surface.vertices[vertex[0]], &b = surface.vertices[vertex[1]];
  constexpr double finer = 0.4;
  if (surface.dimension == 2) {
    const int parts = std::max(1, static_cast<int>(std::ceil(norm(b - a) / (finer * d))));
    for (int p = 0; p < parts; ++p)
      for (const double place : {0.2113248654051871, 0.7886751345948129})
        out.push_back({a + (p + place) / parts * (b - a), norm(b - a) / (2 * parts)});
    return;
  }
  std::vector<std::array<Vec3, 3>> parts;
  split({a, b, surface.vertices[vertex[2]]}, finer * d, parts);
  for (const auto& t : parts) {
    const double area = 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
    for (int n = 0; n < 3; ++n) out.push_back({2.0 / 3 * t[n] + 1.0 / 6 * (t[(n + 1) % 3] + t[(n + 2) % 3]), area / 3});
  }
}

/// Axes in the plane of a facet.
std::array<Vec3, 2> axes_across(const Vec3& normal, int dimension) {
  if (dimension == 2) return {Vec3{-normal.y, normal.x, 0}, Vec3{}};
  const Vec3 other = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Vec3 u = cross(normal, other);
  u *= 1 / norm(u);
  return {u, cross(normal, u)};
}

/// Shares the area of facets among the points of their patches.
class AreaShares {
 public:
  AreaShares(const Body& body, const BodyPoints& points) : body_(body), points_(points) {}

  void add(int facet) {
    const Surface& surface = body_.surface();
    const Vec3 area = surface.area(facet);
    if (norm(area) == 0) return;
    facet_ = facet, patch_ = body_.features().patch[facet];
    normal_ = (1 / norm(area)) * area;
    axes_ = axes_across(normal_, surface.dimension);
    sample_facet(surface, facet, spacing_near(surface.centroid(facet)), samples_);
    for (const Sample& s : samples_) share(s);
  }

  std::vector<PatchShare> take() {
    std::vector<PatchShare> out;
    for (const auto& [key, share] : shares_of_) out.push_back(share);
    return out;
  }

 private:
  double spacing_near(const Vec3& x) const {
    double least = 1e300;
    for (double reach = 1; least == 1e300; reach *= 2)
      points_.grid.for_each_within(x, reach, [&](int j, double) { least = std::min(least, points_.grid.spacing(j)); });
    return least;
  }

  /// Is the point one of this patch, not on the other side of a thin fold of it?
  bool is_on_patch(int j) const {
    if (j >= points_.on_surface()) return false;
    constexpr double same_side = 0.3;
    return std::ranges::any_of(points_.on[j], [&](const BodyPoints::OnPatch& on) {
      return on.patch == patch_ && dot(on.normal, body_.features().normal[facet_]) > same_side;
    });
  }

  void share(const Sample& s) {
    const PointGrid& grid = points_.grid;
    double reach = LinearShares::radius;
    for (int step = 0; step < LinearShares::most_steps; ++step, reach *= LinearShares::farther) {
      weights_.clear();
      grid.for_each_within(s.x, reach, [&](int j, double square) {
        if (!is_on_patch(j)) return;
        const Vec3 way = (1 / grid.spacing(j)) * (grid.x(j) - s.x);
        const double unit = LinearShares::radius / (reach * grid.spacing(j));
        weights_.add(j, {dot(way, axes_[0]), dot(way, axes_[1]), 0}, square * unit * unit);
      });
      if (!weights_.solve(body_.surface().dimension - 1)) continue;
      for (std::size_t n = 0; n < weights_.ids.size(); ++n)
        give(static_cast<int>(weights_.ids[n]), s.weight * weights_.value[n]);
      return;
    }
    give_to_nearest(s);
  }

  void give(int point, double area) {
    PatchShare& share = shares_of_.try_emplace({point, patch_}, PatchShare{point, patch_, 0, {}}).first->second;
    share.area += area;
    share.vector += area * normal_;
  }

  /// Patches smaller than a spacing may have no points that tell a linear function, or none at all.
  void give_to_nearest(const Sample& s) {
    std::pair<double, int> best{1e300, -1}, of_patch = best;
    for (double reach = 1; best.second < 0; reach *= 2)
      points_.grid.for_each_within(s.x, 2 * reach, [&](int j, double square) {
        const auto is_on_wall = [&](const BodyPoints::OnPatch& on) { return body_.is_wall(on.patch); };
        if (j >= points_.on_surface() || std::ranges::none_of(points_.on[j], is_on_wall)) return;
        best = std::min(best, {square, j});
        if (is_on_patch(j)) of_patch = std::min(of_patch, {square, j});
      });
    give(of_patch.second >= 0 ? of_patch.second : best.second, s.weight);
  }

  const Body& body_;
  const BodyPoints& points_;
  int facet_ = 0, patch_ = 0;
  Vec3 normal_;
  std::array<Vec3, 2> axes_;
  std::vector<Sample> samples_;
  LinearShares weights_;
  std::map<std::pair<int, int>, PatchShare> shares_of_;
};

/// Which patches hang together: every shell of the surface closes by itself. Shares are sorted by point.
std::vector<int> shells_of(const Body& body, const std::vector<PatchShare>& shares) {
  std::vector<int> parent(body.features().count);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int p) {
    while (parent[p] != p) p = parent[p] = parent[parent[p]];
    return p;
  };
  for (std::size_t n = 1; n < shares.size(); ++n)
    if (shares[n].point == shares[n - 1].point) parent[root(shares[n].patch)] = root(shares[n - 1].patch);
  for (int p = 0; p < static_cast<int>(parent.size()); ++p) parent[p] = root(p);
  return parent;
}

/// Removes what the rounding, and patches smaller than a spacing, leave of sum A and sum x cross A of a shell.
void close(const BodyPoints& points, std::span<PatchShare*> shell) {
  double total = 0;
  Vec3 centre, sum, moment;
  for (const PatchShare* s : shell) total += s->area, centre += s->area * points.grid.x(s->point);
  centre *= 1 / total;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const PatchShare* s : shell) {
    const Vec3 r = points.grid.x(s->point) - centre;
    sum += s->vector, moment += cross(r, s->vector);
    const Eigen::Vector3d e(r.x, r.y, r.z);
    inertia += s->area * (e.squaredNorm() * Eigen::Matrix3d::Identity() - e * e.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(inertia);
  Vec3 omega;
  for (int n = 0; n < 3; ++n) {
    const double value = eigen.eigenvalues()[n];
    const Vec3 axis{eigen.eigenvectors()(0, n), eigen.eigenvectors()(1, n), eigen.eigenvectors()(2, n)};
    if (value > 1e-9 * eigen.eigenvalues()[2]) omega += (dot(axis, moment) / value) * axis;
  }
  for (PatchShare* s : shell)
    s->vector -= s->area * ((1 / total) * sum + cross(omega, points.grid.x(s->point) - centre));
}

/// Shares that are not positive, as beside patches smaller than a spacing, go to the largest of the patch around.
void require_positive(const BodyPoints& points, std::vector<PatchShare>& shares) {
  for (PatchShare& s : shares) {
    if (s.area > 0) continue;
    PatchShare* to = nullptr;
    double nearest = 1e300;
    for (PatchShare& other : shares) {
      const Vec3 way = points.grid.x(other.point) - points.grid.x(s.point);
      if (other.patch == s.patch && other.area + s.area > 0 && dot(way, way) < nearest)
        to = &other, nearest = dot(way, way);
    }
    if (!to) continue;
    to->area += s.area, to->vector += s.vector;
    s.area = 0, s.vector = {};
  }
  std::erase_if(shares, [](const PatchShare& s) { return !(s.area > 0); });
}

}  // namespace

std::vector<PatchShare> body_areas(const Body& body, const BodyPoints& points) {
  AreaShares areas(body, points);
  for (int f = 0; f < static_cast<int>(body.surface().facets.size()); ++f) areas.add(f);
  std::vector<PatchShare> shares = areas.take();
  require_positive(points, shares);
  std::map<int, std::vector<PatchShare*>> shells;
  const std::vector<int> shell = shells_of(body, shares);
  for (PatchShare& s : shares) shells[shell[s.patch]].push_back(&s);
  for (auto& [number, of_shell] : shells) close(points, of_shell);
  return shares;
}

}  // namespace calor
