// STEP files, where the program gmsh is installed.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "case_models.hpp"
#include "errors.hpp"
#include "surface/surface_files.hpp"

namespace calor {
namespace {

const std::string pipe = std::string(CALOR_SOURCE_DIR) + "/tests/drawings/lined-pipe.step";

class Drawings : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("gmsh --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "gmsh is not installed";
  }
};

TEST_F(Drawings, GiveTheirSolidsInMetresWithTheFaceBetweenThemInBoth) {
  std::vector<Surface> solids = read_drawing(pipe, {}, 1e-3);
  ASSERT_EQ(solids.size(), 2u);
  const double inner = 3e-3, outer = 8e-3, height = 10e-3, pi = std::numbers::pi;
  double volume[2];
  for (int n = 0; n < 2; ++n) {
    weld(solids[n], 1e-12);
    orient(solids[n]);
    EXPECT_NO_THROW(require_closed(solids[n], {}));
    volume[n] = enclosed_volume(solids[n]);
  }
  // Chords of 1 mm lose c^2 / (6 r^2) of a disc at most.
  EXPECT_NEAR(volume[1], pi * inner * inner * height, 0.02 * pi * inner * inner * height);
  EXPECT_NEAR(volume[0] + volume[1], pi * outer * outer * height, 0.003 * pi * outer * outer * height);
}

TEST_F(Drawings, MakeBodiesOfPartsThatConductIntoEachOther) {
  const std::string file = "file = \"" + pipe + "\"\n";
  const CaseModel m(
      "title = \"pipe\"\nmethod = \"sph\"\n[cloud]\nshape = \"surface\"\nspacing = \"2 mm\"\n"
      "[[cloud.part]]\nname = \"pipe\"\nsolid = \"1\"\n" +
      file + "[[cloud.part]]\nname = \"core\"\nsolid = \"2\"\n" + file +
      "[material.a]\nconductivity = \"1 W/(m K)\"\n[material.b]\nconductivity = \"1 W/(m K)\"\n"
      "[[body.region]]\ntag = \"pipe\"\nmaterial = \"a\"\n[[body.region]]\ntag = \"core\"\nmaterial = \"b\"\n"
      "[boundary.low]\nwhere = \"z < 1e-6\"\ntemperature = \"0 K\"\n"
      "[boundary.high]\nwhere = \"z > 0.01 - 1e-6\"\ntemperature = \"10 K\"\n[steady]\ntolerance = 1e-12\n");
  State state = m.steady();
  const std::vector<double> T = m.system().temperatures(state.T);
  // The triangles of gmsh on the insulated round wall lean out of the vertical, one way and the other.
  for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(T[i], 1000 * m.cloud().x[i].z, 1e-3);
}

TEST(DrawingFiles, AreRefusedWhereTheyAreNone) {
  expect_error([] { read_drawing(CALOR_SOURCE_DIR "/README.md", {}, 1); },
               {"README.md", "is no STEP and no BREP file"});
}

}  // namespace
}  // namespace calor
