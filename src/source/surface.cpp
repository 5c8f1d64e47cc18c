// Gaussian heat flux on a face: q'' = 3 q / (pi R^2) exp(-3 r^2 / R^2), R = sqrt(6) sigma.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "source/source_profile.hpp"

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

SourceProfileKind surface_profile() {
  return {.name = "surface",
          .sentence = "A Gaussian heat flux on a face",
          .keys = sigma_keys({{"face", Kind::text, "", required, "Face of the cloud that is heated."}}),
          .make = [](const Table& surface, const Cloud& cloud) -> SourceProfile {
            const double sigma = sigma_of(surface);
            const auto [face, axis] = face_and_axis(surface, cloud);
            return {.along = AxisProfile::gaussian(sigma),
                    .across = AxisProfile::gaussian(sigma),
                    .is_round = true,
                    .axis = axis,
                    .face = face,
                    .radius = std::sqrt(6) * sigma,
                    .sigma = sigma};
          }};
}

}  // namespace calor
