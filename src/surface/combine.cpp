#include "surface/combine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>

#include "surface/facet_pieces.hpp"
#include "surface/hash_grid.hpp"
#include "surface/surface_files.hpp"
#include "surface/surface_tree.hpp"

namespace calor {
namespace {

/// Lengths below this are rounding, m.
double tolerance_of(const std::vector<const Surface*>& surfaces) {
  Vec3 low{1e300, 1e300, 1e300}, high = -low;
  for (const Surface* s : surfaces)
    for (const Vec3& x : s->vertices)
      for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  return surfaces.empty() ? 0 : 1e-9 * norm(high - low);
}

FacetPiece whole(const Surface& surface, int facet) {
  FacetPiece piece{.corner = {}, .face = surface.facets[facet].face};
  for (int n = 0; n < surface.dimension; ++n) piece.corner.push_back(surface.vertices[surface.facets[facet].vertex[n]]);
  return piece;
}

/// One of the surfaces that are combined.
struct Operand {
  explicit Operand(const Surface& s) : surface(s), tree(s) {}
  const Surface& surface;
  SurfaceTree tree;
};

/// The pieces into which the other surfaces cut a facet.
std::vector<FacetPiece> pieces_of(const Surface& surface, int facet, const std::vector<const Operand*>& others,
                                  double tolerance) {
  const FacetPiece piece = whole(surface, facet);
  Vec3 low = piece.corner[0], high = low;
  for (const Vec3& x : piece.corner)
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
  const Vec3 margin{tolerance, tolerance, tolerance};
  std::vector<std::array<Vec3, 2>> segments;
  std::vector<std::array<Vec3, 3>> triangles;
  for (const Operand* other : others)
    for (const int g : other->tree.facets_in(low - margin, high + margin)) {
      const std::vector<Vec3> corner = whole(other->surface, g).corner;
      if (surface.dimension == 2)
        segments.push_back({corner[0], corner[1]});
      else
        triangles.push_back({corner[0], corner[1], corner[2]});
    }
  return segments.empty() ? cut_facet(piece, triangles, tolerance) : cut_segment(piece, segments, tolerance);
}

// Choosing -----------------------------------------------------------------------------------------------------------

/// Where a piece lies with respect to another solid: on its surface with the same or the opposite outside.
enum class Place { outside, inside, on_same, on_opposite };

Place place_of(const FacetPiece& piece, const Operand& other, double tolerance) {
  const Vec3 x = centroid(piece);
  const auto near = other.tree.closest(x, 2 * tolerance);
  if (!near) return other.tree.is_inside(x) ? Place::inside : Place::outside;
  const Vec3 ab = piece.corner[1] - piece.corner[0];
  const Vec3 outwards = other.surface.dimension == 2 ? Vec3{ab.y, -ab.x, 0} : area(piece.corner);
  return dot(outwards, other.surface.area(near->facet)) > 0 ? Place::on_same : Place::on_opposite;
}

// Joining ------------------------------------------------------------------------------------------------------------

/// Makes facets of pieces, which share their edges as a whole.
class Joiner {
 public:
  Joiner(int dimension, double tolerance, std::vector<std::string> faces) : tolerance_(tolerance) {
    out_.dimension = dimension, out_.faces = std::move(faces);
  }

  void add(FacetPiece piece) { pieces_.push_back(std::move(piece)); }
  std::size_t count() const { return pieces_.size(); }

  /// `first`: how many facets the first pieces have, as many as were added before `count`.
  Surface join(std::size_t count, int& first) {
    weld_corners();
    for (std::size_t n = 0; n < loops_.size(); ++n) {
      if (n == count) first = static_cast<int>(out_.facets.size());
      add_facets(n);
    }
    if (count >= loops_.size()) first = static_cast<int>(out_.facets.size());
    return std::move(out_);
  }

