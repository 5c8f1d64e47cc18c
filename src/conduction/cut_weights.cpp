#include "conduction/cut_weights.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/linear_algebra.hpp"

namespace calor {
namespace {

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
/// is |a_i|; beside a full cut that of points on the surface, if there are any: the area vectors of walls do not end
/// where a crack does, and what a part of the body lacks in balance is missing there.
void balance(const Cloud& cloud, std::span<Vec3> area, const Wrench& wanted, bool full_cut) {
  const auto on_surface = [&](int i) { return !(cloud.area[i] == Vec3{}); };
  bool mouths = false;
  for (int i = 0; i < cloud.owned; ++i) mouths = mouths || (full_cut && on_surface(i) && !(area[i] == Vec3{}));
  mouths = any(cloud.comm, mouths);
  std::vector<double> w(cloud.owned), columns, weights;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3& x = cloud.x[i];
    if (!mouths || on_surface(i)) w[i] = norm(area[i]);
    add_columns(columns, x, area[i]);
    weights.insert(weights.end(), {w[i], w[i] * x.x, w[i] * x.y, w[i] * x.z});
  }
  const Wrench has = total_of(cloud, columns);
  const auto s = sums(cloud.comm, weights, 4);
  if (s[0] == 0) return;
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

/// Adds w_i P_i (c + omega cross (x_i - centre)) to the area vectors, P_i = I - n n with w_i n what the faces have
/// across them, so that they have the wanted resultant and moment as far as vectors along the faces can make them so.
void balance_along_faces(const Cloud& cloud, std::span<const Vec3> across, std::span<Vec3> area, const Wrench& wanted) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  std::vector<double> columns, weights;
  for (int i = 0; i < cloud.owned; ++i) {
    const double w = norm(across[i]);
    if (w == 0) continue;
    const Vec3& x = cloud.x[i];
    add_columns(columns, x, area[i]);
    weights.insert(weights.end(), {w, w * x.x, w * x.y, w * x.z});
  }
  const Wrench has = total_of(cloud, columns);
  const auto s = sums(cloud.comm, weights, 4);
  if (s[0] == 0) return;
  const Vec3 centre{s[1] / s[0], s[2] / s[0], s[3] / s[0]};
  std::vector<double> spread;
  for (int i = 0; i < cloud.owned; ++i)
    if (const Vec3 r = cloud.x[i] - centre; !(across[i] == Vec3{})) spread.push_back(norm(across[i]) * dot(r, r));
  const double length = std::sqrt(sum(cloud.comm, spread) / s[0]);  // makes moments forces
  // Resultant and moment of a force of 1 along an axis.
  const auto wrench = [&](int i, const Vec3& e) {
    const Vec3 m = (1 / length) * cross(cloud.x[i] - centre, e);
    return Vector6{e.x, e.y, e.z, m.x, m.y, m.z};
  };
  constexpr std::array<Vec3, 3> axes = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  const auto along_face = [&](int i, const Vec3& e) {
    return e - dot(e, across[i]) / dot(across[i], across[i]) * across[i];
  };
  std::vector<double> squares;
  for (int i = 0; i < cloud.owned; ++i) {
    if (across[i] == Vec3{}) continue;
    Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Zero();
    for (const Vec3& e : axes) square += wrench(i, e) * wrench(i, along_face(i, e)).transpose();
    square *= norm(across[i]);
    squares.insert(squares.end(), square.data(), square.data() + square.size());
  }
  const auto q = sums(cloud.comm, squares, 36);
  const Vec3 force = wanted.force - has.force,
             moment = (1 / length) * (wanted.moment - has.moment - cross(centre, force));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(
      Eigen::Map<const Eigen::Matrix<double, 6, 6>>(q.data()));
  constexpr double least = 1e-6;  // of the largest eigenvalue: motions across the faces
  Vector6 motion = Vector6::Zero();
  for (int n = 0; n < 6; ++n) {
    const Vector6 v = eigen.eigenvectors().col(n);
    if (eigen.eigenvalues()[n] > least * eigen.eigenvalues()[5])
      motion += v * (v.dot(Vector6{force.x, force.y, force.z, moment.x, moment.y, moment.z}) / eigen.eigenvalues()[n]);
  }
  for (int i = 0; i < cloud.owned; ++i) {
    if (across[i] == Vec3{}) continue;
    Vec3 change;
    for (const Vec3& e : axes) change += wrench(i, along_face(i, e)).dot(motion) * e;
    area[i] += norm(across[i]) * change;
  }
}

/// A pair that is cut, as seen from a point beside the crack.
struct CutPair {
  int point;
  Vec3 x_ji, normal;                ///< of the face that the point looks at, away from it
  double at;                        ///< part of the way before that face
  double lost;                      ///< weight
  double beside;                    ///< weight of which the crack has the sliver
  double area_over_pair, conducts;  ///< see SurfaceCuts
};

/// Of every crack that is surface, the pairs that the points above and below it have lost to it; a pair across several
/// counts for that which its point faces.
using CutPairs = std::vector<std::array<std::vector<CutPair>, 2>>;

/// Takes from the pairs' weights what the cracks cut.
CutPairs cut(const Cloud& cloud, const SurfaceCuts& cuts, const Neighbours& neighbours, std::span<double> G) {
  const std::vector<Crossing>& crossings = cuts.crossings;
  CutPairs pairs(cuts.surfaces.size());
  for (std::size_t n = 0, next = 0; n < crossings.size(); n = next) {
    const std::int64_t entry = crossings[n].entry;
    const double whole = G[entry];
    const Crossing* faced = &crossings[n];
    for (next = n; next < crossings.size() && crossings[next].entry == entry; ++next) {
      const Crossing& x = crossings[next];
      G[entry] *= 1 - x.fraction;
      if (x.at < faced->at) faced = &x;
    }
    const Vec3 x_ji = cloud.x[neighbours.column[entry]] - cloud.x[faced->point];
    pairs[faced->crack][faced->upper].push_back({faced->point, x_ji, faced->normal, faced->at, whole - G[entry],
                                                 faced->sliver * whole, cuts.area_over_pair[faced - crossings.data()],
                                                 cuts.conducts[faced - crossings.data()]});
  }
  return pairs;
}

/// Outward area vectors of the faces at the owned points beside them: what their cut pairs carried along the normals,
/// in balance with the walls that end at the cuts.
std::vector<Vec3> areas_of_faces(const Cloud& cloud, const SurfaceCuts& cuts, const CutPairs& cut_pairs) {
  std::vector<Vec3> area(cloud.owned);
  for (std::size_t crack = 0; crack < cut_pairs.size(); ++crack) {
    const bool full_cut = cuts.surfaces[crack].is_full;
    std::vector<Vec3> faces(cloud.owned), across(cloud.owned);
    std::vector<double> columns;
    std::vector<char> beside(cloud.owned);
    for (const bool upper : {true, false}) {
      for (const CutPair& pair : cut_pairs[crack][upper]) {
        const double weight = pair.area_over_pair * pair.lost;
        const Vec3 normal = dot(pair.x_ji, pair.normal) * pair.normal;
        across[pair.point] += weight * normal;
        faces[pair.point] += weight * (normal + pair.conducts * (pair.x_ji - normal));
        add_columns(columns, cloud.x[pair.point], pair.lost * pair.x_ji);
        beside[pair.point] = 1;
      }
      for (int i = 0; i < cloud.owned && cloud.whole; ++i)
        if (beside[i]) add_columns(columns, cloud.x[i], cloud.whole->area[i] - cloud.area[i]);
      std::ranges::fill(beside, 0);
      if (upper && !full_cut) continue;  // one part of the body: both faces at once
      const Wrench wanted = total_of(cloud, columns);
      if (cuts.surfaces[crack].heat_crosses) balance_along_faces(cloud, across, faces, wanted);
      balance(cloud, faces, wanted, full_cut);
      for (int i = 0; i < cloud.owned; ++i) area[i] += faces[i];
      std::ranges::fill(faces, Vec3{});
      std::ranges::fill(across, Vec3{});
      columns.clear();
    }
  }
  return area;
}

Vec3 middle_of(const Cloud& cloud) {
  std::vector<double> columns;
  for (const Vec3& x : cloud.owned_points()) columns.insert(columns.end(), {1, x.x, x.y, x.z});
  const auto s = sums(cloud.comm, columns, 4);
  return (1 / s[0]) * Vec3{s[1], s[2], s[3]};
}

/// What heat that runs along the faces must find at the owned points beside them, and at the neighbours of points
/// beside full cuts.
struct AlongFaces {
  std::vector<Symmetric3> P;   ///< projection onto the faces, 0 at all other points
  std::vector<double> wanted;  ///< sum_j G_ij x_ji.P_i x_ji
  std::vector<char> is_beside;
  std::vector<char> is_at_full_cut;  ///< beside one, or a neighbour of a point that is
};

/// Of a point: the area of the faces that it looks at, and its sum of area n (x) n.
struct FacesOfPoints {
  std::vector<double> area;
  std::vector<Vec3> squares, mixed;

