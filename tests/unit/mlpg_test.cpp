#include "conduction/mlpg.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"
#include "conduction/quadrature.hpp"
#include "mlpg_systems.hpp"

namespace calor {
namespace {

struct NamedCloud {
  const char* name;
  Cloud cloud;
};

std::vector<NamedCloud> clouds(MPI_Comm comm = MPI_COMM_SELF) {
  std::vector<NamedCloud> all;
  all.push_back({"rod", box_cloud({12}, 0.1, {.section = 0.03, .support = 6, .comm = comm})});
  all.push_back({"lattice 2D", box_cloud({11, 9}, 0.1, {.support = 6, .comm = comm})});
  all.push_back({"lattice 3D", box_cloud({7, 8, 6}, 0.1, {.support = 6, .comm = comm})});
  all.push_back({"jittered rod", box_cloud({12}, 0.1, {.jitter = 0.2, .section = 0.03, .support = 6, .comm = comm})});
  all.push_back({"jittered 2D", box_cloud({11, 9}, 0.1, {.jitter = 0.2, .support = 6, .comm = comm})});
  all.push_back({"thin plate", box_cloud({9, 9}, 0.1, {.jitter = 0.3, .section = 1e-3, .support = 6, .comm = comm})});
  all.push_back({"jittered 3D", box_cloud({7, 8, 6}, 0.1, {.jitter = 0.2, .support = 6, .comm = comm})});
  all.push_back({"disc", distribute(comm, make_rings(comm, {.radius = 0.5, .rings = 6, .thickness = 0.01}), 0.6)});
  return all;
}

MlpgOptions options(const Cloud& cloud, MlpgFlux flux) {
  MlpgOptions o = MlpgOptions::defaults(cloud.dimension, cloud.box_lattice);
  o.flux = flux;
  return o;
}

/// Calls use(cloud, options) for every cloud and both fluxes.
template <class Use>
void for_every_scheme(const Use& use, MPI_Comm comm = MPI_COMM_SELF) {
  for (const auto& [name, cloud] : clouds(comm)) {
    for (const MlpgFlux flux : {MlpgFlux::parameters, MlpgFlux::edge_stabilised}) {
      SCOPED_TRACE(std::string(name) + (flux == MlpgFlux::parameters ? ", parameters" : ", edge-stabilised"));
      use(cloud, options(cloud, flux));
    }
  }
}

TEST(Mlpg, CellsCloseWithTheirShareOfTheSurface) {
  for (const auto& [name, cloud] : clouds()) {
    SCOPED_TRACE(name);
    MlpgReport report;
    const auto scheme = mlpg_scheme(cloud, options(cloud, MlpgFlux::parameters), report);
    std::vector<Vec3> sum(cloud.area.begin(), cloud.area.end());
    for (std::size_t q = 0; q < scheme.conduction->faces().size(); ++q) {
      sum[scheme.conduction->faces().a[q]] += scheme.conduction->faces().area[q];
      sum[scheme.conduction->faces().b[q]] -= scheme.conduction->faces().area[q];
    }
    double largest = 0;
    for (int i = 0; i < cloud.owned; ++i)
      largest = std::max(largest, norm(sum[i]) / std::pow(0.1, cloud.dimension - 1) / cloud.cross_section);
    EXPECT_LE(largest, 1e-12);
    // Second moments: exact on lattices, where nothing is solved; elsewhere the virtual faces fit them.
    EXPECT_LE(report.faces.moment_error, 0.05);
  }
}

TEST(Mlpg, ReproducesLinearTemperaturesAndTheirFlux) {
  for_every_scheme([](const Cloud& cloud, const MlpgOptions& o) {
    const Vec3 slope{7, cloud.dimension > 1 ? -4. : 0., cloud.dimension > 2 ? 2. : 0.};
    const Field T = [&](const Vec3& x) { return 3 + dot(slope, x); };
    const MlpgSystem s(cloud, o);
    EXPECT_LE(s.error(s.steady(T, [](const Vec3&) { return 0; }), T), 1e-11);
    // The heat into every cell is what enters through its share of the surface.
    const Vector linear = s.at_points(T), heat = s.K * linear;
    double largest = 0;
    for (int i = 0; i < cloud.owned; ++i) largest = std::max(largest, std::abs(heat[i] - dot(slope, cloud.area[i])));
    EXPECT_LE(largest / (7 * std::pow(0.1, cloud.dimension - 1) * cloud.cross_section), 1e-11);
    const std::vector<double> k = everywhere(cloud, *s.scheme.conduction, 50);
    std::vector<Vec3> q(cloud.owned);
    std::vector<int> all(cloud.owned);
    std::iota(all.begin(), all.end(), 0);
    s.scheme.conduction->heat_flux({.k = k, .dk_dT = {}, .theta = {}},
                                   {linear.data(), static_cast<std::size_t>(linear.size())}, all, q);
    for (const Vec3& flux : q) EXPECT_LE(norm(flux + 50 * slope), 1e-8);
  });
}

TEST(Mlpg, ConservesHeatAndKeepsUniformTemperaturesUniform) {
  for_every_scheme([](const Cloud& cloud, const MlpgOptions& o) {
    MlpgReport report;
    const auto scheme = mlpg_scheme(cloud, o, report);
    std::vector<double> k = everywhere(cloud, *scheme.conduction, 40), T, F(cloud.owned),
                        uniform(cloud.local(), 293.15);
    for (std::size_t q = 0; q < k.size(); ++q) k[q] += 9 * std::sin(static_cast<double>(q));
    for (int i = 0; i < cloud.local(); ++i) T.push_back(300 + 50 * std::cos(3.0 * i));
    const Conductivity conductivity{.k = k, .dk_dT = {}, .theta = {}};
    scheme.conduction->add_rate(conductivity, uniform, F);
    for (double f : F) EXPECT_EQ(f, 0);
    scheme.conduction->add_rate(conductivity, T, F);
    double total = 0, size = 0;
    for (double f : F) total += f, size += std::abs(f);
    EXPECT_LE(std::abs(total), 1e-14 * size);
  });
}

TEST(Mlpg, HasTheJacobianOfItsRate) {
  for_every_scheme([](const Cloud& cloud, const MlpgOptions& o) {
    MlpgReport report;
    const auto scheme = mlpg_scheme(cloud, o, report);
    const int n = cloud.local();
    // k = 2 + T + T^2/10 where the scheme wants it, theta its integral.
    const auto property = [&](const std::vector<double>& T, int derivative) {
      std::vector<double> at = T;
      if (const FaceConduction& faces = *scheme.conduction; !faces.is_nodal()) {
        at.resize(faces.rows().conduction.x.size());
        faces.rows().conduction.phi.apply(T, at);
      }
      for (double& v : at)
        v = derivative < 0 ? 2 * v + v * v / 2 + v * v * v / 30 : derivative == 0 ? 2 + v + v * v / 10 : 1 + v / 5;
      return at;
    };
    const auto rate = [&](const std::vector<double>& T, Mean mean) {
      const auto k = property(T, 0), theta = property(T, -1);
      std::vector<double> F(cloud.owned);
      scheme.conduction->add_rate({.mean = mean, .k = k, .dk_dT = {}, .theta = theta}, T, F);
      return F;
    };
    std::vector<double> T(n);
    Vector step(n);
    for (int i = 0; i < n; ++i) T[i] = 1 + 0.3 * std::cos(3.0 * i), step[i] = std::sin(7.0 * i);
    for (const Mean mean : {Mean::integral, Mean::arithmetic, Mean::harmonic}) {
      const auto k = property(T, 0), dk_dT = property(T, 1);
      SparseJacobian J;
      scheme.conduction->add_jacobian({.mean = mean, .k = k, .dk_dT = dk_dT, .theta = {}}, T, J);
      const Vector predicted = J.matrix(n) * step;
      constexpr double e = 1e-5;
      auto more = T, less = T;
      for (int i = 0; i < n; ++i) more[i] += e * step[i], less[i] -= e * step[i];
      const auto F_more = rate(more, mean), F_less = rate(less, mean);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(predicted[i], (F_more[i] - F_less[i]) / (2 * e), 1e-8 * predicted.lpNorm<Eigen::Infinity>());
    }
  });
}

TEST(Mlpg, CellPointsHaveTheVolumeAndTheCentroidOfTheirCells) {
  // Boxes of a lattice: centroids known. On a jittered cloud the sum over all cells is the body's centroid.
  for (const auto& [name, cloud] : clouds()) {
    SCOPED_TRACE(name);
    const CellQuadrature points = gauss_points(cloud);
    ASSERT_EQ(points.x.size(), static_cast<std::size_t>(cloud.owned) << cloud.dimension);
    double volume = 0, exact = 0;
    Vec3 first, middle, low = cloud.x[0], high = low;
    for (const Vec3& x : cloud.x)
      for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], x[a]), high[a] = std::max(high[a], x[a]);
    for (std::size_t q = 0; q < points.x.size(); ++q)
      volume += points.volume[q], first += points.volume[q] * points.x[q];
    for (int i = 0; i < cloud.owned; ++i) exact += cloud.volume[i];
    middle = 0.5 * (low + high);
    EXPECT_NEAR(volume / exact, 1, 1e-13);
    EXPECT_LE(norm((1 / volume) * first - middle), 1e-12);
  }
}

