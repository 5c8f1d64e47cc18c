#include "cloud/cracks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/cells.hpp"

namespace calor {
namespace {

Vec3 unit(const Vec3& a) { return (1 / norm(a)) * a; }

/// Distance of x from the segment a b.
double distance(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double square = dot(ab, ab), s = square > 0 ? std::clamp(dot(x - a, ab) / square, 0.0, 1.0) : 0;
  return norm(x - a - s * ab);
}

/// Is x, a point of its plane, inside the polygon? By the angle that the polygon takes as seen from x.
bool inside(const std::vector<Vec3>& polygon, const Vec3& normal, const Vec3& x) {
  double angle = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 a = polygon[k] - x, b = polygon[(k + 1) % polygon.size()] - x;
    angle += std::atan2(dot(cross(a, b), normal), dot(a, b));
  }
  return std::abs(angle) > 3;
}

/// Newell's formula: twice the area times the normal.
Vec3 area_vector(const std::vector<Vec3>& polygon) {
  Vec3 sum;
  for (std::size_t k = 0; k < polygon.size(); ++k)
    sum += cross(polygon[k] - polygon[0], polygon[(k + 1) % polygon.size()] - polygon[0]);
  return sum;
}

}  // namespace

Cracks::Cracks(const Cloud& cloud, std::vector<Crack> cracks)
    : cloud_(cloud), cracks_(std::move(cracks)), location_(cloud.x) {
  for (const Crack& crack : cracks_) {
    std::vector<CrackPiece>& segments = segments_.emplace_back();
    const auto& v = crack.vertices;
    if (cloud.dimension == 3) {
      segments.push_back({.corners = v, .extended = v, .normal = unit(area_vector(v)), .tips = {}});
      continue;
    }
    for (std::size_t k = 0; k + 1 < v.size(); ++k) {
      const Vec3 along = unit(v[k + 1] - v[k]);
      const std::vector<Vec3> ends = {v[k], v[k + 1]};
      segments.push_back({.corners = ends, .extended = ends, .normal = {-along.y, along.x, 0}, .tips = {}});
    }
  }
  reach_out_of_the_body();
  find_tips();
  move_points();
}

/// Where the surface is, as seen from a place near it.
struct Cracks::Surface {
  bool reached;  ///< the place lies on it (nearer than a tenth of a spacing) or beyond
  Vec3 normal;
  double spacing;
};

Cracks::Surface Cracks::surface_at(const Vec3& place) const {
  double nearest = std::numeric_limits<double>::infinity();
  std::vector<double> found;
  const auto look_at = [&](const Vec3& x, const Vec3& area, int i) {
    const double r = norm(x - place);
    if (!(r < nearest)) return;
    const Vec3 n = unit(area);
    nearest = r;
    found = {n.x, n.y, n.z, cloud_.spacing[i], dot(place - x, n) / spacing_along(cloud_.metric[i], n), 1};
  };
  for (int i = 0; i < cloud_.owned && cloud_.points_on_walls; ++i)
    if (!(cloud_.area[i] == Vec3{})) look_at(cloud_.x[i], cloud_.area[i], i);
  for (const Facet& f : cloud_.facets)
    if (!cloud_.points_on_walls) look_at(place_on_wall(cloud_, f), f.normal, f.point);
  const double everywhere = min(cloud_.comm, nearest);
  if (nearest > everywhere) found.clear();  // of the ranks that have the nearest place
  const std::vector<double> s = sums(cloud_.comm, found, 6);
  const double share = s[5] > 0 ? 1 / s[5] : 0, spacing = share * s[3];
  const double beyond = share * s[4];  // spacings across the wall
  return {.reached = s[5] > 0 && (everywhere < 3 * spacing || beyond > 0) && beyond > -0.1,
          .normal = share * Vec3{s[0], s[1], s[2]},
          .spacing = spacing};
}

void Cracks::reach_out_of_the_body() {
  for (std::vector<CrackPiece>& segments : segments_) {
    for (CrackPiece& piece : segments) {
      for (std::size_t k = 0; k < piece.corners.size(); ++k) {
        const Surface surface = surface_at(piece.corners[k]);
        if (!surface.reached) continue;
        // Along the piece, which stays in its plane.
        const Vec3 out = surface.normal - dot(surface.normal, piece.normal) * piece.normal;
        if (norm(out) > 0.1) piece.extended[k] += 3 * surface.spacing * unit(out);
      }
    }
  }
}

