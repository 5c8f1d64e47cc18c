#include "cloud/symmetry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "cloud/cells.hpp"
#include "surface/combine.hpp"
#include "surface/outline.hpp"
#include "surface/surface_tree.hpp"

namespace calor {
namespace {

/// A box that holds everything of the surface above the plane.
Surface box_above(const Surface& surface, const MirrorPlane& plane) {
  Bounds box = bounds_of(surface.vertices);
  const double margin = 0.1 * norm(box.high - box.low);
  for (int a = 0; a < surface.dimension; ++a) box.low[a] -= margin, box.high[a] += margin;
  box.low[plane.axis] = plane.at;
  const Vec3 &low = box.low, &high = box.high;
  const Outline outline{
      .contours = {{.corner = {{low.x, low.y, 0}, {high.x, low.y, 0}, {high.x, high.y, 0}, {low.x, high.y, 0}},
                    .face = {0, 0, 0, 0}}},
      .faces = {cut_face}};
  if (surface.dimension == 2) return plane_surface(outline);
  Surface out = extruded(outline, high.z - low.z);
  for (Vec3& x : out.vertices) x.z += low.z;
  for (Surface::Triangle& f : out.facets) f.face = 0;
  out.faces = {cut_face};
  return out;
}

/// Of a name, which is added if it is new.
int face_number(const std::string& name, std::vector<std::string>& faces) {
  const auto found = std::ranges::find(faces, name);
  const auto number = static_cast<int>(found - faces.begin());
  if (found == faces.end()) faces.push_back(name);
  return number;
}

}  // namespace

Surface upper_half(const Surface& surface, const MirrorPlane& plane) {
  if (!(bounds_of(surface.vertices).high[plane.axis] > plane.at)) {
    Surface nothing = surface;
    nothing.facets.clear();
    return nothing;
  }
  return intersection(surface, box_above(surface, plane));
}

void add_face_images(const Surface& whole, const MirrorPlane& plane, double alike, FaceImages& images) {
  const SurfaceTree tree(whole);
  for (int n = 0; n < static_cast<int>(whole.facets.size()); ++n) {
    const Vec3 x = whole.centroid(n);
    const auto closest = tree.closest(plane.image(x), alike);
    if (!closest) continue;
    std::string above = whole.faces[whole.facets[n].face], below = whole.faces[whole.facets[closest->facet].face];
    if (x[plane.axis] < plane.at) std::swap(above, below);
    const auto [known, is_new] = images.try_emplace(above, below);
    if (!is_new && known->second != below)
      throw Error(Fault::bad_case,
                  fmt::format("the image of face '{}' has two names, '{}' and '{}'", above, known->second, below),
                  "give both one name, or leave the axis out of 'symmetry'");
  }
}

Surface with_image(const Surface& half, const MirrorPlane& plane, const FaceImages& images) {
  Surface out = half;
  const auto cut = std::ranges::find(out.faces, cut_face) - out.faces.begin();
  std::erase_if(out.facets, [&](const Surface::Triangle& f) { return f.face == cut; });
  if (cut < std::ssize(out.faces)) out.faces.erase(out.faces.begin() + cut);
  for (Surface::Triangle& f : out.facets) f.face -= f.face > cut;
  const auto count = static_cast<std::int32_t>(out.vertices.size());
  for (std::int32_t v = 0; v < count; ++v) out.vertices.push_back(plane.image(out.vertices[v]));
  const std::size_t facets = out.facets.size();
  for (std::size_t n = 0; n < facets; ++n) {
    Surface::Triangle f = out.facets[n];
    for (int k = 0; k < out.dimension; ++k) f.vertex[k] += count;
    std::swap(f.vertex[0], f.vertex[1]);
    const auto image = images.find(out.faces[f.face]);
    if (image != images.end()) f.face = face_number(image->second, out.faces);
    out.facets.push_back(f);
  }
  const Bounds box = bounds_of(out.vertices);
  weld(out, 1e-8 * norm(box.high - box.low));
  return out;
}

MeasuredPoints with_images(const MeasuredPoints& half, const MirrorPlane& plane, int cut,
                           std::span<const int> image_of_face) {
  constexpr double on = 1e-6, smooth = 0.866;  // in spacings; cosine of 30 degrees
  MeasuredPoints out = half;
  out.pieces.clear();
  std::vector<int> image(half.x.size());
  for (std::size_t i = 0; i < half.x.size(); ++i) {
    image[i] = static_cast<int>(i);
    if (std::abs(half.x[i][plane.axis] - plane.at) < on * half.spacing[i]) {
      out.x[i][plane.axis] = plane.at;
      out.volume[i] *= 2;
      continue;
    }
    image[i] = static_cast<int>(out.x.size());
    out.x.push_back(plane.image(half.x[i]));
    out.spacing.push_back(half.spacing[i]);
    out.volume.push_back(half.volume[i]);
  }
  std::vector<MeasuredPoints::Piece> images;
  for (const MeasuredPoints::Piece& piece : half.pieces) {
    if (piece.face == cut) continue;
    MeasuredPoints::Piece other = piece;
    other.point = image[piece.point];
    other.vector = plane.image_of_direction(piece.vector);
    other.face = image_of_face[piece.face];
    if (other.point != piece.point) {
      out.pieces.push_back(piece);
      images.push_back(other);
    } else if (other.face == piece.face &&
               dot(piece.vector, other.vector) > smooth * dot(piece.vector, piece.vector)) {  // one piece across it
      out.pieces.push_back({piece.point, piece.face, 2 * piece.area, piece.vector + other.vector});
    } else {
      out.pieces.push_back(piece);
      out.pieces.push_back(other);
    }
  }
  out.pieces.insert(out.pieces.end(), images.begin(), images.end());
  out.id.resize(out.x.size());
  std::iota(out.id.begin(), out.id.end(), 0);
  return out;
}

}  // namespace calor
