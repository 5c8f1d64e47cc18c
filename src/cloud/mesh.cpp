// Clouds from meshes: nodes become points, and the mesh is thrown away. A point stands for the integrals of its hat
// function N_i, linear in every simplex:
//   V_i = int N_i dV = sum |T| / (D + 1),   A_i = int N_i n dS = sum n |F| / D,   S_i = int N_i dS = sum |F| / D.
// As quadratures they are exact for linear functions, and the surface closes: sum A = 0, sum x cross A = 0.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "base/parallel.hpp"
#include "cloud/mesh_groups.hpp"
#include "cloud/shapes.hpp"
#include "cloud/simplices.hpp"
#include "mesh/mesh.hpp"

namespace calor {
namespace {

/// A share of a facet: of one of its nodes.
struct FacetShare {
  std::int32_t node;
  int face;
  Vec3 area;
};

/// The shares of every node and face, sorted by them, and cut apart where they meet at sharp edges: calls use(node,
/// face, scalar area, area vector).
template <class Use>
void for_each_piece(std::vector<FacetShare> shares, const Use& use) {
  const double smooth = std::cos(30 * std::numbers::pi / 180);
  const auto key = [](const FacetShare& s) { return std::pair(s.node, s.face); };
  std::ranges::stable_sort(shares, {}, key);
  for (std::size_t begin = 0, end = 0; begin < shares.size(); begin = end) {
    while (end < shares.size() && key(shares[end]) == key(shares[begin])) ++end;
    // Facets are of one piece where a chain of small angles joins them.
    std::vector<std::size_t> piece(end - begin);
    std::iota(piece.begin(), piece.end(), 0);
    for (std::size_t a = begin; a < end; ++a)
      for (std::size_t b = begin; b < a; ++b)
        if (dot(shares[a].area, shares[b].area) > smooth * norm(shares[a].area) * norm(shares[b].area))
          std::ranges::replace(piece, std::size_t{piece[a - begin]}, std::size_t{piece[b - begin]});
    for (std::size_t p = 0; p < piece.size(); ++p) {
      Vec3 vector;
      double area = 0;
      for (std::size_t n = 0; n < piece.size(); ++n)
        if (piece[n] == p) vector += shares[begin + n].area, area += norm(shares[begin + n].area);
      if (norm(vector) > 0) use(shares[begin].node, shares[begin].face, area, vector);
    }
  }
}

/// Of every node the name of the elements that hold the largest share of its volume; of equal shares the first name,
/// whatever rounding says. `share_of`: the volume of every simplex over the number of its nodes.
std::vector<int> names_of_nodes(const Simplices& body, const std::vector<double>& share_of) {
  std::set<int> names;
  for (const Simplex& simplex : body.simplices) names.insert(simplex.name);
  std::vector<int> name(body.x.size(), *names.begin());
  std::vector<double> most(body.x.size());
  for (const int n : names) {
    std::vector<double> share(body.x.size());
    for (std::size_t t = 0; t < body.simplices.size(); ++t)
      for (int k = 0; body.simplices[t].name == n && k <= body.dimension; ++k)
        share[body.simplices[t].node[k]] += share_of[t];
    constexpr double clearly = 1 + 1e-9;
    for (std::size_t i = 0; i < share.size(); ++i)
      if (share[i] > clearly * most[i]) most[i] = share[i], name[i] = n;
  }
  return name;
}

/// Names that are used, in the order of their first use as indices, and the place of every index in them.
struct UsedNames {
  std::vector<std::string> list;
  std::map<int, int> place;
  int operator()(int index, const std::string& name) {
    const auto [found, is_new] = place.try_emplace(index, static_cast<int>(list.size()));
    if (is_new) list.push_back(name);
    return found->second;
  }
};

/// The surface of the body as shares of its nodes; names its faces.
std::vector<FacetShare> shares_of_surface(const Simplices& body, const std::vector<std::string>& names, Points& out,
                                          const SourceLocation& file) {
  UsedNames faces;
  std::vector<int> used;
  for (const BoundaryFacet& facet : body.surface) used.push_back(facet.name);
  std::ranges::sort(used);
  for (const int name : used) faces(name, name == 0 ? "surface" : names[name]);
  if (faces.list.size() > 32)
    throw Error(Fault::bad_case, file, fmt::format("there are {} faces", faces.list.size()),
                "give at most 32 groups of the surface different names");
  std::vector<FacetShare> shares;
  for (const BoundaryFacet& facet : body.surface)
    for (int k = 0; k < body.dimension; ++k)
      shares.push_back({facet.node[k], faces.place.at(facet.name), (out.section / body.dimension) * facet.area});
  out.faces = std::move(faces.list);
  return shares;
}

void require_volumes(const Simplices& body, const std::vector<double>& volume, const SourceLocation& file) {
  for (std::size_t i = 0; i < volume.size(); ++i)
    if (!(volume[i] > 0))
      throw Error(
          Fault::bad_case, file,
          fmt::format("the elements around node {} have a volume of {:.3g} m^3 together", body.label[i], volume[i]),
          "mend the mesh there: its elements are flat, or folded over one another");
}

}  // namespace

Points mesh_points(MPI_Comm comm, const Mesh& mesh, double unit, const std::function<double(int)>& section,
                   const SourceLocation& file) {
  const Simplices body = make_simplices(mesh, unit, file);
  Points out;
  out.dimension = body.dimension;
  out.section = section(body.dimension);
  out.notes = mesh.notes;
  std::ranges::copy(body.notes, std::back_inserter(out.notes));
  std::vector<double> volume(body.x.size()), share_of;
  for (const Simplex& simplex : body.simplices) {
    share_of.push_back(out.section * body.volume(simplex) / (body.dimension + 1));
    for (int k = 0; k <= body.dimension; ++k) volume[simplex.node[k]] += share_of.back();
  }
  require_volumes(body, volume, file);
  const std::vector<int> name = names_of_nodes(body, share_of);
  UsedNames tags;
  tags(0, "");
  const auto count = static_cast<std::int64_t>(body.x.size());
  const Slice mine = slice(comm, count);
  std::vector<int> tag;
  tag.reserve(name.size());
  for (const int n : name) tag.push_back(tags(n, mesh.names[n]));
  std::vector<int> tag_of_simplex;
  for (const Simplex& simplex : body.simplices) tag_of_simplex.push_back(tags(simplex.name, mesh.names[simplex.name]));
  out.tags = tags.list;
  out.solids = solids_of_groups(body, tag_of_simplex);

  std::int64_t next = mine.begin;
  const auto add_points = [&](std::int64_t end) {  // up to the one with index end - 1
    for (; next < std::min(end, mine.end); ++next)
      out.points.push_back({.id = next,
                            .x = body.x[next],
                            .volume = volume[next],
                            .full_volume = volume[next],
                            .spacing = std::pow(volume[next] / out.section, 1.0 / body.dimension),
                            .tag = tag[next]});
  };
  for_each_piece(shares_of_surface(body, mesh.names, out, file),
                 [&](std::int32_t node, int face, double area, const Vec3& vector) {
                   if (node < mine.begin || node >= mine.end) return;
                   add_points(node + 1);
                   out.add_patch(face, area, (1 / norm(vector)) * vector, vector);
                 });
  add_points(mine.end);
  out.estimated_spacings = true;
  return out;
}

CloudShape mesh_shape() {
  return {
      .name = "mesh",
      .sentence =
          "The nodes of a mesh of triangles, quadrilaterals, tetrahedra, pyramids, prisms or hexahedra, from a file "
          ".msh (Gmsh, ASCII), .inp (Abaqus, CalculiX) or .vtu (VTK). Faces: the names of the groups of elements "
          "or nodes on the surface, \"surface\" for the rest. Tags: the names of the groups of elements inside",
      .keys = {{"file", Kind::text, "", required, "Name of the file, relative to the case."},
               {"unit", Kind::quantity, "m", required, "Length of one unit of the file: \"1 mm\"."}},
      .make = [](MPI_Comm comm, const Table& cloud) {
        if (!(cloud.number("unit") > 0))
          cloud.refuse("unit", fmt::format("a unit of {:g} m is not positive", cloud.number("unit")),
                       "give the length of one unit of the file: \"1 mm\"");
        Points out;
        const std::string path = cloud.file("file");
        collective_try(comm, [&] {
          out = mesh_points(comm, read_mesh(path, cloud.location("file")), cloud.number("unit"),
                            [&](int dimension) { return section_of(cloud, dimension); }, {.file = path});
        });
        return out;
      }};
}

}  // namespace calor