 private:
  void weld_corners() {
    double size = 0, edges = 0;
    std::size_t edge_count = 0;
    for (const FacetPiece& piece : pieces_)
      for (std::size_t k = 0; k < piece.corner.size(); ++k, ++edge_count) {
        const Vec3& x = piece.corner[k];
        size = std::max({size, std::abs(x.x), std::abs(x.y), std::abs(x.z)});
        edges += norm(piece.corner[(k + 1) % piece.corner.size()] - x);
      }
    HashGrid grid(tolerance_, size);
    for (const FacetPiece& piece : pieces_) {
      std::vector<std::int32_t>& loop = loops_.emplace_back();
      for (const Vec3& x : piece.corner) {
        const std::int32_t vertex = grid.find_or_add(x);
        if (loop.empty() || loop.back() != vertex) loop.push_back(vertex);
      }
      if (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    }
    out_.vertices = std::move(grid).places();
    cell_ = std::max(edges / static_cast<double>(std::max<std::size_t>(1, edge_count)), 1e-6 * size);
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(out_.vertices.size()); ++v)
      cells_[key(cell(out_.vertices[v]))].push_back(v);
  }

  /// The vertices between two others, in order, that lie on the straight way between them.
  std::vector<std::int32_t> between(std::int32_t a, std::int32_t b) const {
    const Vec3 &from = out_.vertices[a], way = out_.vertices[b] - from;
    const double length = norm(way);
    const int steps = std::max(1, static_cast<int>(std::ceil(length / cell_)));
    std::vector<std::pair<double, std::int32_t>> found;
    for (int s = 0; s < steps; ++s) {
      const Vec3 p = from + (double(s) / steps) * way, q = from + (double(s + 1) / steps) * way;
      Index low, high;
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = index(std::min(p[axis], q[axis]) - 2 * tolerance_);
        high[axis] = index(std::max(p[axis], q[axis]) + 2 * tolerance_);
      }
      Index c;
      for (c[0] = low[0]; c[0] <= high[0]; ++c[0])
        for (c[1] = low[1]; c[1] <= high[1]; ++c[1])
          for (c[2] = low[2]; c[2] <= high[2]; ++c[2]) {
            const auto here = cells_.find(key(c));
            if (here == cells_.end()) continue;
            for (const std::int32_t v : here->second) {
              const Vec3 r = out_.vertices[v] - from;
              const double along = dot(r, way) / length;
              if (v != a && v != b && along > 0 && along < length && norm(r - along / length * way) <= 2 * tolerance_)
                found.emplace_back(along, v);
            }
          }
    }
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    std::vector<std::int32_t> vertices;
    vertices.reserve(found.size());
    for (const auto& [along, v] : found) vertices.push_back(v);
    return vertices;
  }

  void add_facets(std::size_t n) {
    const std::vector<std::int32_t>& loop = loops_[n];
    const std::int32_t face = pieces_[n].face;
    if (out_.dimension == 2) {
      if (loop.size() < 2) return;
      std::int32_t last = loop[0];
      for (const std::int32_t v : between(loop[0], loop[1])) out_.facets.push_back({{last, v, -1}, face}), last = v;
      out_.facets.push_back({{last, loop[1], -1}, face});
      return;
    }
    if (loop.size() < 3) return;
    std::vector<Vec3> corner;
    corner.reserve(loop.size());
    double longest = 0;
    for (const std::int32_t v : loop) corner.push_back(out_.vertices[v]);
    for (std::size_t k = 0; k < corner.size(); ++k)
      longest = std::max(longest, norm(corner[(k + 1) % corner.size()] - corner[k]));
    if (2 * norm(area(corner)) <= tolerance_ * longest) return;
    std::vector<std::int32_t> around;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      around.push_back(loop[k]);
      for (const std::int32_t v : between(loop[k], loop[(k + 1) % loop.size()])) around.push_back(v);
    }
    if (around.size() == 3) {
      out_.facets.push_back({{around[0], around[1], around[2]}, face});
      return;
    }
    const auto middle = static_cast<std::int32_t>(out_.vertices.size());
    out_.vertices.push_back(centroid({.corner = corner}));
    for (std::size_t k = 0; k < around.size(); ++k)
      out_.facets.push_back({{around[k], around[(k + 1) % around.size()], middle}, face});
  }

