// Mirror images beyond plane walls: the lists, the correction of their weights, and the heat that passes to them.
#include "conduction/mirror_images.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "app/model.hpp"
#include "app/schema.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "conduction/correction.hpp"
#include "conduction/peridynamics.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

constexpr std::uint32_t all_faces = 0b111111;

/// Every set of walls that an image can lie across, the empty one included.
std::vector<std::uint32_t> sets_of(const Cloud& cloud, std::uint32_t faces) {
  std::vector<std::uint32_t> sets;
  for (std::uint32_t set = 0; set < 1u << cloud.faces.size(); ++set)
    if ((set & ~faces) == 0 && !has_opposite_walls(set)) sets.push_back(set);
  return sets;
}

TEST(MirrorImages, AreFoundByTheListsAsByBruteForce) {
  for (const auto& points : {std::vector<std::int64_t>{9}, {7, 8}, {6, 5, 6}}) {
    for (const std::uint32_t faces : {0b1u, 0b110u, (1u << 2 * points.size()) - 1}) {
      if (faces >> 2 * points.size()) continue;
      const Cloud cloud = box_cloud(points, 0.1, {.jitter = 0.2, .on_walls = false});
      const Neighbours found = find_neighbours(cloud, 2.5, faces);
      const auto mirrors = mirrors_of(cloud.walls);
      std::int64_t expected = 0, images = 0;
      for (int i = 0; i < cloud.owned; ++i) {
        for (const std::uint32_t set : sets_of(cloud, faces)) {
          for (int j = 0; j < cloud.owned; ++j) {
            if (set == 0 && i == j) continue;
            expected += norm(mirrors[set].point(cloud.x[j]) - cloud.x[i]) < 0.25 * (1 - 1e-9);
          }
        }
        for (auto n = found.row[i]; n < found.row[i + 1]; ++n) {
          images += found.is_image(n);
          EXPECT_LT(norm(found.x_ji(cloud.x, i, n)), 0.25);
        }
      }
      EXPECT_EQ(static_cast<std::int64_t>(found.column.size()), expected);
      EXPECT_GT(images, 0);
    }
  }
}

TEST(MirrorImages, OfImagesAreRefused) {
  const Cloud thin = box_cloud({9, 2}, 0.1, {.on_walls = false});
  EXPECT_NO_THROW(find_neighbours(thin, 3.5, 0b0111));
  try {
    find_neighbours(thin, 3.5, 0b1100);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::bad_case);
    EXPECT_NE(e.problem().find("between ymin and ymax"), std::string::npos) << e.problem();
  }
  EXPECT_NO_THROW(find_neighbours(box_cloud({9, 3}, 0.1, {.on_walls = false}), 3.5, 0b1111));
}

/// Weight by (point, set of walls, point) in ids.
using WeightsById = std::map<std::tuple<std::int64_t, int, std::int64_t>, double>;

WeightsById by_id(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G) {
  WeightsById weights;
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
      weights[{cloud.id[i], neighbours.image[n], cloud.id[neighbours.column[n]]}] = G[n];
  return weights;
}

TEST(MirrorImages, HaveSymmetricConsistentWeightsOnJitteredClouds) {
  for (const auto& points : {std::vector<std::int64_t>{12}, {9, 8}, {7, 6, 6}}) {
    for (const std::uint32_t faces : {0b1u, 0b10u, 0b11u, 0b101u, 0b1111u, 0b110100u, all_faces}) {
      if (faces != all_faces && faces >> 2 * points.size()) continue;
      SCOPED_TRACE(testing::Message() << points.size() << "D, faces " << faces);
      const Cloud cloud = box_cloud(points, 0.1, {.jitter = 0.2, .on_walls = false});
      const Neighbours neighbours = find_neighbours(cloud, 2.5, faces & ((1u << 2 * points.size()) - 1));
      CorrectionReport report;
      const auto G = consistent_weights(
          cloud, neighbours, [&] { return base_weights(cloud, neighbours, {.horizon = 2}); }, {}, report);
      EXPECT_LE(report.residual, 1e-12);
      const WeightsById weights = by_id(cloud, neighbours, G);
      int different = 0;
      for (const auto& [pair, weight] : weights) {
        const auto& [i, set, j] = pair;
        different += weights.at({j, set, i}) != weight;
      }
      EXPECT_EQ(different, 0);
    }
  }
}

