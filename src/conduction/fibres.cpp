#include "conduction/fibres.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cloud/lattice.hpp"

namespace calor {
namespace {

/// Of the width of a cell: places nearer to its end are taken to lie on it, thinner slices are round-off.
constexpr double round_off = 1e-7;

/// What the cells of two points have in common along an axis.
struct Extent {
  int axis;
  double low, high, x;  ///< its ends and the coordinate of both points, m
  double width() const { return high - low; }
};

/// From one place to another, and the face that heat between them runs through: the extents of cells across its axes.
struct Way {
  Parts::Segment line;
  int part_a, part_b;  ///< that the temperatures at its ends are of; -1: of a wall, all
  std::vector<Extent> face;
};

std::vector<Extent> face_of(const Lattice& lattice, const LatticeIndex& cell, std::span<const int> axes) {
  std::vector<Extent> face;
  for (const int axis : axes) {
    const auto [low, high] = lattice.cell(axis, cell[axis]);
    face.push_back({axis, low, high, lattice.coordinate(axis, cell[axis])});
  }
  return face;
}

/// Lines along one axis of the face, a quarter of the way behind either point and in the middle of both halves of the
/// other axis: where the points lie themselves, an interface may run along the line.
void add_lines(const Way& way, std::size_t along, std::vector<Parts::Segment>& lines) {
  const Extent& e = way.face[along];
  const Parts::Segment& line = way.line;
  std::vector<Vec3> start;
  for (const double part : {0.25, 0.75}) start.push_back(line.a + part * (line.b - line.a));
  for (const Extent& other : way.face) {
    if (other.axis == e.axis) continue;
    const std::vector<Vec3> in_the_middle = std::move(start);
    start.clear();
    for (Vec3 x : in_the_middle) {
      for (const double end : {other.low, other.high}) {
        if (end == other.x) continue;  // on a wall
        x[other.axis] = 0.5 * (other.x + end);
        start.push_back(x);
      }
    }
  }
  for (std::size_t n = 0; n < start.size(); ++n) {
    Vec3 low = start[n], high = start[n];
    low[e.axis] = e.low + round_off * e.width(), high[e.axis] = e.high - round_off * e.width();
    const int tag = 2 * n < start.size() ? line.tag_a : line.tag_b;
    lines.push_back({low, high, tag, tag});
  }
}

/// Slices between the ends of the extent and the places where the parts change.
std::vector<std::pair<double, double>> slices(const Extent& e, std::vector<double> changes) {
  changes.push_back(e.high);
  std::ranges::sort(changes);
  std::vector<std::pair<double, double>> out;
  double begin = e.low;
  for (const double end : changes) {
    if (end - begin <= round_off * e.width()) continue;
    out.emplace_back(begin, end);
    begin = end;
  }
  out.back().second = e.high;
  return out;
}

/// A rectangle of the face: where its middle lies beside the line between the points, and its share.
struct Piece {
  Vec3 offset;
  double share;
};

std::vector<Piece> rectangles(const Cloud& cloud, std::span<const Extent> face,
                              std::span<const std::vector<std::pair<double, double>>> cuts) {
  std::vector<Piece> out = {{.offset = {}, .share = 1}};
  for (std::size_t n = 0; n < face.size(); ++n) {
    const Extent& e = face[n];
    const bool is_radius = cloud.axisymmetric && e.axis == 0;
    const auto measure = [&](double low, double high) { return (high - low) * (is_radius ? 0.5 * (low + high) : 1); };
    std::vector<Piece> finer;
    for (const Piece& piece : out) {
      for (const auto& [low, high] : cuts[n]) {
        finer.push_back({piece.offset, piece.share * measure(low, high) / measure(e.low, e.high)});
        if (cuts[n].size() > 1) finer.back().offset[e.axis] = 0.5 * (low + high) - e.x;
      }
    }
    out = std::move(finer);
  }
  return out;
}

/// Those of every way.
std::vector<std::vector<Piece>> cut_faces(const Cloud& cloud, const Parts& parts, std::span<const Way> ways) {
  std::vector<Parts::Segment> lines;
  std::vector<std::size_t> end;  // of the lines along every axis of every face
  for (const Way& way : ways) {
    for (std::size_t along = 0; along < way.face.size(); ++along) {
      add_lines(way, along, lines);
      end.push_back(lines.size());
    }
  }
  const Parts::Pieces pieces = parts.along(lines);
  std::vector<std::vector<Piece>> out;
  std::size_t line = 0, axis = 0;
  for (const Way& way : ways) {
    std::vector<std::vector<std::pair<double, double>>> cuts;
    for (const Extent& e : way.face) {
      std::vector<double> changes;
      for (; line < end[axis]; ++line)
        for (const SegmentPiece& p : pieces.of(line).first(pieces.of(line).size() - 1))
          changes.push_back((lines[line].a + p.end * (lines[line].b - lines[line].a))[e.axis]);
      ++axis;
      cuts.push_back(slices(e, std::move(changes)));
    }
    out.push_back(rectangles(cloud, way.face, cuts));
  }
  return out;
}

bool are_alike(std::span<const SegmentPiece> a, std::span<const SegmentPiece> b) {
  return std::ranges::equal(a, b, [](const SegmentPiece& p, const SegmentPiece& q) {
    return p.part == q.part && std::abs(p.end - q.end) < round_off;
  });
}

std::vector<std::vector<Fibre>> fibres_of(const Cloud& cloud, const Parts& parts, std::span<const Way> ways) {
  const auto faces = cut_faces(cloud, parts, ways);
  std::vector<Parts::Segment> segments;  // of every way its line, then its rectangles
  for (std::size_t n = 0; n < ways.size(); ++n) {
    const Parts::Segment& line = ways[n].line;
    segments.push_back(line);
    for (const Piece& piece : faces[n])
      segments.push_back({line.a + piece.offset, line.b + piece.offset, line.tag_a, line.tag_b, line.spacings});
  }
  const Parts::Pieces pieces = parts.along(segments);
  std::vector<std::vector<Fibre>> out(ways.size());
  std::size_t s = 0;
  for (std::size_t n = 0; n < ways.size(); ++n) {
    const std::size_t line = s++;
    const auto is_apart_from = [&](int part, int at) { return part >= 0 && parts.contact(part, at); };
    for (const Piece& piece : faces[n]) {
      const auto at = pieces.of(s);
      const bool is_apart =
          is_apart_from(ways[n].part_a, at.front().part) || is_apart_from(ways[n].part_b, at.back().part);
      const std::size_t from = is_apart ? line : s;
      ++s;
      const auto run = pieces.of(from);
      const auto alike = std::ranges::find_if(out[n], [&](const Fibre& f) { return are_alike(f.run, run); });
      if (alike == out[n].end())
        out[n].push_back({segments[from], {run.begin(), run.end()}, piece.share});
      else
        alike->share += piece.share;
    }
    if (out[n].size() == 1) out[n][0].share = 1;  // heat straight across layers runs as along the line
  }
  return out;
}

}  // namespace

std::vector<char> hold_one_part(const Cloud& cloud, const Parts& parts) {
  const std::vector<int> own = parts.at(cloud.x, cloud.tag);
  std::vector<char> one(cloud.local(), 1);
  std::vector<Vec3> corner(cloud.local()), first;
  for (int q = 0; q < 1 << cloud.dimension; ++q) {
    for (int i = 0; i < cloud.local(); ++i) {
      const LatticeIndex at = cloud.lattice->index(cloud.id[i]);
      corner[i] = cloud.x[i];
      for (int a = 0; a < cloud.dimension; ++a) {
        const auto [low, high] = cloud.lattice->cell(a, at[a]);
        const double inset = round_off * (high - low);
        corner[i][a] = q >> a & 1 ? high - inset : low + inset;
      }
    }
    if (q == 0) first = corner;
    const std::vector<int> part = parts.at(corner, cloud.tag);
    // A thin layer may lie between the corners.
    for (int i = 0; i < cloud.local(); ++i)
      one[i] = one[i] && part[i] == own[i] && !parts.has_plane_between(first[i], corner[i]);
  }
  if (!parts.may_be_thin()) return one;
  // So may a thin region: across the lines that pairs run along.
  for (int a = 0; a < cloud.dimension; ++a) {
    std::vector<Parts::Segment> lines;
    for (int i = 0; i < cloud.local(); ++i) {
      const auto [low, high] = cloud.lattice->cell(a, cloud.lattice->index(cloud.id[i])[a]);
      Parts::Segment line{cloud.x[i], cloud.x[i], cloud.tag[i], cloud.tag[i]};
      const double inset = round_off * (high - low);
      line.a[a] = low + inset, line.b[a] = high - inset;
      lines.push_back(line);
    }
    const Parts::Pieces pieces = parts.along(lines);
    for (int i = 0; i < cloud.local(); ++i) one[i] = one[i] && pieces.of(i).size() == 1;
  }
  return one;
}

std::vector<std::vector<Fibre>> fibres(const Cloud& cloud, const Parts& parts,
                                       std::span<const std::pair<std::int32_t, std::int32_t>> pairs) {
  const std::vector<int> own = parts.at(cloud.x, cloud.tag);
  std::vector<Way> ways;
  for (const auto& [a, b] : pairs) {
    const LatticeIndex cell = cloud.lattice->index(cloud.id[a]), other = cloud.lattice->index(cloud.id[b]);
    std::vector<int> axes;  // on which the points do not differ
    int spacings = 1;
    for (int axis = 0; axis < cloud.dimension; ++axis) {
      if (cell[axis] == other[axis]) axes.push_back(axis);
      spacings = std::max(spacings, static_cast<int>(std::abs(cell[axis] - other[axis])));
    }
    ways.push_back({{cloud.x[a], cloud.x[b], cloud.tag[a], cloud.tag[b], spacings},
                    own[a],
                    own[b],
                    face_of(*cloud.lattice, cell, axes)});
  }
  return fibres_of(cloud, parts, ways);
}

std::vector<std::vector<Fibre>> fibres_to_walls(const Cloud& cloud, const Parts& parts) {
  const std::vector<int> own = parts.at(cloud.x, cloud.tag);
  std::vector<Way> ways;
  for (const Facet& facet : cloud.facets) {
    const int i = facet.point;
    Vec3 wall = cloud.x[i];
    wall[facet.face / 2] = cloud.walls[facet.face];
    std::vector<int> axes;
    for (int axis = 0; axis < cloud.dimension; ++axis)
      if (axis != facet.face / 2) axes.push_back(axis);
    ways.push_back({{cloud.x[i], wall, cloud.tag[i], cloud.tag[i]},
                    own[i],
                    -1,
                    face_of(*cloud.lattice, cloud.lattice->index(cloud.id[i]), axes)});
  }
  return fibres_of(cloud, parts, ways);
}

}  // namespace calor