  using Index = std::array<std::int64_t, 3>;
  std::int64_t index(double c) const { return static_cast<std::int64_t>(std::floor(c / cell_)); }
  Index cell(const Vec3& x) const { return {index(x.x), index(x.y), index(x.z)}; }
  static std::uint64_t key(const Index& c) {
    std::uint64_t h = 0;
    for (const std::int64_t n : c) h = (h ^ static_cast<std::uint64_t>(n)) * 0x9e3779b97f4a7c15U, h ^= h >> 29;
    return h;
  }

  double tolerance_, cell_ = 1;
  std::vector<FacetPiece> pieces_;
  std::vector<std::vector<std::int32_t>> loops_;  // vertices of every piece
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> cells_;
  Surface out_;
};

/// The faces of several surfaces, and which one each of theirs is.
struct Faces {
  Surface names;
  std::vector<std::vector<std::int32_t>> of;

  void add(const Surface& surface) {
    std::vector<std::int32_t>& mine = of.emplace_back();
    for (const std::string& face : surface.faces) mine.push_back(face_named(names, face));
  }
};

/// The pieces of a in certain places of b, and those of b in certain places of a, turned over if asked for.
Surface combined(const Surface& a, const Surface& b, Place keep_of_a, Place keep_too, Place keep_of_b, bool turns_b) {
  const double tolerance = tolerance_of({&a, &b});
  const Operand of_a(a), of_b(b);
  Faces faces;
  faces.add(a), faces.add(b);
  Joiner joiner(a.dimension, tolerance, faces.names.faces);
  for (int f = 0; f < static_cast<int>(a.facets.size()); ++f)
    for (FacetPiece& piece : pieces_of(a, f, {&of_b}, tolerance))
      if (const Place place = place_of(piece, of_b, tolerance); place == keep_of_a || place == keep_too) {
        piece.face = faces.of[0][piece.face];
        joiner.add(std::move(piece));
      }
  for (int f = 0; f < static_cast<int>(b.facets.size()); ++f)
    for (FacetPiece& piece : pieces_of(b, f, {&of_a}, tolerance))
      if (place_of(piece, of_a, tolerance) == keep_of_b) {
        if (turns_b) std::ranges::reverse(piece.corner);
        piece.face = faces.of[1][piece.face];
        joiner.add(std::move(piece));
      }
  int count = 0;
  return joiner.join(joiner.count(), count);
}

}  // namespace

Surface difference(const Surface& a, const Surface& b) {
  return combined(a, b, Place::outside, Place::on_opposite, Place::inside, true);
}

Surface intersection(const Surface& a, const Surface& b) {
  return combined(a, b, Place::inside, Place::on_same, Place::inside, false);
}

Assembly assemble(const std::vector<Surface>& solids) {
  if (solids.size() == 1) return {solids[0], static_cast<int>(solids[0].facets.size())};
  std::vector<const Surface*> surfaces;
  std::vector<std::unique_ptr<Operand>> operands;
  Faces faces;
  for (const Surface& solid : solids) {
    surfaces.push_back(&solid);
    operands.push_back(std::make_unique<Operand>(solid));
    faces.add(solid);
  }
  const double tolerance = tolerance_of(surfaces);
  Joiner joiner(solids[0].dimension, tolerance, faces.names.faces);
  std::vector<FacetPiece> interfaces;
  for (std::size_t s = 0; s < solids.size(); ++s) {
    std::vector<const Operand*> others;
    for (std::size_t q = 0; q < solids.size(); ++q)
      if (q != s) others.push_back(operands[q].get());
    for (int f = 0; f < static_cast<int>(solids[s].facets.size()); ++f)
      for (FacetPiece& piece : pieces_of(solids[s], f, others, tolerance)) {
        std::size_t meets = solids.size();  // the solid on the other side
        for (std::size_t q = 0; q < solids.size() && meets == solids.size(); ++q)
          if (q != s && place_of(piece, *operands[q], tolerance) != Place::outside) meets = q;
        piece.face = faces.of[s][piece.face];
        if (meets == solids.size())
          joiner.add(std::move(piece));
        else if (meets < s)
          interfaces.push_back(std::move(piece));
      }
  }
  const std::size_t walls = joiner.count();
  for (FacetPiece& piece : interfaces) joiner.add(std::move(piece));
  Assembly out;
  out.surface = joiner.join(walls, out.walls);
  return out;
}

}  // namespace calor