TEST(MirrorImages, MakeEveryPointOfALatticeAnInnerOne) {
  for (const auto& points : {std::vector<std::int64_t>{5}, {4, 5}, {3, 4, 3}}) {
    const Cloud cloud = box_cloud(points, 0.1, {.on_walls = false});
    const std::uint32_t faces = (1u << 2 * points.size()) - 1;
    const Neighbours neighbours = find_neighbours(cloud, 2.5, faces);
    CorrectionReport report;
    const auto G = consistent_weights(
        cloud, neighbours, [&] { return base_weights(cloud, neighbours, {.horizon = 2}); }, {}, report);
    // The same weight for the same distance, everywhere.
    std::map<long, double> at;
    for (int i = 0; i < cloud.owned; ++i) {
      EXPECT_EQ(neighbours.of(i).size(), neighbours.of(0).size());
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const Vec3 r = neighbours.x_ji(cloud.x, i, n);
        const auto [known, is_new] = at.try_emplace(std::lround(dot(r, r) * 100), G[n]);
        EXPECT_NEAR(G[n], known->second, 1e-12 * std::abs(known->second));
      }
    }
    EXPECT_EQ(report.negative, 0);
  }
}

TEST(MirrorImages, LeaveTheExactLatticeWeightsOfSphAsTheyAre) {
  // Even images folded back are what the shortcut for cell-centred lattices does by itself.
  for (const auto& points : {std::vector<std::int64_t>{6}, {5, 4}, {4, 3, 5}}) {
    const Cloud cloud = box_cloud(points, 0.1, {.on_walls = false});
    const Weights plain = sph_weights(cloud, 1);
    MirroredNeighbours mirrored = find_mirrored_neighbours(cloud, sph_support(1), {}, true);
    EXPECT_FALSE(mirrored.walls.empty());
    CorrectionReport report;
    auto G = sph_consistent_weights(cloud, mirrored.neighbours, 1, report);
    EXPECT_TRUE(report.lattice_shortcut);
    const PairTerms folded = fold_images(cloud, Parts(cloud), std::move(mirrored), std::move(G), Layers::odd, {});
    std::vector<double> G_folded;
    PairRows::Row row;
    for (int i = 0; i < cloud.owned; ++i) {
      folded.pairs->rows().read(i, row);
      G_folded.insert(G_folded.end(), row.weight.begin(), row.weight.end());
    }
    ASSERT_EQ(G_folded.size(), plain.G.size());
    for (std::size_t n = 0; n < plain.G.size(); ++n) EXPECT_NEAR(G_folded[n], plain.G[n], 1e-14);
    EXPECT_EQ(folded.images, nullptr);
  }
}

/// A case given as text, as far as its heat system.
struct Built {
  Phases phases;
  Case description;
  Model model;

  explicit Built(const std::string& text, MPI_Comm comm = MPI_COMM_SELF)
      : description(Case::parse(text, "test.toml", schema())), model(build_model(description, comm, phases)) {}
  HeatSystem& system() const { return *model.system; }
  const Cloud& cloud() const { return *model.cloud; }
};

/// Temperatures without any symmetry, around 400 K.
std::vector<double> scattered(const Cloud& cloud) {
  std::vector<double> T;
  for (int i = 0; i < cloud.local(); ++i)
    T.push_back(400 + 100 * std::sin(1.7 + 12.9898 * static_cast<double>(cloud.id[i])));
  return T;
}

std::string walls_case(const std::string& cloud, const std::string& conductivity, const std::string& more) {
  return "title = \"t\"\nmethod = \"peridynamics\"\n[cloud]\nshape = \"box\"\nat = \"cells\"\njitter = 0.2\n" + cloud +
         "[material.m]\ndensity = \"1 kg/m^3\"\nspecific_heat = \"1 J/(kg K)\"\nconductivity = " + conductivity +
         "\n[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n" + more;
}

const std::string square = "size = [\"1 m\", \"0.8 m\"]\npoints = [10, 8]\n";
const std::string cube = "size = [\"1 m\", \"0.8 m\", \"0.9 m\"]\npoints = [5, 4, 5]\n";
const std::string two_walls =
    "[boundary.hot]\non = \"xmax\"\ntemperature = { formula = \"500 + 40*y + 30*t\", unit = \"K\" }\n"
    "[boundary.cold]\non = [\"ymin\", \"zmin\"]\ntemperature = { formula = \"300 + 20*x\", unit = \"K\" }\n"
    "[boundary.air]\non = \"xmin\"\nconvection = { h = \"3 W/(m^2 K)\", ambient = \"350 K\" }\n";
