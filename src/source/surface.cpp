// Gaussian heat flux on a face: q'' = 3 q / (pi R^2) exp(-3 r^2 / R^2), R = sqrt(6) sigma.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "source/source_profile.hpp"

namespace calor {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double flat = 1e-6;  ///< of a spacing, and of a unit normal: rounding of coordinates

struct HeatedFace {
  int index;
  int axis;        ///< that it is nearest to being normal to
  bool is_curved;  ///< not in one plane normal to the axis
};

/// Collective.
HeatedFace heated_face(const Table& surface, const Cloud& cloud) {
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
  const int axis = static_cast<int>(std::ranges::max_element(most) - most.begin());
  // Of the places along the axis, of the normals along it, and of the spacing.
  std::array<double, 5> low{infinity, infinity, infinity, infinity, infinity};
  for (const Facet& p : cloud.facets) {
    if (p.face != f) continue;
    const double x = place_on_wall(cloud, p)[axis], n = p.normal[axis], spacing = cloud.spacing[p.point];
    const std::array<double, 5> own{x, -x, n, -n, spacing};
    for (std::size_t q = 0; q < own.size(); ++q) low[q] = std::min(low[q], own[q]);
  }
  lowest(cloud.comm, low);
  const bool is_level = -low[1] - low[0] <= flat * low[4];
  const bool is_normal = std::max(low[2], low[3]) >= 1 - flat;
  return {.index = f, .axis = axis, .is_curved = !(is_level && is_normal)};
}

}  // namespace

SourceProfileKind surface_profile() {
  return {.name = "surface",
          .sentence = "A Gaussian heat flux on a face",
          .keys = sigma_keys({{"face", Kind::text, "", required, "Face of the cloud that is heated."}}),
          .make = [](const Table& surface, const Cloud& cloud) -> SourceProfile {
            const double sigma = sigma_of(surface);
            const HeatedFace face = heated_face(surface, cloud);
            return {.along = AxisProfile::gaussian(sigma),
                    .across = AxisProfile::gaussian(sigma),
                    .is_round = true,
                    .axis = face.axis,
                    .face = face.index,
                    .is_curved = face.is_curved,
                    .radius = std::sqrt(6) * sigma,
                    .sigma = sigma};
          }};
}

}  // namespace calor