TEST(Mlpg, LatticeCapacityIntegratesLinearFunctionsOverEveryCell) {
  const Cloud cloud = box_cloud({6, 5}, 0.1);
  const MlpgSystem s(cloud, MlpgOptions::defaults(2, true));
  const Vector T = s.at_points([](const Vec3&x) { return 2 + 3 * x.x - x.y; }), E = s.C * T;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 x = cloud.x[i];
    // Centroids of half cells lie a quarter of a spacing inside.
    const auto centre = [](double x, double size) { return x < 0.05 ? 0.025 : x > size - 0.05 ? size - 0.025 : x; };
    EXPECT_NEAR(E[i], cloud.volume[i] * (2 + 3 * centre(x.x, 0.5) - centre(x.y, 0.4)), 1e-15);
  }
}

TEST(Mlpg, VirtualFacesOfNearestNeighboursAreTheFacesOfBoxes) {
  // The edge-stabilised flux across box faces is the seven-point difference.
  const Cloud cloud = box_cloud({5, 6, 4}, 0.1);
  const MlpgSystem s(cloud, options(cloud, MlpgFlux::edge_stabilised));
  std::vector<std::int32_t> buffer;
  for (int i = 0; i < cloud.owned; ++i) {
    if (cloud.on_faces[i] != 0) continue;
    EXPECT_NEAR(s.K.coeff(i, i), 6 * 0.1, 1e-14);
    EXPECT_EQ(s.scheme.conduction->coupled(i, buffer).size(), 6u);
  }
  EXPECT_TRUE(s.scheme.conduction->traits().is_symmetric);
}