bool Cracks::runs_inside(const Vec3& a, const Vec3& b) const {
  // Of an edge that leaves the body any part may be inside: looked at in the box around the points.
  const Bounds mine = bounds_of(cloud_.owned_points());
  double begin = 0, end = 1;
  for (int axis = 0; axis < cloud_.dimension; ++axis) {
    const double low = min(cloud_.comm, mine.low[axis]), high = max(cloud_.comm, mine.high[axis]);
    const double from = a[axis], way = b[axis] - a[axis];
    if (way == 0) continue;
    const double s = (low - from) / way, t = (high - from) / way;
    begin = std::max(begin, std::min(s, t)), end = std::min(end, std::max(s, t));
  }
  constexpr int parts = 8;
  const int places = a == b ? 1 : parts;
  for (int k = 0; k < places && begin <= end; ++k) {
    const double s = begin + (k + 0.5) / places * (end - begin);
    if (!surface_at(a + s * (b - a)).reached) return true;
  }
  return false;
}

void Cracks::find_tips() {
  double size = 0;
  for (const Crack& crack : cracks_)
    for (const Vec3& v : crack.vertices) size = std::max(size, norm(v - crack.vertices[0]));
  const double close = 1e-9 * size;
  // An end is none where another piece goes on, nor on the surface.
  const auto goes_on = [&](const CrackPiece& of, const Vec3& a, const Vec3& b) {
    for (const auto& segments : segments_) {
      for (const CrackPiece& other : segments) {
        if (&other == &of) continue;
        const std::size_t n = other.corners.size();
        for (std::size_t k = 0; k < n; ++k) {
          const Vec3 &c = other.corners[k], &d = other.corners[(k + 1) % n];
          if (distance(a, c, d) <= close && distance(b, c, d) <= close) return true;
        }
      }
    }
    return false;
  };
  for (auto& segments : segments_) {
    for (CrackPiece& piece : segments) {
      const std::size_t n = piece.corners.size();
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = cloud_.dimension == 3 ? (k + 1) % n : k;
        const Vec3 &a = piece.corners[k], &b = piece.corners[next];
        if (goes_on(piece, a, b) || !runs_inside(a, b)) continue;
        piece.tips.push_back({piece.extended[k], piece.extended[next]});
      }
    }
  }
}

bool Cracks::is_full_cut(int crack) const {
  return std::ranges::all_of(segments_[crack], [](const CrackPiece& p) { return p.tips.empty(); });
}

bool Cracks::separate(const Vec3& a, const Vec3& b) const {
  const auto cuts = [&](const CrackPiece& piece) {
    const double from = piece.side(a), to = piece.side(b);
    return ((from < 0 && to > 0) || (from > 0 && to < 0)) && holds(piece, a + (from / (from - to)) * (b - a));
  };
  return std::ranges::any_of(segments_, [&](const auto& pieces) { return std::ranges::any_of(pieces, cuts); });
}

/// Does a piece hold x, a point of its plane?
bool Cracks::holds(const CrackPiece& piece, const Vec3& x) const {
  if (cloud_.dimension == 3) return inside(piece.extended, piece.normal, x);
  const Vec3 along = piece.extended[1] - piece.extended[0];
  const double s = dot(x - piece.extended[0], along) / dot(along, along);
  return s > -1e-9 && s < 1 + 1e-9;  // a pair through a corner of a polyline must not slip through
}

Cracks::Cut Cracks::cut(const CrackPiece& piece, const Vec3& a, const Vec3& b, const Vec3& metric) const {
  const double from = piece.side(a), to = piece.side(b);
  if (!(from < 0 && to > 0) && !(from > 0 && to < 0)) return {};
  const Vec3 x = a + (from / (from - to)) * (b - a);
  const bool within = holds(piece, x);
  if (piece.tips.empty()) return {.fraction = within ? 1. : 0, .sliver = within ? 1. : 0};
  double tip = std::numeric_limits<double>::infinity();
  Vec3 edge;
  for (const CrackPiece::Tip& t : piece.tips)
    if (const double r = distance(x, t.a, t.b); r < tip) tip = r, edge = t.b - t.a;
  if (!within) tip = -tip;
  // In a lattice of nearest neighbours, dx apart along the crack and dy across, a crack acts as if its tip lay
  // 1/2 dx + sqrt(dx^2 + dy^2)/4 beyond the last bond cut, and (1 + rho) b / (1 + rho b) dx less when that bond keeps a
  // part b of its weight: exact, by the method of Wiener and Hopf (docs/cracks.md). This is that b, for a tip where the
  // crack ends; dx is a spacing along the crack, by which one pair of every kind follows the other, dy the length
  // |x_ji.n| across it. So cracks act as long as they are, wherever their tips lie and however far the pairs reach.
  const Vec3 across = piece.normal,
             along = cloud_.dimension == 3 ? unit(cross(across, edge)) : Vec3{across.y, -across.x, 0};
  const double dx = spacing_along(metric, along), q = spacing_along(metric, across) / dx,
               diagonal = std::sqrt(1 + q * q);
  const double longer = 0.25 * diagonal / q * std::abs(from - to) / dx, rho = (1 + diagonal - q) / q;
  const double c = std::clamp(0.5 + tip / dx - longer, 0.0, 1.0);
  // The slivers end half a spacing later: with a crack off the middle of two rows, temperatures that are even about it
  // would be wrong else as if the tip were a dipole.
  return {.fraction = (1 + rho) * c / (1 + rho * c), .sliver = std::clamp(1 - 0.25 * diagonal + tip / dx, 0.0, 1.0)};
}

