// Bodies that are their own images in one plane, two or three: a half, a quarter or an eighth makes all of their
// points.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "case_models.hpp"
#include "cloud/cloud.hpp"

namespace calor {
namespace {

std::string shell(const std::string& symmetry, const std::string& inside = "\"1 K\"",
                  const std::string& outside = "\"0 K\"") {
  return "title = \"a shell\"\nmethod = \"sph\"\n[cloud]\nshape = \"surface\"\nspacing = \"1.3 mm\"\nsymmetry = " +
         symmetry + "\npart = [{ shape = \"shell\", inner = \"3 mm\", outer = \"6 mm\" }]\n" +
         simple_material({.k = "2"}) + "[boundary.inside]\non = \"inner\"\ntemperature = " + inside +
         "\n[boundary.outside]\non = \"outer\"\ntemperature = " + outside + "\n[steady]\ntolerance = 1e-13\n";
}

/// Temperatures of the points of all ranks.
struct Found {
  std::vector<Vec3> x;
  std::vector<double> T, volume;
};
Found solved(const CaseModel& m, MPI_Comm comm) {
  State state = m.steady();
  const std::vector<double> T = m.system().temperatures(state.T);
  const Cloud& cloud = m.cloud();
  const std::span<const Vec3> x = cloud.owned_points();
  return {gather(comm, std::vector<Vec3>(x.begin(), x.end())),
          gather(comm, std::vector<double>(T.begin(), T.begin() + cloud.owned)),
          gather(comm, std::vector<double>(cloud.volume.begin(), cloud.volume.begin() + cloud.owned))};
}

const char* const some_axes[] = {"\"x\"", "[\"x\", \"y\"]", "[\"x\", \"y\", \"z\"]"};

TEST(SymmetryParallel, PointsHaveImagesWithTheSameTemperature) {
  for (int planes = 1; planes <= 3; ++planes) {
    const Found found = solved(CaseModel(shell(some_axes[planes - 1]), MPI_COMM_WORLD), MPI_COMM_WORLD);
    int without = 0;
    for (std::size_t i = 0; i < found.x.size(); ++i) {
      Vec3 image = found.x[i];
      image[planes - 1] = -image[planes - 1];
      std::size_t j = 0;
      while (j < found.x.size() && norm(found.x[j] - image) > 1e-12) ++j;
      if (j == found.x.size()) {
        ++without;
        continue;
      }
      EXPECT_NEAR(found.T[j], found.T[i], 1e-10);
      EXPECT_NEAR(found.volume[j], found.volume[i], 1e-12 * found.volume[i]);
    }
    EXPECT_EQ(without, 0) << some_axes[planes - 1];
  }
}

TEST(SymmetryParallel, FacesThatLieOppositeStayTwo) {
  // T = 300 K + 1000 K/m x between xmin and xmax, which are images of each other; 1e-4 m^2 each.
  for (const char* axes : some_axes) {
    const std::string text = std::string("title = \"a block\"\nmethod = \"sph\"\n[cloud]\nshape = \"surface\"\n") +
                             "spacing = \"2 mm\"\nsymmetry = " + axes +
                             "\npart = [{ shape = \"box\", size = [\"20 mm\", \"10 mm\", \"10 mm\"] }]\n" +
                             simple_material({.k = "2"}) +
                             "[boundary.xmin]\ntemperature = \"300 K\"\n[boundary.hot]\non = \"xmax\"\nflux = \"2 "
                             "kW/m^2\"\n[steady]\ntolerance = 1e-13\n";
    const CaseModel model(text, MPI_COMM_WORLD);
    const Found found = solved(model, MPI_COMM_WORLD);
    for (std::size_t i = 0; i < found.x.size(); ++i) EXPECT_NEAR(found.T[i], 300 + 1000 * found.x[i].x, 1e-8) << axes;
    EXPECT_NEAR(model.system().conditions().areas.at(1), 1e-4, 1e-16) << axes;
  }
}

TEST(SymmetryParallel, AHalfAQuarterAndAnEighthGiveTheWholeBodysAnswer) {
  // T = (a / r) (b - r) / (b - a) between the radii a and b; its range is 1 K, on two or three points across the wall.
  constexpr double a = 3e-3, b = 6e-3;
  for (const char* axes : some_axes) {
    const Found found = solved(CaseModel(shell(axes), MPI_COMM_WORLD), MPI_COMM_WORLD);
    double squares = 0, volume = 0;
    for (std::size_t i = 0; i < found.x.size(); ++i) {
      const double r = norm(found.x[i]), exact = a / r * (b - r) / (b - a);
      squares += found.volume[i] * std::pow(found.T[i] - exact, 2), volume += found.volume[i];
    }
    EXPECT_LE(std::sqrt(squares / volume), 1.2e-2) << axes;
    EXPECT_NEAR(volume, 4 * M_PI / 3 * (b * b * b - a * a * a), 0.02 * volume) << axes;
  }
}

TEST(Symmetry, LinearTemperaturesAreExactAcrossThePlanes) {
  const std::string linear = "{ formula = \"300 + 2*x - 3*y + 0.5*z\", unit = \"K\", length = \"mm\" }";
  for (const char* axes : some_axes) {
    const Found found = solved(CaseModel(shell(axes, linear, linear)), MPI_COMM_SELF);
    for (std::size_t i = 0; i < found.x.size(); ++i) {
      const Vec3& x = found.x[i];
      EXPECT_NEAR(found.T[i], 300 + 2e3 * x.x - 3e3 * x.y + 500 * x.z, 1e-9);
    }
  }
}

}  // namespace
}  // namespace calor
