#include "conduction/pair_directions.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/cracks.hpp"
#include "cloud/lattice.hpp"

namespace calor {
namespace {

/// The cloud in y = R^(-1/2) x, R scaled to determinant 1, so that volumes stay: A' = R^(1/2) A. With points on walls.
Cloud conducting_alike(const Cloud& cloud, const Anisotropy& R, double scale) {
  Cloud y = cloud;
  const double root = std::sqrt(scale);
  const Symmetric3 to_y = R.power(-0.5), of_area = R.power(0.5);
  const std::array<Vec3, 3> rows = {
      {{to_y.xx, to_y.xy, to_y.xz}, {to_y.xy, to_y.yy, to_y.yz}, {to_y.xz, to_y.yz, to_y.zz}}};
  for (int i = 0; i < cloud.local(); ++i) {
    y.x[i] = root * (to_y * cloud.x[i]);
    y.area[i] = (1 / root) * (of_area * cloud.area[i]);
    for (int a = 0; a < 3; ++a) y.metric[i][a] = root * norm(product(rows[a], cloud.metric[i]));
  }
  y.nearest_volumes = cloud.lattice != nullptr;
  y.lattice = nullptr, y.rings = y.disc = nullptr, y.box_lattice = false, y.isotropic = false;
  return y;
}

/// The largest conductivity over the least where lengths are measured in the spacings of the points: 1 on a cloud whose
/// spacings go with the roots of the conductivities. Collective.
double ratio_in_spacings(const Cloud& cloud, const Symmetric3& R) {
  double largest = 1;
  for (int i = 0; i < cloud.owned; ++i) {
    if (i > 0 && cloud.metric[i] == cloud.metric[i - 1]) continue;
    const Vec3& s = cloud.metric[i];
    Eigen::Matrix3d in_spacings;
    in_spacings << R.xx / (s.x * s.x), R.xy / (s.x * s.y), R.xz / (s.x * s.z),  //
        R.xy / (s.x * s.y), R.yy / (s.y * s.y), R.yz / (s.y * s.z),             //
        R.xz / (s.x * s.z), R.yz / (s.y * s.z), R.zz / (s.z * s.z);
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(in_spacings.topLeftCorner(cloud.dimension, cloud.dimension))
            .eigenvalues();
    largest = std::max(largest, values.maxCoeff() / values.minCoeff());
  }
  return max(cloud.comm, largest);
}

/// Does every part have the R of the first?
bool is_the_same_everywhere(const MaterialField& material) {
  const Anisotropy* first = material.anisotropy(0);
  for (int part = 1; part < material.parts().count(); ++part) {
    const Anisotropy* other = material.anisotropy(part);
    if (!first || !other || !(*first == *other)) return false;
  }
  return true;
}

}  // namespace

double along(const Symmetric3& R, const Vec3& x_ji) { return dot(x_ji, R * x_ji) / dot(x_ji, x_ji); }

PairDirections pair_directions(const Case& c, const Cloud& cloud, const MaterialField& material, bool along_lines) {
  PairDirections directions;
  if (material.is_isotropic()) {
    // Several parts conduct alike in all directions, but not alike: pairs along the axes of a lattice have faces, and
    // these tell what each part conducts (fibres.hpp).
    const int parts = material.parts().count();
    if (parts > 1 && along_lines && cloud.lattice && !has_cracks(c))
      directions.of_parts.assign(parts, Symmetric3{1, 1, 1});
    return directions;
  }
  const Table& root = c.root();
  if (has_cracks(c))
    root.refuse("method", "cracks in a material that conducts differently by direction are not known",
                "leave the cracks or the anisotropy out");
  bool on_lines = along_lines && cloud.lattice;
  for (int part = 0; part < material.parts().count(); ++part) {
    const Anisotropy* R = material.anisotropy(part);
    on_lines = on_lines && (!R || R->is_diagonal());
    directions.of_parts.push_back(!R ? Symmetric3{1, 1, 1} : R->cylinder ? Symmetric3() : R->power(1));
  }
  if (on_lines) return directions;
  if (cloud.axisymmetric)
    root.refuse("method",
                "in an axisymmetric body pairs of points conduct differently by direction on lattices alone, along "
                "their axes",
                "use a box without jitter and factors along x and y, or method = \"mlpg\"");
  directions.of_parts.clear();
  if (material.parts().has_contacts())
    root.refuse("method",
                "contacts in a material that conducts differently by direction are known in boxes without jitter "
                "alone, between parts that meet on planes normal to the axes",
                "put the contacts there, leave them out, or give all materials the same conductivity along all axes");
  const bool one = is_the_same_everywhere(material) && !material.anisotropy(0)->cylinder;
  if (!one)
    root.refuse(
        "method",
        "here pairs of points conduct by one tensor for the whole body, the material has others from place to "
        "place",
        material.parts().count() == 1
            ? "use method = \"mlpg\""
            : "use a box without jitter whose axes are those of all materials, or one anisotropy for all parts");
  if (!cloud.points_on_walls)
    root.refuse("method",
                "points off the walls of a material that conducts differently by direction are served on lattices "
                "alone, along their axes",
                "use points on the walls");
  directions.in_weights = *material.anisotropy(0);
  return directions;
}

std::vector<double> anisotropic_weights(const Cloud& cloud, const Neighbours& neighbours, const Anisotropy& R,
                                        const BaseWeights& base_weights, CorrectionReport& report) {
  // Points displaced by 0.2 spacings have weights up to 1 : 20, not all of them positive, and none for 1 : 100.
  constexpr double largest_ratio = 30;
  const double ratio = ratio_in_spacings(cloud, R.power(1));
  if (!(ratio <= largest_ratio))
    throw Error(
        Fault::bad_case,
        fmt::format("in units of the spacings the material conducts {:.4g} times better along one direction than "
                    "along another; pairs of points that do not lie along its axes serve up to {:g}",
                    ratio, largest_ratio),
        cure_of_anisotropy);
  double determinant = 1;
  for (int a = 0; a < cloud.dimension; ++a) determinant *= R.factors[a];
  const double scale = std::pow(determinant, 1.0 / cloud.dimension);
  // At a corner no positive weights may exist, where k R n of its walls points out of the angle between them: to lift
  // the weights there again and again would spoil the numbers.
  constexpr int solves = 2;
  std::vector<double> G =
      consistent_weights(conducting_alike(cloud, R, scale), neighbours, base_weights, {}, report, solves);
  for (double& g : G) g *= scale;
  return G;
}

}  // namespace calor
