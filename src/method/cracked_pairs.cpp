#include "method/cracked_pairs.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/search.hpp"
#include "method/correction_steps.hpp"
#include "method/small_matrix.hpp"

namespace calor {
namespace {

bool is_surface(const Crack& crack) { return !crack.fails() && crack.contact == 0; }

/// A piece of a face: place and area, m^2 of the real body.
struct FacePoint {
  Vec3 x;
  double area;
};

/// Two Gauss points per quarter of a spacing along a segment.
template <class Visit>
void for_each_face_point_2d(const CrackPiece& piece, double spacing, double thickness, const Visit& visit) {
  const Vec3 a = piece.corners[0], along = piece.corners[1] - a;
  const auto n = static_cast<std::int64_t>(std::ceil(norm(along) / (0.25 * spacing)));
  const double h = 1 / static_cast<double>(n), gauss = 0.5 / std::sqrt(3.0);
  for (std::int64_t k = 0; k < n; ++k)
    for (const double s : {0.5 - gauss, 0.5 + gauss})
      visit(FacePoint{a + (static_cast<double>(k) + s) * h * along, 0.5 * h * norm(along) * thickness});
}

/// The middles of triangles of a third of a spacing.
template <class Visit>
void for_each_face_point_3d(const CrackPiece& piece, double spacing, const Visit& visit) {
  // A fan from the first corner; triangles of the other sense of rotation take away what lies outside.
  for (std::size_t k = 1; k + 1 < piece.corners.size(); ++k) {
    const Vec3 a = piece.corners[0], u = piece.corners[k] - a, v = piece.corners[k + 1] - a;
    const double longest = std::max({norm(u), norm(v), norm(v - u)});
    const auto n = static_cast<std::int64_t>(std::ceil(longest / (spacing / 3)));
    const double h = 1 / static_cast<double>(n), area = 0.5 * h * h * dot(cross(u, v), piece.normal);
    for (std::int64_t i = 0; i < n; ++i)
      for (std::int64_t j = 0; i + j < n; ++j)
        for (const double s : {1.0 / 3, 2.0 / 3})
          if (s < 0.5 || i + j + 1 < n)
            visit(FacePoint{a + h * ((static_cast<double>(i) + s) * u + (static_cast<double>(j) + s) * v), area});
  }
}

/// Shares a piece of a face out to the nearest points on its side.
class FaceShares {
 public:
  FaceShares(const Cloud& cloud, const Cracks& cracks)
      : cloud_(cloud), cracks_(cracks), search_(cloud, crack_reach), count_(cloud.dimension == 2 ? 9 : 18) {}

  /// area[i] += phi_i(x) * normal * face.area for owned points, on the side that `normal` points away from.
  void add(const FacePoint& face, const Vec3& normal, std::span<Vec3> area) {
    int coincident = 0;
    const auto found = search_.find(face.x, 0, buffer_, coincident);
    near_.clear();
    bool any_owned = false;
    const int* wall = nullptr;
    double wall_distance = 0;
    for (std::int32_t& k : found) k = search_.local(k);
    for (const std::int32_t& i : found) {
      const double r = norm(cloud_.x[i] - face.x);
      any_owned = any_owned || i < cloud_.owned;
      if (!(cloud_.area[i] == Vec3{}) && (!wall || r < wall_distance)) wall = &i, wall_distance = r;
      near_.push_back({r, i});
    }
    if (!any_owned) return;
    if (wall && dot(face.x - cloud_.x[*wall], cloud_.area[*wall]) > 0) return;  // outside the body
    std::ranges::sort(near_, [&](const auto& a, const auto& b) {
      return std::pair(a.first, cloud_.id[a.second]) < std::pair(b.first, cloud_.id[b.second]);
    });
    points_.clear();
    for (const auto& [r, i] : near_) {
      const Vec3& x = cracks_.place(i);
      const double side = -dot(x - face.x, normal);
      // From just beside the face: on its side, and no other piece between.
      if (side > 0 && cracks_.sees(face.x - 1e-6 * side * normal, x)) points_.push_back(i);
      if (static_cast<int>(points_.size()) == count_) break;
    }
    if (points_.empty()) return;

    // Linear fit: phi_k = 1/N + (x - mean).C^-1 (x_k - mean).
    Vec3 mean;
    for (int i : points_) mean += (1.0 / static_cast<double>(points_.size())) * cloud_.x[i];
    Symmetric3 C;
    for (int i : points_) C.add(1, cloud_.x[i] - mean);
    const Vec3 slope = pseudo_inverse(C) * (face.x - mean);
    for (int i : points_) {
      const double phi = 1.0 / static_cast<double>(points_.size()) + dot(slope, cloud_.x[i] - mean);
      if (i < cloud_.owned) area[i] += phi * face.area * normal;
    }
  }

