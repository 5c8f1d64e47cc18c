#include "material/anisotropy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace calor {
namespace {

Symmetric3 tensor(const Vec3& factors, const std::array<Vec3, 3>& axes) {
  Symmetric3 R;
  for (int a = 0; a < 3; ++a) R.add(factors[a], axes[a]);
  // What is left of cos 90 deg must not turn a material whose axes are those of the body.
  const double round_off = 1e-15 * std::max({factors.x, factors.y, factors.z});
  for (double* mixed : {&R.xy, &R.xz, &R.yz})
    if (std::abs(*mixed) <= round_off) *mixed = 0;
  return R;
}

/// The axes of the case after a turn about z, then one about their own y, then one about their own x, rad.
std::array<Vec3, 3> turned(const std::vector<double>& angles) {
  std::array<Vec3, 3> e = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const std::array<std::pair<int, int>, 3> planes = {{{0, 1}, {2, 0}, {1, 2}}};
  for (std::size_t n = 0; n < angles.size(); ++n) {
    const auto [a, b] = planes[n];
    const double c = std::cos(angles[n]), s = std::sin(angles[n]);
    const Vec3 u = e[a], v = e[b];
    e[a] = c * u + s * v, e[b] = c * v - s * u;
  }
  return e;
}

}  // namespace

Symmetric3 Anisotropy::at(const Vec3& x) const {
  if (!cylinder) return tensor(factors, axes);
  Vec3 axial, radial = x - cylinder->centre;
  axial[cylinder->axis] = 1, radial[cylinder->axis] = 0;
  const double r = norm(radial);
  if (r > 0) return tensor(factors, {(1 / r) * radial, (1 / r) * cross(axial, radial), axial});
  const double across = 0.5 * (factors.x + factors.y);
  Vec3 all{across, across, across};
  all[cylinder->axis] = factors.z;
  return {all.x, all.y, all.z};
}

Symmetric3 Anisotropy::power(double power) const {
  return tensor({std::pow(factors.x, power), std::pow(factors.y, power), std::pow(factors.z, power)}, axes);
}

std::optional<Anisotropy> read_anisotropy(const Table& material) {
  if (!material.has("anisotropy")) return std::nullopt;
  const Table table = material.sub("anisotropy");
  const std::array straight = {"x", "y", "z"}, round = {"radial", "hoop", "axial"};
  const auto given = [&](const auto& keys) {
    const auto found = std::ranges::find_if(keys, [&](const char* key) { return table.has(key); });
    return found == keys.end() ? nullptr : *found;
  };
  const char* wound = given(round);
  if (const char* key = given(straight); key && wound)
    table.refuse(key, fmt::format("[{}] has '{}' and '{}'", table.path(), key, wound),
                 "give x, y and z, or radial, hoop and axial");
  Anisotropy out;
  for (int a = 0; a < 3; ++a) {
    const char* key = wound ? round[a] : straight[a];
    out.factors[a] = table.number(key);
    if (!(out.factors[a] > 0))
      table.refuse(key, fmt::format("{} = {:g}: the factor of a conductivity is not positive", key, out.factors[a]),
                   "give the conductivity along this axis over that of `conductivity`");
  }
  const char* belongs_to_other = wound ? "turn" : table.has("axis") ? "axis" : "centre";
  if (table.has(belongs_to_other))
    table.refuse(belongs_to_other, fmt::format("'{}' does not go with {}", belongs_to_other, wound ? wound : "x, y, z"),
                 wound ? "a material that is wound around a line is placed by axis and centre"
                       : "axes that are the same everywhere are placed by turn");
  if (wound) {
    Anisotropy::Cylinder& c = out.cylinder.emplace();
    c.axis = table.text("axis")[0] - 'x';
    const std::vector<double> centre = table.numbers("centre");
    if (centre.size() > 3) table.refuse("centre", "a point has three coordinates at most", "give x, y and z");
    for (std::size_t a = 0; a < centre.size(); ++a) c.centre[static_cast<int>(a)] = centre[a];
  } else if (table.has("turn")) {
    const std::vector<double> angles = table.numbers("turn");
    if (angles.size() > 3) table.refuse("turn", "there are more than three angles", "turn about z, then y, then x");
    out.axes = turned(angles);
  }
  return out;
}

void require_axes_in_body(const Anisotropy& anisotropy, int dimension, const SourceLocation& location) {
  if (dimension == 3) return;
  const Symmetric3 R = anisotropy.power(1);
  const bool leaves = anisotropy.cylinder ? anisotropy.cylinder->axis != 2 || dimension == 1
                                          : R.xz != 0 || R.yz != 0 || (dimension == 1 && R.xy != 0);
  if (leaves)
    throw Error(Fault::bad_case, location,
                fmt::format("the axes of the material leave the body, which has {} dimension{}", dimension,
                            dimension == 1 ? "" : "s"),
                dimension == 2 ? "turn them about z alone, or give the body a third length"
                               : "leave the turn out, or give the body a second length");
}

void declare_anisotropy(Schema& schema) {
  const auto factor = [](const char* name, const char* axis) {
    return Key{name, Kind::number, "", "1", fmt::format("Conductivity along {} over `conductivity`.", axis)};
  };
  schema.add({.path = "material.*.anisotropy",
              .sentence =
                  "How the conductivity depends on direction: factors along three axes at right angles, those of the "
                  "case, turned, or those of a cylinder (docs/anisotropy.md).",
              .keys = {factor("x", "the material's first axis, x before the turn"),
                       factor("y", "its second axis"),
                       factor("z", "its third axis"),
                       {"turn", Kind::quantities, "rad", optional,
                        "Turns the axes about z; a second angle then about their own y, a third about their own x."},
                       factor("radial", "the direction away from a line, instead of x, y, z"),
                       factor("hoop", "the direction around the line"),
                       factor("axial", "the line"),
                       {"axis", Kind::choice, "", "z", "Direction of the line.", {"x", "y", "z"}},
                       {"centre", Kind::quantities, "m", "[\"0 m\", \"0 m\", \"0 m\"]", "A point on the line."}}});
}

}  // namespace calor
