// Clouds in CSV files: one point a row,
//   x [m],y [m],z [m],volume [m^3],tag,area_x [m^2],area_y [m^2],area_z [m^2],face,area2_x [m^2],...,face2,...
// Any unit of length, volume or area. The number of coordinate columns is the dimension, less those at the end that are
// all 0. tag and areas are optional;
// area_* is the outward area vector of a piece of the surface that belongs to the point, area2_*, area3_*, ... are
// further segments (corners). A piece of no area is none; without a face column all are segments of "surface". Volumes
// and areas are those of the real body: thickness or cross-section included.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "base/csv.hpp"
#include "base/parallel.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

/// Columns of one piece of the surface.
struct PieceColumns {
  int area[3] = {-1, -1, -1};
  int face = -1;
};

struct Columns {
  int x[3] = {-1, -1, -1};
  int dimension = 0, volume = -1, tag = -1;
  std::vector<PieceColumns> segments;
};

Columns find_columns(CsvReader& csv) {
  Columns c;
  std::set<std::string> known = {"volume", "tag"};
  const auto axis = [](int a) { return std::string(1, "xyz"[a]); };
  for (int a = 0; a < 3 && (a == 0 || csv.find(axis(a)) >= 0); ++a) {
    c.x[a] = csv.require(axis(a), "m");
    known.insert(axis(a));
    c.dimension = a + 1;
  }
  c.volume = csv.require("volume", "m^3");
  c.tag = csv.find("tag");
  for (int n = 1;; ++n) {
    const std::string number = n == 1 ? "" : std::to_string(n);
    if (csv.find("area" + number + "_x") < 0) break;
    PieceColumns piece;
    for (int a = 0; a < c.dimension; ++a) {
      const std::string name = "area" + number + "_" + axis(a);
      piece.area[a] = csv.require(name, "m^2");
      known.insert(name);
    }
    piece.face = csv.find("face" + number);
    known.insert("face" + number);
    c.segments.push_back(piece);
  }
  std::set<std::string> seen;
  for (const CsvColumn& column : csv.columns()) {
    const SourceLocation header{.file = csv.path(), .line = 1};
    if (!known.contains(column.name))
      throw Error(Fault::bad_case, header,
                  fmt::format("'{}' is not a column of a cloud of {} dimension{}", column.name, c.dimension,
                              c.dimension > 1 ? "s" : ""),
                  fmt::format("the columns are {}; further facets area2_x, ..., face2", fmt::join(known, ", ")));
    if (!seen.insert(column.name).second)
      throw Error(Fault::bad_case, header, fmt::format("there are two columns '{}'", column.name), "remove one");
  }
  return c;
}

/// Words of all ranks, sorted, each once. Collective.
std::vector<std::string> gather_words(MPI_Comm comm, const std::set<std::string>& words) {
  std::vector<char> mine;
  for (const std::string& w : words) mine.insert(mine.end(), w.begin(), w.end()), mine.push_back('\n');
  const std::vector<char> gathered = gather(comm, mine);
  const std::string all(gathered.begin(), gathered.end());
  std::set<std::string> merged;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end + 1) {
    end = all.find('\n', begin);
    merged.insert(all.substr(begin, end - begin));
  }
  return {merged.begin(), merged.end()};
}

/// Names in the order in which this rank met them.
struct Names {
  std::vector<std::string> list;
  int number(std::string_view name) {
    const auto found = std::ranges::find(list, name);
    if (found != list.end()) return static_cast<int>(found - list.begin());
    list.emplace_back(name);
    return static_cast<int>(list.size()) - 1;
  }
  std::vector<int> places_in(const std::vector<std::string>& all) const {
    std::vector<int> place;
    for (const auto& name : list) place.push_back(static_cast<int>(std::ranges::lower_bound(all, name) - all.begin()));
    return place;
  }
};

void read_rows(CsvReader& csv, const Columns& c, Points& out, Names& tags, Names& faces) {
  while (csv.next()) {
    Point p;
    for (int a = 0; a < c.dimension; ++a) p.x[a] = csv.number(c.x[a]);
    p.volume = csv.number(c.volume);
    if (!(p.volume > 0))
      throw Error(Fault::bad_case, csv.location(c.volume),
                  fmt::format("a volume of {} is not positive", csv.text(c.volume)),
                  "give every point the volume of the body that it stands for");
    p.tag = c.tag < 0 ? tags.number("") : tags.number(csv.text(c.tag));
    out.points.push_back(p);
    for (const PieceColumns& piece : c.segments) {
      Vec3 area;
      for (int a = 0; a < c.dimension; ++a)
        if (!csv.text(piece.area[a]).empty()) area[a] = csv.number(piece.area[a]);
      const double size = norm(area);
      if (size == 0) continue;
      if (piece.face >= 0 && csv.text(piece.face).empty())
        throw Error(Fault::bad_case, csv.location(piece.face), "a piece of surface without the name of its face",
                    "name the face, or remove the area");
      const int face = faces.number(piece.face >= 0 ? csv.text(piece.face) : "surface");
      out.facets.push_back({.face = face, .area = size, .normal = (1 / size) * area});
      out.points.back().area += area;
      ++out.points.back().facets;
    }
  }
}