 private:
  const Cloud& cloud_;
  const Cracks& cracks_;
  Search search_;
  int count_;
  std::vector<std::int32_t> buffer_;
  std::vector<std::pair<double, int>> near_;
  std::vector<int> points_;
};

/// Resultant and moment of area vectors at points.
struct Wrench {
  Vec3 force, moment;
};

Wrench total_of(const Cloud& cloud, std::span<const double> columns) {
  const auto s = sums(cloud.comm, columns, 6);
  return {{s[0], s[1], s[2]}, {s[3], s[4], s[5]}};
}

void add_columns(std::vector<double>& columns, const Vec3& x, const Vec3& a) {
  const Vec3 m = cross(x, a);
  columns.insert(columns.end(), {a.x, a.y, a.z, m.x, m.y, m.z});
}

/// Adds w_i (c + omega cross (x_i - centre)) to the area vectors so that they have the wanted resultant and moment. w_i
/// is |a_i| of the points on the surface: the area vectors of walls do not end where a crack does, and what a part of
/// the body lacks in balance is missing there.
void balance(const Cloud& cloud, std::span<Vec3> area, const Wrench& wanted) {
  std::vector<double> w(cloud.owned), columns, weights;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3& x = cloud.x[i];
    if (!(cloud.area[i] == Vec3{})) w[i] = norm(area[i]);
    add_columns(columns, x, area[i]);
    weights.insert(weights.end(), {w[i], w[i] * x.x, w[i] * x.y, w[i] * x.z});
  }
  const Wrench has = total_of(cloud, columns);
  const auto s = sums(cloud.comm, weights, 4);
  if (s[0] == 0) return;  // a closed crack
  const Vec3 centre{s[1] / s[0], s[2] / s[0], s[3] / s[0]};
  std::vector<double> squares;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 r = cloud.x[i] - centre;
    squares.insert(squares.end(), {w[i] * r.x * r.x, w[i] * r.y * r.y, w[i] * r.z * r.z, w[i] * r.x * r.y,
                                   w[i] * r.x * r.z, w[i] * r.y * r.z});
  }
  const auto q = sums(cloud.comm, squares, 6);
  const Symmetric3 inertia{q[1] + q[2], q[0] + q[2], q[0] + q[1], -q[3], -q[4], -q[5]};
  const Vec3 force = wanted.force - has.force;
  const Vec3 turn = pseudo_inverse(inertia) * (wanted.moment - has.moment - cross(centre, force));
  for (int i = 0; i < cloud.owned; ++i) area[i] += w[i] * ((1 / s[0]) * force + cross(turn, cloud.x[i] - centre));
}

}  // namespace

std::vector<Vec3> crack_areas(const Cloud& cloud, const Cracks& cracks, const Neighbours& neighbours,
                              std::span<const Crossing> crossings, std::span<const double> G) {
  std::vector<Vec3> area(cloud.owned), side(cloud.owned);
  FaceShares shares(cloud, cracks);
  for (std::size_t crack = 0; crack < cracks.all().size(); ++crack) {
    if (!is_surface(cracks.all()[crack])) continue;
    double spacing = std::numeric_limits<double>::infinity();  // the smallest beside the crack
    for (const Crossing& x : crossings)
      if (x.crack == static_cast<int>(crack)) spacing = std::min(spacing, cloud.spacing[x.point]);
    spacing = min(cloud.comm, spacing);
    if (!std::isfinite(spacing)) continue;  // no pair crosses it
    for (const bool upper : {true, false}) {
      std::ranges::fill(side, Vec3{});
      for (const CrackPiece& piece : cracks.pieces(static_cast<int>(crack))) {
        const Vec3 outward = upper ? -piece.normal : piece.normal;
        const auto add = [&](const FacePoint& face) { shares.add(face, outward, side); };
        if (cloud.dimension == 2) {
          for_each_face_point_2d(piece, spacing, cloud.section, add);
        } else {
          for_each_face_point_3d(piece, spacing, add);
        }
      }
      if (cracks.is_full_cut(static_cast<int>(crack))) {
        std::vector<double> columns;
        for (const Crossing& x : crossings) {
          if (x.crack != static_cast<int>(crack) || x.upper != upper || !x.leads_across) continue;
          const Vec3& x_i = cloud.x[x.point];
          add_columns(columns, x_i, G[x.entry] * (cloud.x[neighbours.column[x.entry]] - x_i));
        }
        balance(cloud, side, total_of(cloud, columns));
      }
      for (int i = 0; i < cloud.owned; ++i) area[i] += side[i];
    }
  }
  return area;
}

