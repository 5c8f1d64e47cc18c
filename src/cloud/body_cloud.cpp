#include "cloud/body_cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

#include "base/cache.hpp"
#include "cloud/body_measures.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

/// Says where the body is thinner than two spacings. Near edges it is so everywhere.
std::vector<std::string> note_on_thin_walls(const Body& body, const MeasuredPoints& points) {
  constexpr double thin = 2, near_edges = 0.02, edge = 0.9;  // cosine
  int count = 0, on_surface = 0;
  Vec3 place;
  for (auto piece = points.pieces.begin(), end = piece; piece != points.pieces.end(); piece = end) {
    end = std::find_if(piece, points.pieces.end(), [&](const auto& p) { return p.point != piece->point; });
    ++on_surface;
    const Vec3 normal = (1 / norm(piece->vector)) * piece->vector, &x = points.x[piece->point];
    const auto is_other = [&](const MeasuredPoints::Piece& p) { return dot(p.vector, normal) < edge * norm(p.vector); };
    if (std::any_of(piece, end, is_other)) continue;
    const double d = points.spacing[piece->point];
    if (body.sees(body.moved_inside(x, Body::skin * d), x - thin * d * normal)) continue;
    if (count++ == 0) place = x;
  }
  if (count <= near_edges * on_surface) return {};
  return {
      fmt::format("at {} of {} points of the surface the body is thinner than two spacings, first at ({:.6g}, {:.6g}, "
                  "{:.6g}) m: heat crosses it on fewer than three points",
                  count, on_surface, place.x, place.y, place.z)};
}

/// All that volumes and areas follow from.
Fingerprint fingerprint(const Body& body, const BodyPoints& points, const std::vector<Box>& boxes) {
  const Surface& facets = body.facets();
  Fingerprint from;
  from.add(facets.dimension).add(facets.vertices).add(facets.facets).add(body.surface().facets.size());
  for (const Box& box : boxes) from.add(std::span(&box.low, 1)).add(box.size).add(box.is_cut);
  for (int i = 0; i < points.grid.count(); ++i) {
    from.add(std::span(&points.grid.x(i), 1)).add(points.grid.spacing(i));
    if (i >= points.on_surface()) continue;
    for (const BodyPoints::OnPatch& on : points.on[i]) from.add(on.patch).add(std::span(&on.normal, 1));
  }
  from.add(points.is_lattice);
  return from;
}

/// Volumes and areas from the cache.
std::pair<std::vector<double>, std::vector<PatchShare>> kept_measures(MPI_Comm comm, const Body& body,
                                                                      const BodyPoints& points,
                                                                      const std::vector<Box>& boxes, Cache& cache) {
  std::vector<double> volume, areas;  // point, patch, area and vector of every share
  cache.get(comm, "volumes", Cache::Owner::all, fingerprint(body, points, boxes), {&volume, &areas}, [&] {
    volume = body_volumes(body, points, boxes);
    for (const auto& [point, patch, area, vector] : body_areas(body, points))
      areas.insert(areas.end(),
                   {static_cast<double>(point), static_cast<double>(patch), area, vector.x, vector.y, vector.z});
  });
  std::vector<PatchShare> shares;
  for (auto s = areas.begin(); s != areas.end(); s += 6)
    shares.push_back({static_cast<int>(s[0]), static_cast<int>(s[1]), s[2], {s[3], s[4], s[5]}});
  return {std::move(volume), std::move(shares)};
}

}  // namespace

MeasuredPoints measured(MPI_Comm comm, const Body& body, const BodyPoints& points, const std::vector<Box>& boxes,
                        const std::string& cure, Cache* cache) {
  MeasuredPoints out;
  std::vector<PatchShare> shares;
  if (cache)
    std::tie(out.volume, shares) = kept_measures(comm, body, points, boxes, *cache);
  else
    out.volume = body_volumes(body, points, boxes), shares = body_areas(body, points);
  for (int i = 0; i < points.grid.count(); ++i) {
    const Vec3 x = points.grid.x(i);
    const double d = points.grid.spacing(i);
    if (!(out.volume[i] > 0))
      throw Error(Fault::bad_case,
                  fmt::format("the body is too thin or too sharp at ({:.6g}, {:.6g}, {:.6g}) m for points {:.6g} m "
                              "apart, or parts of it touch there",
                              x.x, x.y, x.z, d),
                  cure);
    out.x.push_back(x), out.spacing.push_back(d);
  }
  std::vector<int> face(body.features().count);
  for (std::size_t f = 0; f < body.surface().facets.size(); ++f)
    face[body.features().patch[f]] = body.surface().facets[f].face;
  for (const PatchShare& s : shares) out.pieces.push_back({s.point, face[s.patch], s.area, s.vector});
  out.id.resize(out.x.size());
  std::iota(out.id.begin(), out.id.end(), 0);
  return out;
}

Points slice_of(MPI_Comm comm, const MeasuredPoints& all, std::shared_ptr<const Body> body, double section) {
  Points out;
  out.dimension = body->surface().dimension;
  out.section = section;
  out.faces = body->surface().faces;
  out.exact.volume = section * enclosed_volume(body->surface());
  out.notes = note_on_thin_walls(*body, all);
  out.body = std::move(body);
  const Slice mine = slice(comm, static_cast<std::int64_t>(all.x.size()));
  auto piece = std::ranges::lower_bound(all.pieces, mine.begin, {}, &MeasuredPoints::Piece::point);
  for (auto i = static_cast<std::size_t>(mine.begin); std::cmp_less(i, mine.end); ++i) {
    const double d = all.spacing[i];
    out.points.push_back({.id = all.id[i],
                          .x = all.x[i],
                          .volume = section * all.volume[i],
                          .full_volume = section * std::pow(d, out.dimension),
                          .spacing = d});
    for (; piece != all.pieces.end() && std::cmp_equal(piece->point, i); ++piece)
      out.add_patch(piece->face, section * piece->area, (1 / norm(piece->vector)) * piece->vector,
                    section * piece->vector);
  }
  return out;
}

Points make_body(MPI_Comm comm, Assembly assembly, const SpacingField& spacing, std::uint64_t seed, double section) {
  const auto body = std::make_shared<const Body>(std::move(assembly));
  const std::vector<Box> boxes = cover(*body, spacing);
  return slice_of(comm,
                  measured(comm, *body, make_points(*body, spacing, boxes, seed), boxes, "take a smaller spacing"),
                  body, section);
}

}  // namespace calor