const std::string two_walls_2d =
    "[boundary.hot]\non = \"xmax\"\ntemperature = { formula = \"500 + 40*y + 30*t\", unit = \"K\" }\n"
    "[boundary.cold]\non = \"ymin\"\ntemperature = { formula = \"300 + 20*x\", unit = \"K\" }\n"
    "[boundary.air]\non = \"xmin\"\nconvection = { h = \"3 W/(m^2 K)\", ambient = \"350 K\" }\n";

TEST(MirrorImages, GiveAnExactJacobian) {
  // k(x), k(T) by theta, k(x, T), harmonic mean of k(x, T): central differences of the rate.
  const std::vector<std::string> conductivities = {
      "{ formula = \"1 + x\", unit = \"W/(m K)\" }", "{ formula = \"1 + (T/400)^2\", unit = \"W/(m K)\" }",
      "{ formula = \"1 + x*T/300\", unit = \"W/(m K)\" }",
      "{ formula = \"1 + x*T/300\", unit = \"W/(m K)\" }\n[body]\nconductivity_mean = \"harmonic\""};
  for (const auto& conductivity : conductivities) {
    for (const bool is_cube : {false, true}) {
      SCOPED_TRACE(conductivity);
      const Built built(walls_case(is_cube ? cube : square, conductivity, is_cube ? two_walls : two_walls_2d));
      HeatSystem& system = built.system();
      ASSERT_EQ(system.discretisation().walls.size(), 1u);
      const int N = built.cloud().owned;
      std::vector<double> T = scattered(built.cloud()), plus(N), minus(N), power(system.accounts().size());
      const petsc::Matrix J = system.create_jacobian();
      system.jacobian(0.4, T, 0, 1, J);
      double largest = 0, scale = 0;
      for (int j = 0; j < N; ++j) {
        const double step = 1e-3, T_j = T[j];
        T[j] = T_j + step, system.rate(0.4, T, plus, power);
        T[j] = T_j - step, system.rate(0.4, T, minus, power);
        T[j] = T_j;
        for (PetscInt i = 0; i < N; ++i) {
          const PetscInt column = j;
          double value = 0;
          MatGetValues(J, 1, &i, 1, &column, &value);
          largest = std::max(largest, std::abs(-value - (plus[i] - minus[i]) / (2 * step)));
          scale = std::max(scale, std::abs(value));
        }
      }
      EXPECT_LE(largest, 1e-7 * scale);
    }
  }
}

TEST(MirrorImages, BookTheirHeatToTheBoundaryThatHoldsTheWall) {
  for (const auto& text : {walls_case(square, "{ formula = \"1 + x*T/300\", unit = \"W/(m K)\" }", two_walls_2d),
                           walls_case(cube, "{ formula = \"1 + (T/400)^2\", unit = \"W/(m K)\" }", two_walls)}) {
    const Built built(text);
    HeatSystem& system = built.system();
    std::vector<double> T = scattered(built.cloud()), F(built.cloud().owned), power(system.accounts().size());
    system.rate(0.2, T, F, power);
    double size = 0, in = 0, boundaries = 0;
    for (const double f : F) size += std::abs(f), in += f;
    for (const double p : power) {
      EXPECT_GT(std::abs(p), 1e-4 * size);
      boundaries += p;
    }
    EXPECT_NEAR(in, boundaries, 1e-13 * size);
  }
}

TEST(MirrorImages, ContinueFieldsLinearInEveryCoordinateExactly) {
  // T = (1 + x)(2 + y)(3 - z) on all walls: at rest in the whole body, edges and corners included.
  const std::string wall = "{ formula = \"100*(1+x)*(2+y)*(3-z)\", unit = \"K\" }";
  const Built built(
      "title = \"t\"\nmethod = \"peridynamics\"\n[cloud]\nshape = \"box\"\nat = \"cells\"\nsize = [\"1 m\", \"1 m\", "
      "\"1 m\"]\n"
      "points = [5, 4, 6]\n[material.m]\nconductivity = \"1 W/(m K)\"\n[steady]\n[boundary.all]\non = "
      "[\"xmin\", \"xmax\", \"ymin\", \"ymax\", \"zmin\", \"zmax\"]\ntemperature = " +
      wall);
  const Cloud& cloud = built.cloud();
  std::vector<double> T, F(cloud.owned), power(1);
  for (const Vec3& x : cloud.x) T.push_back(100 * (1 + x.x) * (2 + x.y) * (3 - x.z));
  built.system().rate(0, T, F, power);
  for (const double f : F) EXPECT_NEAR(f, 0, 1e-10);
}

