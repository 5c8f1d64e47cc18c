// Linear temperatures are exact on bodies of any shape, by all methods.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "case_models.hpp"

namespace calor {
namespace {

struct Shape {
  std::string name, spacing, parts;
};

/// Lengths in m unless a part says so.
std::vector<Shape> shapes() {
  const std::string ell =
      "x = [\"0 m\", \"2 m\", \"2 m\", \"1 m\", \"1 m\", \"0 m\"]\ny = [\"0 m\", \"0 m\", \"1 m\", \"1 m\", \"2 m\", "
      "\"2 m\"]\n";
  const std::string hole =
      "[[cloud.part.hole]]\nx = [\"0.3 m\", \"0.7 m\", \"0.5 m\"]\ny = [\"0.3 m\", \"0.3 m\", \"0.8 m\"]\n";
  const auto part = [](const std::string& shape, const std::string& keys) {
    return "[[cloud.part]]\nshape = \"" + shape + "\"\n" + keys;
  };
  return {
      {"rectangle", "0.13 m", part("rectangle", "size = [\"1 m\", \"0.7 m\"]\n")},
      {"turned rectangle", "0.1 m", part("rectangle", "size = [\"1 m\", \"0.7 m\"]\nturn = \"17 deg\"\n")},
      {"L", "0.17 m", part("polygon", ell)},
      {"L with a hole", "0.11 m", part("polygon", ell + hole)},
      {"sharp triangle", "0.1 m",
       part("polygon", "x = [\"0 m\", \"2 m\", \"2 m\"]\ny = [\"0 m\", \"0 m\", \"0.5 m\"]\n")},
      {"notch", "0.1 m",
       part("polygon",
            "x = [\"0 m\", \"1 m\", \"0.5 m\", \"1 m\", \"0 m\"]\n"
            "y = [\"0 m\", \"0 m\", \"0.5 m\", \"1 m\", \"1 m\"]\n")},
      {"thin strip", "0.1 m", part("rectangle", "size = [\"1 m\", \"0.21 m\"]\n")},
      {"disc", "0.15 m", part("disc", "radius = \"1 m\"\n")},
      {"annulus", "0.15 m", part("annulus", "inner = \"0.4 m\"\nouter = \"1 m\"\n")},
      {"sector", "0.1 m", part("sector", "inner = \"0.3 m\"\nouter = \"1 m\"\nfrom = \"0 deg\"\nto = \"250 deg\"\n")},
      {"two discs", "0.2 m",
       part("disc", "radius = \"0.9 m\"\n") + part("disc", "radius = \"0.9 m\"\nat = [\"2 m\", \"0 m\"]\n")},
      {"box", "0.26 m", part("box", "size = [\"1 m\", \"0.8 m\", \"0.7 m\"]\n")},
      {"turned box", "0.23 m",
       part("box", "size = [\"1 m\", \"0.8 m\", \"0.7 m\"]\nturn = [\"10 deg\", \"20 deg\", \"30 deg\"]\n")},
      {"cylinder", "0.25 m", part("cylinder", "radius = \"0.7 m\"\nheight = \"1 m\"\n")},
      {"tube", "0.22 m", part("tube", "inner = \"0.4 m\"\nouter = \"0.9 m\"\nheight = \"0.8 m\"\n")},
      {"cone", "0.22 m", part("cone", "bottom_radius = \"0.9 m\"\ntop_radius = \"0.4 m\"\nheight = \"1 m\"\n")},
      {"cone with its tip", "0.2 m", part("cone", "bottom_radius = \"0.9 m\"\nheight = \"1.2 m\"\n")},
      {"cone with a sharp tip", "0.2 m", part("cone", "bottom_radius = \"0.9 m\"\nheight = \"2.4 m\"\n")},
      {"prism of 27 degrees", "0.1 m",
       part("extrusion", "x = [\"0 m\", \"1 m\", \"0 m\"]\ny = [\"0 m\", \"0 m\", \"0.5 m\"]\nheight = \"0.8 m\"\n")},
      {"sphere", "0.27 m", part("sphere", "radius = \"1 m\"\n")},
      {"shell", "0.25 m", part("shell", "inner = \"0.5 m\"\nouter = \"1 m\"\n")},
      {"ellipsoid", "0.22 m", part("ellipsoid", "semi_axes = [\"1 m\", \"0.6 m\", \"0.5 m\"]\n")},
      {"extruded L with a hole", "0.22 m", part("extrusion", ell + "height = \"0.6 m\"\n" + hole)},
      {"ring of a rectangle", "0.2 m",
       part("revolution",
            "r = [\"0.5 m\", \"1 m\", \"1 m\", \"0.5 m\"]\nz = [\"0 m\", \"0 m\", \"0.5 m\", \"0.5 m\"]\n")},
      {"quarter of a ring", "0.17 m",
       part("revolution",
            "r = [\"0.5 m\", \"1 m\", \"1 m\", \"0.5 m\"]\nz = [\"0 m\", \"0 m\", \"0.5 m\", \"0.5 m\"]\n"
            "angle = \"90 deg\"\n")},
      {"plate with a hole cut through", "0.13 m",
       part("rectangle", "size = [\"1 m\", \"0.7 m\"]\n") +
           part("disc", "combine = \"cut\"\nradius = \"0.2 m\"\nat = [\"0.45 m\", \"0.35 m\"]\n")},
      {"discs that overlap", "0.2 m",
       part("disc", "radius = \"0.9 m\"\n") + part("disc", "radius = \"0.9 m\"\nat = [\"1.2 m\", \"0.2 m\"]\n")},
      {"block with a bore", "0.2 m",
       part("box", "size = [\"1 m\", \"0.8 m\", \"0.7 m\"]\n") +
           part("cylinder",
                "combine = \"cut\"\nradius = \"0.2 m\"\nheight = \"2 m\"\nat = [\"0.5 m\", \"0.4 m\", \"-0.5 m\"]\n")},
      {"block with a core and a foot", "0.25 m",
       part("box", "size = [\"1 m\", \"1 m\", \"1 m\"]\n") +
           part("sphere", "radius = \"0.3 m\"\nat = [\"0.5 m\", \"0.5 m\", \"0.5 m\"]\n") +
           part("box", "size = [\"0.6 m\", \"0.5 m\", \"0.4 m\"]\nat = [\"0.1 m\", \"0.2 m\", \"-0.4 m\"]\n")},
      {"what a sphere and a box share", "0.22 m",
       part("sphere", "radius = \"1 m\"\n") + part("box",
                                                   "combine = \"common\"\nsize = [\"1.6 m\", \"1.6 m\", \"1 m\"]\nat = "
                                                   "[\"-0.8 m\", \"-0.8 m\", \"0 m\"]\n")},
  };
}

/// Largest error of T = 1 + 2 x - 3 y + 0.5 z, held on all walls.
double patch_error(const Shape& shape, const std::string& method) {
  const CaseModel m(
      "title = \"patch\"\nmethod = \"" + method + "\"\n[cloud]\nshape = \"surface\"\nspacing = \"" + shape.spacing +
      "\"\n" + shape.parts + simple_material({.k = "2"}) +
      "[boundary.walls]\nwhere = \"1\"\ntemperature = { formula = \"101 + 2*x - 3*y + 0.5*z\", unit = \"K\" "
      "}\n[steady]\ntolerance = 1e-13\n");
  State state = m.steady();
  const std::vector<double> T = m.system().temperatures(state.T);
  double largest = 0;
  for (int i = 0; i < m.cloud().owned; ++i) {
    const Vec3& x = m.cloud().x[i];
    largest = std::max(largest, std::abs(T[i] - (101 + 2 * x.x - 3 * x.y + 0.5 * x.z)));
  }
  return largest;
}

class BodyPatch : public testing::TestWithParam<std::string> {};

TEST_P(BodyPatch, IsExact) {
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    try {
      EXPECT_LE(patch_error(shape, GetParam()), 1e-10);
    } catch (const Error& e) {
      ADD_FAILURE() << e.what();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, BodyPatch, testing::Values("sph", "peridynamics", "mlpg"));

}  // namespace
}  // namespace calor
