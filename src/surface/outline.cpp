#include "surface/outline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "surface/triangulate.hpp"

namespace calor {
namespace {

using Vertices = std::array<std::int32_t, 3>;

/// The caps of a swept body: the outline at one end as it is, at the other one turned over. `first` and `last` give the
/// vertices of the corners there.
void add_caps(Surface& surface, const Outline& outline, const std::vector<int>& first, const std::vector<int>& last,
              const std::string& first_name, const std::string& last_name, bool first_is_turned_over) {
  const int first_face = static_cast<int>(surface.faces.size()), last_face = first_face + 1;
  surface.faces.insert(surface.faces.end(), {first_name, last_name});
  const auto add = [&](const std::array<int, 3>& corner, const std::vector<int>& vertex, bool turn, int face) {
    const Vertices out = {vertex[corner[0]], vertex[corner[1]], vertex[corner[2]]};
    surface.facets.push_back({turn ? Vertices{out[0], out[2], out[1]} : out, face});
  };
  for (const std::array<int, 3>& triangle : triangulate(outline)) {
    add(triangle, first, first_is_turned_over, first_face);
    add(triangle, last, !first_is_turned_over, last_face);
  }
}

}  // namespace

Vec3 direction(double angle) {
  const double quarters = angle / (full_turn / 4), whole = std::round(quarters);
  if (std::abs(quarters - whole) > 1e-13) return {std::cos(angle), std::sin(angle), 0};
  const int quadrant = static_cast<int>(std::fmod(whole, 4) + 4) % 4;
  return {quadrant == 0 ? 1.0 : quadrant == 2 ? -1.0 : 0.0, quadrant == 1 ? 1.0 : quadrant == 3 ? -1.0 : 0.0, 0};
}

int chords_in(double radius, double angle, double chord) {
  constexpr double most = 1e6, longest = full_turn / 8;
  // A chord is 2 R sin(angle / 2).
  const double step = std::min(longest, 2 * std::asin(std::min(1.0, chord / (2 * radius))));
  const double count = std::ceil(angle / step * (1 - 1e-12));
  if (!(count <= most))
    throw Error(Fault::bad_case,
                fmt::format("an arc of {:.3g} m radius would have {:.3g} facets of {:.3g} m", radius, count, chord),
                "take a larger spacing, or check the units");
  // All quarters of a turn alike: a round body is its own image in planes through its axis.
  const double quarters = std::round(angle / (full_turn / 4));
  const bool has_quarters = quarters > 0 && std::abs(angle - quarters * (full_turn / 4)) < 1e-9;
  return std::max(1, static_cast<int>(has_quarters ? quarters * std::ceil(count / quarters) : count));
}

std::vector<Vec3> arc(const Vec3& centre, double radius, double from, double to, int chords) {
  std::vector<Vec3> corners;
  for (int n = 0; n <= chords; ++n)
    corners.push_back(centre + radius * direction(n == chords ? to : from + (to - from) * n / chords));
  return corners;
}

Contour circle(double radius, double chord, int face) {
  Contour out;
  out.corner = arc({}, radius, 0, full_turn, chords_in(radius, full_turn, chord));
  out.corner.pop_back();
  out.face.assign(out.corner.size(), face);
  return out;
}

Contour reversed(Contour contour) {
  std::ranges::reverse(contour.corner);
  std::ranges::reverse(contour.face);
  // Edge n ran to corner n + 1, and begins there now.
  std::rotate(contour.face.begin(), contour.face.begin() + 1, contour.face.end());
  return contour;
}

Surface plane_surface(const Outline& outline) {
  Surface out{.dimension = 2, .vertices = {}, .facets = {}, .faces = outline.faces};
  for (const Contour& contour : outline.contours) {
    const auto first = static_cast<int>(out.vertices.size()), count = static_cast<int>(contour.corner.size());
    out.vertices.insert(out.vertices.end(), contour.corner.begin(), contour.corner.end());
    for (int n = 0; n < count; ++n) out.facets.push_back({{first + n, first + (n + 1) % count, -1}, contour.face[n]});
  }
  return out;
}

Surface extruded(const Outline& outline, double height) {
  Surface out{.dimension = 3, .vertices = {}, .facets = {}, .faces = outline.faces};
  std::vector<int> bottom, top;
  for (const Contour& contour : outline.contours) {
    const auto first = static_cast<int>(out.vertices.size()), count = static_cast<int>(contour.corner.size());
    for (const Vec3& x : contour.corner) {
      bottom.push_back(static_cast<int>(out.vertices.size()));
      top.push_back(bottom.back() + 1);
      out.vertices.insert(out.vertices.end(), {x, x + Vec3{0, 0, height}});
    }
    for (int n = 0; n < count; ++n) {
      const int a = first + 2 * n, b = first + 2 * ((n + 1) % count);
      out.facets.push_back({{a, b, b + 1}, contour.face[n]});
      out.facets.push_back({{a, b + 1, a + 1}, contour.face[n]});
    }
  }
  add_caps(out, outline, bottom, top, "bottom", "top", true);
  return out;
}

Surface revolved(const Outline& outline, double angle, double chord) {
  double radius = 0, corners = 0;
  for (const Contour& contour : outline.contours) {
    for (const Vec3& x : contour.corner) radius = std::max(radius, x.x);
    corners += static_cast<double>(contour.corner.size());
  }
  const bool is_whole = angle > full_turn * (1 - 1e-12);
  const int steps = chords_in(radius, std::min(angle, full_turn), chord), columns = is_whole ? steps : steps + 1;
  if (2 * corners * steps > 2e7)
    throw Error(Fault::bad_case,
                fmt::format("facets of {:.3g} m on a body of {:.3g} m radius would be {:.3g}", chord, radius,
                            2 * corners * steps),
                "take a larger spacing, or check the units");
  const std::vector<Vec3> meridians = arc({}, 1, 0, std::min(angle, full_turn), steps);

  Surface out{.dimension = 3, .vertices = {}, .facets = {}, .faces = outline.faces};
  std::vector<int> start, end;
  for (const Contour& contour : outline.contours) {
    const auto count = static_cast<int>(contour.corner.size());
    std::vector<int> first;  // vertices of the corners; on the axis it is one for all meridians
    for (const Vec3& corner : contour.corner) {
      first.push_back(static_cast<int>(out.vertices.size()));
      for (int m = 0; m < (corner.x == 0 ? 1 : columns); ++m)
        out.vertices.push_back({corner.x * meridians[m].x, corner.x * meridians[m].y, corner.y});
      start.push_back(first.back());
      end.push_back(static_cast<int>(out.vertices.size()) - 1);
    }
    for (int n = 0; n < count; ++n) {
      const int a = n, b = (n + 1) % count;
      const auto vertex = [&](int corner, int m) {
        return contour.corner[corner].x == 0 ? first[corner] : first[corner] + m % columns;
      };
      for (int m = 0; m < steps; ++m) {
        if (contour.corner[a].x != 0)
          out.facets.push_back({{vertex(a, m), vertex(a, m + 1), vertex(b, m + 1)}, contour.face[n]});
        if (contour.corner[b].x != 0)
          out.facets.push_back({{vertex(a, m), vertex(b, m + 1), vertex(b, m)}, contour.face[n]});
      }
    }
  }
  if (!is_whole) add_caps(out, outline, start, end, "start", "end", false);
  return out;
}

}  // namespace calor