std::vector<Crossing> Cracks::crossings(const Neighbours& neighbours) const {
  std::vector<Crossing> out;
  for (std::size_t crack = 0; crack < cracks_.size(); ++crack) {
    for (const CrackPiece& piece : segments_[crack]) {
      Vec3 low = piece.extended[0], high = low;
      for (const Vec3& v : piece.extended)
        for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], v[a]), high[a] = std::max(high[a], v[a]);
      for (int i = 0; i < cloud_.owned; ++i) {
        const auto row = neighbours.of(i);
        double reach = cloud_.spacing[i];
        for (std::int32_t j : row) reach = std::max(reach, norm(cloud_.x[j] - cloud_.x[i]));
        bool far = false;
        for (int a = 0; a < 3; ++a)
          far = far || location_[i][a] < low[a] - 2 * reach || location_[i][a] > high[a] + 2 * reach;
        if (far || std::abs(piece.side(location_[i])) > 1.01 * reach) continue;
        for (std::size_t n = 0; n < row.size(); ++n) {
          const int j = row[n];
          const bool ascending = cloud_.id[i] < cloud_.id[j];  // one answer for both directions
          const Cut c =
              cut(piece, location_[ascending ? i : j], location_[ascending ? j : i], cloud_.mean_metric(i, j));
          if (c.fraction == 0 && c.sliver == 0) continue;
          const bool upper = piece.side(location_[i]) > 0;
          const double from = piece.side(cloud_.x[i]), to = piece.side(cloud_.x[j]);
          out.push_back({.entry = neighbours.row[i] + static_cast<std::int64_t>(n),
                         .point = i,
                         .crack = static_cast<int>(crack),
                         .fraction = c.fraction,
                         .sliver = c.sliver,
                         .length = std::abs(dot(cloud_.x[j] - cloud_.x[i], piece.normal)),
                         .normal = (upper ? -1.0 : 1.0) * piece.normal,
                         .at = std::clamp(from / (from - to), 0.0, 1.0),
                         .upper = upper});
        }
      }
    }
  }
  // Of the segments of one crack, the one that cuts the pair most, and the one that the point faces.
  std::ranges::sort(out, [](const Crossing& a, const Crossing& b) {
    return std::tuple(a.entry, a.crack, -a.fraction, a.length) < std::tuple(b.entry, b.crack, -b.fraction, b.length);
  });
  std::size_t kept = 0;
  for (std::size_t n = 0, next = 0; n < out.size(); n = next) {
    Crossing crossing = out[n];
    for (next = n + 1; next < out.size(); ++next) {
      const Crossing& other = out[next];
      if (other.entry != crossing.entry || other.crack != crossing.crack) break;
      if (other.at < crossing.at) crossing.normal = other.normal, crossing.at = other.at, crossing.upper = other.upper;
    }
    out[kept++] = crossing;
  }
  out.resize(kept);
  return out;
}

void Cracks::move_points() {
  std::int64_t moved = 0;
  for (int i = 0; i < cloud_.local(); ++i) {
    for (const auto& segments : segments_) {
      for (const CrackPiece& piece : segments) {
        const double least = 1e-3 * spacing_along(cloud_.metric[i], piece.normal), s = piece.side(location_[i]);
        if (!(std::abs(s) < least)) continue;
        const Vec3 above = location_[i] + (2 * least - s) * piece.normal, below = above - 4 * least * piece.normal;
        if (cut(piece, above, below, cloud_.metric[i]).fraction == 0) continue;
        // Along the surface points stay with the body: above such a crack there is none.
        const bool is_outside = dot(cloud_.area[i], piece.normal) > 0.5 * norm(cloud_.area[i]);
        location_[i] += ((is_outside ? -least : least) - s) * piece.normal;
        moved += i < cloud_.owned;
      }
    }
  }
  moved_ = total(cloud_.comm, moved);
}

