#include "conduction/mlpg_stability.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mlpg_systems.hpp"

namespace calor {
namespace {

LatticeSymbols box(int dimension, int degree, double support, bool one_point = false) {
  return lattice_symbols({dimension, degree}, support, lattice_box(dimension, one_point));
}

TEST(MlpgStability, TilesHaveTheTrueDiffusivityWhateverTheSupport) {
  for (const int dimension : {1, 2, 3})
    for (const double support : {1.5, 1.6, 1.8, 2.3, 2.8}) EXPECT_NEAR(box(dimension, 1, support).kappa, 1, 1e-12);
  EXPECT_NEAR(box(2, 2, 2.3).kappa, 1, 1e-11);
}

TEST(MlpgStability, CirclesAndSpheresBiasTheDiffusivity) {
  // (1/|O|) of the flux of the MLS fit of |x|^2 / (2 D) out of the circle or sphere; a dense evaluation with 64 angles,
  // in 3D 16 x 32 points.
  struct Row {
    int dimension;
    double support;
    std::array<double, 3> kappa;  // radius 0.3, 0.5, 0.7
  };
  const std::vector<Row> table = {{2, 1.5, {1.5065, 1.1659, 0.9311}}, {2, 1.8, {0.9945, 0.9515, 0.9995}},
                                  {2, 2.0, {0.8743, 0.9749, 1.0164}}, {2, 2.3, {1.1223, 1.0307, 0.9825}},
                                  {2, 2.5, {1.1639, 1.0341, 0.9728}}, {2, 2.8, {0.9819, 1.0004, 1.0048}},
                                  {2, 3.3, {1.0339, 1.0031, 0.9953}}, {3, 1.8, {1.1258, 1.0158, 0.9759}},
                                  {3, 2.3, {0.9963, 1.0154, 1.0041}}, {3, 2.8, {1.0223, 1.0118, 1.0016}}};
  const std::array<double, 3> radii = {0.3, 0.5, 0.7};
  for (const Row& row : table) {
    for (int n = 0; n < 3; ++n) {
      SCOPED_TRACE(testing::Message() << row.dimension << "D support " << row.support << " radius " << radii[n]);
      const auto is = lattice_symbols({row.dimension, 1}, row.support, lattice_sphere(row.dimension, radii[n], false));
      EXPECT_NEAR(is.kappa, row.kappa[n], 0.005);
    }
  }
  // A quadratic fit has no ripple.
  EXPECT_NEAR(lattice_symbols({2, 2}, 2.3, lattice_sphere(2, 0.7, false)).kappa, 1, 1e-11);
}

TEST(MlpgStability, SymbolsTellWhichSupportsAreStable) {
  // Least capacity symbols of the same stencils by an independent program, in numpy.
  struct Row {
    int dimension, degree;
    double support, least_capacity, within;
  };
  for (const Row& row : {Row{2, 1, 1.8, 0.037, 1e-3}, Row{2, 1, 2.3, 0.0023, 1e-4}, Row{2, 1, 2.8, 0.0007, 1e-4},
                         Row{2, 2, 2.2, 0.072, 1e-3}, Row{2, 2, 2.4, 0.0137, 1e-3}, Row{2, 2, 2.6, -0.007, 1e-3},
                         Row{3, 1, 1.5, 0.0267, 1e-3}, Row{3, 1, 1.6, 0.0209, 1e-3}, Row{3, 1, 1.75, 0.0017, 1e-4},
                         Row{3, 1, 1.8, -0.0022, 1e-4}, Row{3, 1, 2.3, -0.0023, 1e-4}}) {
    SCOPED_TRACE(testing::Message() << row.dimension << "D degree " << row.degree << " support " << row.support);
    const auto is = box(row.dimension, row.degree, row.support);
    EXPECT_NEAR(is.least_capacity, row.least_capacity, row.within);
    EXPECT_EQ(is.stable(), row.least_capacity > 0);
  }
}

TEST(MlpgStability, StartUpMarchSeparatesStableFromUnstableSchemes) {
  // In 3D on a lattice parameters grow at a support of 1.8 and more, on clouds jittered by 0.05 too.
  const auto growth = [](double jitter, double support) {
    const Cloud cloud = box_cloud({15, 15, 15}, 0.1, {.jitter = jitter});
    auto o = MlpgOptions::defaults(3, cloud.box_lattice);
    o.flux = MlpgFlux::parameters;
    o.support.spacings = support;
    MlpgReport report;
    const auto scheme = mlpg_scheme(cloud, o, report);
    return start_up_growth(cloud, *scheme.conduction);
  };
  for (const double jitter : {0.0, 0.2}) EXPECT_LT(growth(jitter, 1.6), 1);
  EXPECT_GT(growth(0.0, 2.0), 1e3);
  EXPECT_GT(growth(0.05, 2.0), 1e3);
}

TEST(MlpgSpheres, FillHalfAndQuarterCirclesAtWallsAndCorners) {
  const Cloud cloud = box_cloud({5, 6}, 0.1, {.section = 0.02});
  auto o = MlpgOptions::defaults(2, true);
  o.subdomain = MlpgSubdomain::sphere;
  MlpgReport report;
  const auto scheme = mlpg_scheme(cloud, o, report);
  const CellQuadrature& cells = *scheme.conduction->rows().cells;
  for (int i = 0; i < cloud.owned; ++i) {
    double volume = 0;
    Vec3 first;
    for (auto q = cells.cell[i]; q < cells.cell[i + 1]; ++q) {
      volume += cells.volume[q];
      first += cells.volume[q] * (cells.x[q] - cloud.x[i]);
    }
    Vec3 closed;
    for (std::size_t q = 0; q < scheme.conduction->faces().size(); ++q)
      if (scheme.conduction->faces().a[q] == i) closed += scheme.conduction->faces().area[q];
    if (cloud.on_faces[i] == 0) {
      EXPECT_NEAR(volume / cloud.volume[i], 1, 1e-12);
      EXPECT_LE(norm(closed), 1e-15);
    } else {
      // What leaves through the wall is the boundary area; the centroid of half a circle is 4 R / (3 pi) inside.
      EXPECT_LE(norm(closed + cloud.area[i]), 1e-7 * norm(cloud.area[i]));
      const double inward = std::abs(dot(first, cloud.area[i])) / (volume * norm(cloud.area[i]));
      const bool corner = dot(cloud.area[i], cloud.area[i]) < 0.9 * 0.02 * 0.1 * 0.02 * 0.1;
      EXPECT_NEAR(inward, 4 * 0.07 / (3 * std::acos(-1)) * (corner ? std::sqrt(2.0) : 1), 2e-4);
    }
  }
}

}  // namespace
}  // namespace calor