TEST(MirrorImages, StandEvenOnOneSideOfAWallAndOddOnTheOther) {
  // A wall of prescribed temperature up to y = 0.42, insulated beyond: bonds of both kinds cross it, and the matrix
  // stays symmetric.
  for (const char* method : {"sph", "peridynamics"}) {
    std::string text = walls_case(square, "\"2 W/(m K)\"",
                                  "[boundary.part]\non = \"xmin\"\nwhere = \"y < 0.42\"\ntemperature = \"500 K\"\n");
    text.replace(text.find("peridynamics"), 12, method);
    const Built built(text);
    HeatSystem& system = built.system();
    const petsc::Matrix J = system.create_jacobian();
    std::vector<double> T = scattered(built.cloud()), F(built.cloud().owned), power(1);
    system.jacobian(0, T, 0, 1, J);
    PetscBool symmetric = PETSC_FALSE;
    MatIsSymmetric(J, 0, &symmetric);
    EXPECT_TRUE(symmetric);
    system.rate(0, T, F, power);
    double in = 0, size = 0;
    for (const double f : F) in += f, size += std::abs(f);
    EXPECT_NEAR(in, power[0], 1e-13 * size);
    // Heat comes in next to the prescribed part alone.
    const ImageBonds& bonds = dynamic_cast<const ImageConduction&>(*system.discretisation().walls.at(0)).bonds();
    for (const int i : bonds.point) EXPECT_LT(built.cloud().x[i].y, 0.42 + 0.26);
  }
}

TEST(MirrorImages, BoundTheStepOfExplicitEuler) {
  for (const auto& more :
       {two_walls_2d, std::string("[peridynamics]\ncorrection = \"paper\"\nhorizon = 3.015\n") + two_walls_2d}) {
    const Built built(walls_case(square, "{ formula = \"1 + x\", unit = \"W/(m K)\" }", more));
    std::vector<double> T = scattered(built.cloud());
    const double bound = built.system().rate_bound(0, T), largest = built.system().largest_rate(0, T);
    EXPECT_LE(largest, bound);
    EXPECT_GE(largest, 0.5 * bound);
  }
}

TEST(MirrorImages, AreNotForCurvedWalls) {
  Cloud cloud = box_cloud({4, 4}, 0.1, {.on_walls = false});
  cloud.walls.clear();
  const Case c = Case::parse(
      "title = \"t\"\nmethod = \"sph\"\n[boundary.xmin]\ntemperature = \"1 K\"\n[steady]\n[material.m]\n"
      "conductivity = \"1 W/(m K)\"\n[cloud]\nshape = \"box\"\nsize = \"1 m\"\n",
      "test.toml", schema());
  // Their facets are held, by the layer before each.
  const Conditions conditions = make_conditions(c, cloud);
  EXPECT_TRUE(conditions.temperatures[0].point.empty());
  EXPECT_EQ(conditions.temperatures[0].facet.size(), 4u);
}

TEST(MirrorImagesParallel, GiveTheSameBitsOnAnyNumberOfRanks) {
  const auto rate_of = [](MPI_Comm comm, std::map<std::int64_t, double>& F_of, double& bound) {
    const Built built(walls_case(cube, "{ formula = \"1 + x*T/300\", unit = \"W/(m K)\" }", two_walls), comm);
    const Cloud& cloud = built.cloud();
    std::vector<double> T = scattered(cloud), F(cloud.owned), power(3);
    built.system().rate(0.3, T, F, power);
    bound = built.system().rate_bound(0.3, T);
    for (int i = 0; i < cloud.owned; ++i) F_of[cloud.id[i]] = F[i];
  };
  std::map<std::int64_t, double> alone, split;
  double bound_alone = 0, bound_split = 0;
  rate_of(MPI_COMM_SELF, alone, bound_alone);
  rate_of(MPI_COMM_WORLD, split, bound_split);
  for (const auto& [id, F] : split) EXPECT_EQ(F, alone.at(id));
  EXPECT_EQ(bound_alone, bound_split);
}

}  // namespace
}  // namespace calor