/// Leaves out the axes at the end along which all points are at 0. Collective; throws Error.
void drop_flat_axes(MPI_Comm comm, const std::string& file, Points& out) {
  while (out.dimension > 1) {
    const int axis = out.dimension - 1;
    if (any(comm, std::ranges::any_of(out.points, [&](const Point& p) { return p.x[axis] != 0; }))) return;
    const auto points_out = [&](const SurfacePiece& piece) { return std::abs(piece.normal[axis]) > 1e-9; };
    if (any(comm, std::ranges::any_of(out.facets, points_out)))
      throw Error(
          Fault::bad_case, SourceLocation{.file = file},
          fmt::format("all points have {} = 0, so this is a body of {} dimension{}, but pieces of surface point "
                      "along {}",
                      "xyz"[axis], axis, axis > 1 ? "s" : "", "xyz"[axis]),
          axis == 2 ? "remove them: the faces of a plate are 'bottom' and 'top' in [boundary]" : "remove them");
    out.dimension = axis;
  }
}

std::string note_on_flat_axes(const Points& out) {
  return out.dimension == 2
             ? fmt::format("all points have z = 0: a body of 2 dimensions with a thickness of {:g} m", out.section)
             : fmt::format("all points lie on a line: a body of 1 dimension with a section of {:g} m^2", out.section);
}

/// The part of a full cell that lies inside the body, of a point on the walls whose pieces of surface these are: by the
/// angle between two, half of the rest for every further direction.
double share_inside(std::span<const SurfacePiece> pieces) {
  std::vector<Vec3> normals;
  constexpr double same = 0.9;  // cosine: pieces of one curved wall
  for (const SurfacePiece& piece : pieces)
    if (std::ranges::none_of(normals, [&](const Vec3& n) { return dot(n, piece.normal) > same; }))
      normals.push_back(piece.normal);
  if (normals.size() < 2) return normals.empty() ? 1 : 0.5;
  const double angle = std::numbers::pi - std::acos(std::clamp(dot(normals[0], normals[1]), -1.0, 1.0));
  return std::max(angle / (2 * std::numbers::pi), 0.05) * std::pow(0.5, static_cast<double>(normals.size()) - 2);
}

/// Spacings by the full cells, as if the points lay on the walls; settle_spacings knows more, once the points have
/// neighbours.
void estimate_spacings(Points& out) {
  out.estimated_spacings = true;
  out.knows_walls = false;
  std::size_t next = 0;
  for (Point& p : out.points) {
    const auto pieces = std::span(out.facets).subspan(next, p.facets);
    next += p.facets;
    p.full_volume = p.volume / share_inside(pieces);
    p.spacing = std::pow(p.full_volume / out.section, 1.0 / out.dimension);
  }
}

}  // namespace

Points read_points(MPI_Comm comm, const std::string& file, const std::function<double(int)>& section,
                   const SourceLocation& named) {
  Points out;
  Names tags, faces;
  tags.number("");
  collective_try(comm, [&] {
    CsvReader csv(file, named, rank_of(comm), size_of(comm));
    const Columns columns = find_columns(csv);
    out.dimension = columns.dimension;
    out.has_areas = !columns.segments.empty();
    read_rows(csv, columns, out, tags, faces);
  });
  const int columns = out.dimension;
  drop_flat_axes(comm, file, out);
  out.section = section(out.dimension);
  if (out.dimension < columns) out.notes.push_back(note_on_flat_axes(out));
  estimate_spacings(out);

  out.tags = gather_words(comm, {tags.list.begin(), tags.list.end()});
  out.faces = gather_words(comm, {faces.list.begin(), faces.list.end()});
  if (out.faces.size() > 32)
    throw Error(Fault::bad_case, SourceLocation{.file = file}, fmt::format("there are {} faces", out.faces.size()),
                "give at most 32 faces different names");
  const std::vector<int> tag = tags.places_in(out.tags), face = faces.places_in(out.faces);
  std::int64_t id = offset(comm, static_cast<std::int64_t>(out.points.size()));
  std::size_t next = 0;
  for (Point& p : out.points) {
    p.id = id++;
    p.tag = tag[p.tag];
    for (int n = 0; n < p.facets; ++n, ++next) {
      out.facets[next].face = face[out.facets[next].face];
      p.on_faces |= std::uint32_t{1} << out.facets[next].face;
    }
  }
  return out;
}

CloudShape csv_shape() {
  return {.name = "csv",
          .sentence =
              "Points from a CSV file with columns x [m], y [m], z [m], volume [m^3], tag and, for every piece of "
              "surface, area_x [m^2], area_y [m^2], area_z [m^2], face (further ones area2_x, ..., face2). "
              "Faces: the names in those columns",
          .keys = {{"file", Kind::text, "", required, "Name of the file, relative to the case."}},
          .make = [](MPI_Comm comm, const Table& cloud) {
            return read_points(
                comm, cloud.file("file"), [&](int dimension) { return section_of(cloud, dimension); },
                cloud.location("file"));
          }};
}

}  // namespace calor