TEST(MlpgParallel, DoesNotDependOnTheNumberOfRanks) {
  auto parts = clouds(MPI_COMM_WORLD), whole = clouds();
  for (std::size_t c = 0; c < parts.size(); ++c) {
    for (const MlpgFlux flux : {MlpgFlux::parameters, MlpgFlux::edge_stabilised}) {
      SCOPED_TRACE(parts[c].name);
      std::vector<double> squares[2];
      for (const int w : {0, 1}) {
        const Cloud& cloud = w == 0 ? parts[c].cloud : whole[c].cloud;
        MlpgReport report;
        const auto scheme = mlpg_scheme(cloud, options(cloud, flux), report);
        const std::vector<double> k = everywhere(cloud, *scheme.conduction, 2);
        std::vector<double> T, F(cloud.owned);
        for (int i = 0; i < cloud.local(); ++i)
          T.push_back(300 + 50 * std::cos(3.0 * static_cast<double>(cloud.id[i])));
        scheme.conduction->add_rate({.k = k, .dk_dT = {}, .theta = {}}, T, F);
        for (int i = 0; i < cloud.owned; ++i) squares[w].push_back(F[i] * F[i]);
        if (const auto& cells = scheme.conduction->rows().cells)
          for (std::size_t q = 0; q < cells->x.size(); ++q)
            squares[w].push_back(std::pow(cells->volume[q] * cells->phi.times(q, T), 2));
      }
      EXPECT_EQ(sum(MPI_COMM_WORLD, squares[0]), sum(MPI_COMM_SELF, squares[1]));
    }
  }
}

}  // namespace
}  // namespace calor