bool has_cracks(const Case& c) { return !c.root().list("crack").empty(); }

std::vector<Crack> read_cracks(const Case& c, const Cloud& cloud) {
  std::vector<Crack> cracks;
  const int D = cloud.dimension;
  for (const Table& table : c.root().list("crack")) {
    if (D == 1) table.refuse("", "a crack in a body of one dimension", "model the body in two dimensions");
    if (cloud.axisymmetric) table.refuse("", "a crack in an axisymmetric body", "model the body in three dimensions");
    if (!cloud.has_areas)
      table.refuse("", "a crack in a cloud without boundary areas",
                   "give the columns area_x, area_y, area_z of the boundary points in the cloud's file");
    Crack crack;
    const std::size_t least = D == 2 ? 2 : 3;
    for (int a = 0; a < D; ++a) {
      const std::string key(1, "xyz"[a]);
      if (!table.has(key))
        table.refuse("", "a crack without " + key, "give the coordinates of its corners: one list for every axis");
      const std::vector<double> x = table.numbers(key);
      if (a == 0) crack.vertices.resize(x.size());
      if (x.size() != crack.vertices.size())
        table.refuse(key, fmt::format("{} coordinates for {} corners", x.size(), crack.vertices.size()),
                     "give every corner one along every axis");
      if (x.size() < least)
        table.refuse(key, fmt::format("{} corner{}", x.size(), x.size() == 1 ? "" : "s"),
                     fmt::format("give at least {}", least));
      for (std::size_t k = 0; k < x.size(); ++k) crack.vertices[k][a] = x[k];
    }
    if (D == 2 && table.has("z")) table.refuse("z", "z in a body of two dimensions", "remove it");
    for (std::size_t k = 0; k + 1 < crack.vertices.size(); ++k)
      if (crack.vertices[k] == crack.vertices[k + 1])
        table.refuse("x", fmt::format("corners {} and {} (from 0) coincide", k, k + 1), "remove one of them");
    if (D == 3) {
      const Vec3 area = area_vector(crack.vertices);
      double size = 0, off = 0;
      for (const Vec3& v : crack.vertices) size = std::max(size, norm(v - crack.vertices[0]));
      if (!(norm(area) > 1e-9 * size * size))
        table.refuse("x", "the corners lie on a line", "give the corners of a polygon");
      for (const Vec3& v : crack.vertices) off = std::max(off, std::abs(dot(v - crack.vertices[0], unit(area))));
      if (off > 1e-6 * size)
        table.refuse("x", fmt::format("the corners are {:.3g} m off a plane", off), "split the crack into triangles");
    }
    if (table.has("contact") && !(table.number("contact") >= 0))
      table.refuse("contact", fmt::format("a contact of {} W/(m^2 K) is negative", table.number("contact")),
                   "give 0 (no heat crosses) or more");
    crack.contact = table.number("contact");
    if (table.has("opens")) {
      if (c.root().has("steady")) table.refuse("opens", "a crack that opens in a steady case", "remove it");
      crack.opens = table.number("opens");
    }
    cracks.push_back(std::move(crack));
  }
  return cracks;
}

void declare_cracks(Schema& schema) {
  schema.add({.path = "crack[]",
              .sentence =
                  "A crack or an interface inside the body: no heat crosses it, or only against the resistance of a "
                  "contact. Where it ends on the surface, end it there or beyond.",
              .keys = {{"x", Kind::quantities, "m", optional,
                        "Coordinates of its corners along x: of a polyline in 2D, of a plane polygon in 3D."},
                       {"y", Kind::quantities, "m", optional, "The same along y."},
                       {"z", Kind::quantities, "m", optional, "The same along z, in 3D."},
                       {"contact", Kind::quantity, "W/(m^2 K)", "0 W/(m^2 K)",
                        "Conductance of the contact between its faces; 0: no heat crosses."},
                       {"opens", Kind::quantity, "s", optional,
                        "When the crack opens; the body is whole before. From the start if absent."}}});
}

}  // namespace calor