  explicit FacesOfPoints(const Cloud& cloud) : area(cloud.local()), squares(cloud.local()), mixed(cloud.local()) {}
  void add(int i, double a, const Vec3& n) {
    area[i] += a, squares[i] += a * product(n, n), mixed[i] += a * Vec3{n.x * n.y, n.x * n.z, n.y * n.z};
  }
  void add(int i, const FacesOfPoints& from, int j) {
    area[i] += from.area[j], squares[i] += from.squares[j], mixed[i] += from.mixed[j];
  }
  /// I - n n, of the mean n n.
  Symmetric3 projection(int i, int dimension) const {
    const double s = -1 / area[i];
    return {1 + s * squares[i].x, 1 + s * squares[i].y, (dimension == 3 ? 1 : 0) + s * squares[i].z,
            s * mixed[i].x,       s * mixed[i].y,       s * mixed[i].z};
  }
  void update(const Halo& halo) {
    halo.update(std::span<double>(area));
    halo.update(std::span<Vec3>(squares));
    halo.update(std::span<Vec3>(mixed));
  }
};

/// As much as before the cut, and in the sliver between the crack and the middle of each pair, which has changed sides,
/// as much as in the rest of the body. `G`: after the cut.
AlongFaces along_faces(const Cloud& cloud, const SurfaceCuts& cuts, const Neighbours& neighbours,
                       const CutPairs& cut_pairs, std::span<const double> G) {
  AlongFaces along{.P = std::vector<Symmetric3>(cloud.owned),
                   .wanted = std::vector<double>(cloud.owned),
                   .is_beside = std::vector<char>(cloud.owned),
                   .is_at_full_cut = std::vector<char>(cloud.owned)};
  FacesOfPoints faces(cloud), full_cuts(cloud);
  for (std::size_t crack = 0; crack < cut_pairs.size(); ++crack) {
    const bool full_cut = cuts.surfaces[crack].is_full;
    for (const auto& side : cut_pairs[crack]) {
      for (const auto& [i, x_ji, normal, at, lost, beside, factor, conducts] : side) {
        const double length = dot(x_ji, normal), area = std::max(lost, beside) * length;
        const double sliver = beside * length * (at - 0.5) * length;
        along.wanted[i] +=
            (1 - conducts) * lost * (dot(x_ji, x_ji) - length * length) + 2 * (cloud.dimension - 1) * sliver;
        faces.add(i, area, normal);
        if (full_cut) full_cuts.add(i, area, normal);
      }
    }
  }
  full_cuts.update(cloud.halo);
  for (int i = 0; i < cloud.owned; ++i) {
    along.is_beside[i] = faces.area[i] > 0;
    along.is_at_full_cut[i] = full_cuts.area[i] > 0;
    for (const int j : neighbours.of(i)) {
      if (!(full_cuts.area[j] > 0)) continue;
      along.is_at_full_cut[i] = 1;
      if (!along.is_beside[i]) faces.add(i, full_cuts, j);
    }
    if (!(faces.area[i] > 0)) continue;
    along.P[i] = faces.projection(i, cloud.dimension);
    double kept = 0;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 x_ji = neighbours.x_ji(cloud.x, i, n);
      kept += G[n] * dot(x_ji, along.P[i] * x_ji);
    }
    constexpr double least = 0.1;  // of a row whose side is much thinner than its cells: so much can be had
    along.wanted[i] = std::max(along.wanted[i] + kept, least * kept);
  }
  return along;
}

