// A shape of clouds: a ring of concentric circles of points, with the same number on each.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cloud/shapes.hpp"
#include "run_case.hpp"

namespace calor {
namespace {

Points make_annulus(MPI_Comm comm, const Table& cloud) {
  const double inner = cloud.number("inner"), outer = cloud.number("outer"), thickness = section_of(cloud, 2);
  const long circles = cloud.integer("circles"), around = cloud.integer("around");
  if (!(inner > 0 && outer > inner)) cloud.refuse("outer", "the ring has no width", "give 0 < inner < outer");
  if (circles < 2) cloud.refuse("circles", "fewer than 2 circles", "give at least 2: both faces");
  const double dr = (outer - inner) / static_cast<double>(circles - 1);
  const double angle = 2 * std::numbers::pi / static_cast<double>(around);

  Points out;
  out.dimension = 2;
  out.section = thickness;
  out.nearest_volumes = false;
  out.faces = {"inner", "outer"};
  const Slice mine = slice(comm, circles * around);
  for (std::int64_t id = mine.begin; id < mine.end; ++id) {
    const std::int64_t circle = id / around;
    const bool first = circle == 0, last = circle == circles - 1;
    const double r = inner + static_cast<double>(circle) * dr;
    const double low = first ? r : r - dr / 2, high = last ? r : r + dr / 2;
    const Vec3 normal = {std::cos(static_cast<double>(id % around) * angle),
                         std::sin(static_cast<double>(id % around) * angle), 0};
    const double volume = thickness * angle / 2 * (high * high - low * low);
    out.points.push_back({.id = id,
                          .x = r * normal,
                          .volume = volume,
                          .full_volume = volume * (first || last ? 2 : 1),
                          .spacing = std::max(dr, r * angle)});
    // The area vector of an arc is that of its chord.
    const double chord = 2 * r * std::sin(angle / 2) * thickness;
    if (first) out.add_patch(0, r * angle * thickness, -normal, -chord * normal);
    if (last) out.add_patch(1, r * angle * thickness, normal, chord * normal);
  }
  return out;
}

TEST(Plugin, IsAShapeOfClouds) {
  cloud_shapes().add({.name = "annulus",
                      .sentence = "A ring of concentric circles of points. Faces: inner, outer",
                      .keys = {{"inner", Kind::quantity, "m", required, "Inner radius."},
                               {"outer", Kind::quantity, "m", required, "Outer radius."},
                               {"circles", Kind::integer, "", required, "Circles of points, both faces included."},
                               {"around", Kind::integer, "", required, "Points on every circle."}},
                      .make = make_annulus});
  // Between 1 m and 2 m the temperature goes as ln r.
  expect_passes(R"toml(title = "ring"
method = "sph"
[cloud]
shape = "annulus"
inner = "1 m"
outer = "2 m"
circles = 16
around = 96
[material.m]
conductivity = "1 W/(m K)"
[steady]
[boundary.inner]
temperature = "400 K"
[boundary.outer]
temperature = "300 K"
[[expect]]
field = true
value = { formula = "400 - 100*ln(r)/ln(2)", unit = "K" }
within = "0.5 K"
)toml");
}

}  // namespace
}  // namespace calor
