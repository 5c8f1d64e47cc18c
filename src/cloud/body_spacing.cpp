#include "cloud/body_spacing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "cloud/face_distance.hpp"

namespace calor {
namespace {

/// A finer spacing on a face or at a place, which grows away from it.
struct Refinement {
  double spacing, growth;
  Vec3 at;  ///< or
  std::shared_ptr<const FaceDistance> face = {};

  /// Distance from it, m, if it is below `bound`.
  std::optional<double> distance(const Vec3& x, double bound) const {
    if (face) return face->within(x, bound);
    return norm(x - at) < bound ? std::optional(norm(x - at)) : std::nullopt;
  }
};

std::vector<Refinement> read_refinements(const Table& cloud, const Function& everywhere, const Surface& body) {
  std::vector<Refinement> out;
  for (const Table& table : cloud.list("near")) {
    if (!(table.number("spacing") > 0))
      table.refuse("spacing", fmt::format("a spacing of {} m is not positive", table.number("spacing")),
                   "give a positive one");
    if (everywhere.is_constant() && !(table.number("spacing") < everywhere({})))
      table.refuse("spacing",
                   fmt::format("a spacing of {:.6g} m here is not below that of the cloud, {:.6g} m",
                               table.number("spacing"), everywhere({})),
                   "give a finer one, or a coarser one to [cloud]");
    const double growth = table.number("growth");
    if (!(growth > 0 && growth <= 1))
      table.refuse("growth", fmt::format("growth = {:g}", growth), "give more than 0 and at most 1: 0.2 suits most");
    if (table.has("face") == table.has("at"))
      table.refuse("", "finer points need to know near what", "give either face = \"...\" or at = [...]");
    Refinement& refined = out.emplace_back(table.number("spacing"), growth);
    if (table.has("face")) {
      refined.face = std::make_shared<const FaceDistance>(body, table, "face");
      continue;
    }
    const std::vector<double> at = table.numbers("at");
    if (static_cast<int>(at.size()) != body.dimension)
      table.refuse("at", fmt::format("a place of {} coordinates in a body of {} dimensions", at.size(), body.dimension),
                   "give one coordinate an axis");
    for (int a = 0; a < body.dimension; ++a) refined.at[a] = at[a];
  }
  return out;
}

}  // namespace

double positive_spacing(const Function& spacing, const Vec3& x) {
  const double d = spacing(x);
  if (!(d > 0))
    throw Error(Fault::bad_case, spacing.location(),
                spacing.is_constant()
                    ? fmt::format("a spacing of {} m is not positive", d)
                    : fmt::format("a spacing of {} m at ({:.6g}, {:.6g}, {:.6g}) m is not positive", d, x.x, x.y, x.z),
                "give a positive one");
  return d;
}

Function spacing_everywhere(const Table& cloud) {
  Function spacing = cloud.function("spacing");
  if (spacing.depends_on_time() || spacing.depends_on_temperature())
    cloud.refuse("spacing", "the spacing depends on time or temperature", "points stay where they are: use x, y, z");
  return spacing;
}

SpacingField spacing_field(const Table& cloud, const Function& everywhere, const Surface& body) {
  std::vector<Refinement> refined = read_refinements(cloud, everywhere, body);
  if (everywhere.is_constant() && refined.empty())
    return {.at = [d = everywhere({})](const Vec3&) { return d; }, .is_uniform = true};
  return {.at =
              [everywhere, refined = std::move(refined)](const Vec3& x) {
                double least = positive_spacing(everywhere, x);
                for (const Refinement& r : refined) {
                  const auto distance = r.distance(x, std::max(0.0, (least - r.spacing) / r.growth));
                  if (distance) least = std::min(least, r.spacing + r.growth * *distance);
                }
                return least;
              },
          .is_uniform = false};
}

}  // namespace calor