PairSites cracked_pairs(const Cloud& cloud, const Cracks& cracks, Neighbours neighbours, std::vector<double> G,
                        CorrectionReport& report) {
  const auto crossings = cracks.crossings(neighbours);
  const bool has_surface = std::ranges::any_of(cracks.all(), is_surface);
  if (has_surface) {
    Cloud cracked = cloud;  // its surface includes the faces of the cracks
    const auto area = crack_areas(cloud, cracks, neighbours, crossings, G);
    for (int i = 0; i < cloud.owned; ++i) cracked.area[i] += area[i];
    std::vector<char> is_cut(G.size(), 0);
    for (const Crossing& x : crossings) {
      if (!is_surface(cracks.all()[x.crack])) continue;
      G[x.entry] *= 1 - x.fraction;
      is_cut[x.entry] |= x.fraction == 1;
    }
    Neighbours kept{.row = {0}, .column = {}};
    std::vector<double> kept_G;
    for (int i = 0; i < cloud.owned; ++i) {
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
        if (!is_cut[n]) kept.column.push_back(neighbours.column[n]), kept_G.push_back(G[n]);
      kept.row.push_back(static_cast<std::int64_t>(kept.column.size()));
    }
    neighbours = std::move(kept);
    G = std::move(kept_G);
    require_neighbours(cloud, neighbours);
    enforce_with_positive_weights(cracked, neighbours, G, report);
  }

  CrackBonds bonds;
  for (const Crack& crack : cracks.all())
    if (crack.fails()) bonds.openings.push_back(crack.opens);
  for (const Crossing& x : cracks.crossings(neighbours)) {
    const Crack& crack = cracks.all()[x.crack];
    if (!is_surface(crack))
      bonds.bonds.push_back({.entry = x.entry,
                             .point = x.point,
                             .fraction = x.fraction,
                             .contact = crack.contact * x.length,
                             .opens = crack.opens});
  }
  return PairSites(cloud, std::move(neighbours), std::move(G), {}, {}, std::move(bonds));
}

std::unique_ptr<FluxSites> with_cracks(const Case& c, const Cloud& cloud, MirroredNeighbours mirrored,
                                       std::vector<double> G, Layers layers, CorrectionReport& done,
                                       MethodReport& report) {
  if (!has_cracks(c)) return std::make_unique<PairSites>(fold_images(cloud, std::move(mirrored), std::move(G), layers));
  Neighbours& neighbours = mirrored.neighbours;  // without images: points on the walls have none
  const Cracks cracks(cloud, read_cracks(c, cloud));
  const std::size_t before = neighbours.column.size();
  auto sites = std::make_unique<PairSites>(cracked_pairs(cloud, cracks, std::move(neighbours), std::move(G), done));
  const auto cut = total(cloud.comm, static_cast<std::int64_t>(before - sites->neighbours().column.size()));
  report["cut_pairs"] = static_cast<double>(cut / 2);
  report["points_on_cracks"] = static_cast<double>(cracks.moved());
  if (rank_of(cloud.comm) == 0 && cracks.moved() > 0)
    spdlog::info(
        "{} point{} on a crack taken to lie beside it, 1e-3 spacings to the left of its direction (in 3D: where "
        "its corners run counter-clockwise)",
        cracks.moved(), cracks.moved() == 1 ? " is" : "s are");
  return sites;
}

}  // namespace calor