/// Makes heat run along the faces as it must. The weights that are consistent with linear temperatures are not those
/// that do, and the other way round: beside full cuts, where both can be had, they take turns.
void restore_along_faces(const Cloud& cracked, const Neighbours& neighbours, const AlongFaces& along,
                         std::vector<double>& G) {
  constexpr int turns = 3;  // two leave errors of first order, of 1e-6 of the span on 81 points an edge
  constexpr double nearly = 1e-9, floor = 0.02;
  const auto restore = [&](const std::vector<char>& where) {
    std::vector<Symmetric3> P(where.size());
    for (std::size_t i = 0; i < where.size(); ++i)
      if (where[i]) P[i] = along.P[i];
    restore_second_moments(cracked, neighbours, P, along.wanted, G);
  };
  restore(along.is_beside);
  if (!any(cracked.comm, std::ranges::count(along.is_at_full_cut, 1) > 0)) return;
  for (int turn = 1; turn < turns; ++turn) {
    const std::vector<double> before = G;
    enforce_linear_consistency(cracked, neighbours, G, nearly);
    for (std::size_t n = 0; n < G.size(); ++n) G[n] = std::max(G[n], floor * before[n]);
    restore(along.is_at_full_cut);
  }
}

}  // namespace

CutWeights cut_weights(const Cloud& cloud, const SurfaceCuts& cuts, const Neighbours& neighbours, std::vector<double> G,
                       CorrectionReport& report) {
  const CutPairs cut_pairs = cut(cloud, cuts, neighbours, G);
  Cloud cracked = cloud;                 // its surface includes the faces
  const Vec3 middle = middle_of(cloud);  // moments of places far from the origin are all round-off
  for (Vec3& x : cracked.x) x -= middle;
  const auto area = areas_of_faces(cracked, cuts, cut_pairs);
  cracked.x = cloud.x;
  cracked.lattice = nullptr;  // whose points hang together
  for (int i = 0; i < cloud.owned; ++i) cracked.area[i] += area[i];
  std::vector<char> is_gone(G.size(), 0);
  for (const Crossing& x : cuts.crossings) is_gone[x.entry] |= x.fraction == 1;
  CutWeights kept{.neighbours = {.row = {0}, .column = {}}, .G = {}};
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
      if (!is_gone[n]) kept.neighbours.column.push_back(neighbours.column[n]), kept.G.push_back(G[n]);
    kept.neighbours.row.push_back(static_cast<std::int64_t>(kept.neighbours.column.size()));
  }
  require_neighbours(cloud, kept.neighbours);
  restore_along_faces(cracked, kept.neighbours, along_faces(cloud, cuts, kept.neighbours, cut_pairs, kept.G), kept.G);
  enforce_with_positive_weights(cracked, kept.neighbours, kept.G, report);
  return kept;
}

}  // namespace calor
