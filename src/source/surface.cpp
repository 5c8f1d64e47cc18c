// Gaussian heat flux on a face: q'' = 3 q / (pi R^2) exp(-3 r^2 / R^2), R = sqrt(6) sigma.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "source/kinds.hpp"
#include "source/moving_source.hpp"

namespace calor {
namespace {

/// Index of the face and the axis that it is nearest to being normal to. Collective.
std::pair<int, int> face_and_axis(const Table& surface, const Cloud& cloud) {
  const std::string name = surface.text("face");
  const auto face = std::ranges::find(cloud.faces, name);
  if (face == cloud.faces.end())
    surface.refuse(
        "face", fmt::format("there is no face '{}'", name),
        cloud.faces.empty() ? "the cloud has none" : fmt::format("the faces are {}", fmt::join(cloud.faces, ", ")));
  const int f = static_cast<int>(face - cloud.faces.begin());
  std::vector<double> normal;
  for (const Facet& p : cloud.facets)
    if (p.face == f) normal.insert(normal.end(), {std::abs(p.normal.x), std::abs(p.normal.y), std::abs(p.normal.z)});
  const std::vector<double> most = sums(cloud.comm, normal, 3);
  return {f, static_cast<int>(std::ranges::max_element(most) - most.begin())};
}

}  // namespace

const SourceKind surface_source = {
    .key = "surface",
    .declare =
        [](Schema& schema) {
          schema.add({.path = "source.*",
                      .sentence = "A Gaussian heat flux on a face.",
                      .keys = {{"surface", Kind::table, "", optional, "A Gaussian heat flux on a face."}}});
          std::vector<Key> keys = sigma_keys();
          keys.insert(keys.begin(), {"face", Kind::text, "", required, "Face of the cloud that is heated."});
          schema.add({.path = "source.*.surface", .sentence = "A Gaussian heat flux on a face.", .keys = keys});
        },
    .make = [](const std::string& name, const Table& table, const Cloud& cloud) -> std::unique_ptr<Source> {
      const Table surface = table.sub("surface");
      const double sigma = sigma_of(surface);
      const auto [face, axis] = face_and_axis(surface, cloud);
      return make_moving_source(name, table, cloud,
                                {.along = SourceProfile::gaussian(sigma),
                                 .across = SourceProfile::gaussian(sigma),
                                 .is_round = true,
                                 .axis = axis,
                                 .face = face,
                                 .radius = std::sqrt(6) * sigma,
                                 .sigma = sigma});
    }};

}  // namespace calor
