// Bodies whose points a file gives, and bodies that are their own mirror images.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "case_models.hpp"

namespace calor {
namespace {

struct GivenBody {
  std::string name, spacing, parts;
};

const std::vector<GivenBody> bodies = {{"plate with a hole", "0.13 m", R"(
[[cloud.part]]
shape = "rectangle"
size  = ["1 m", "0.7 m"]
[[cloud.part]]
shape   = "disc"
combine = "cut"
radius  = "0.2 m"
at      = ["0.45 m", "0.35 m"]
)"},
                                       {"tube", "0.22 m", R"(
[[cloud.part]]
shape  = "tube"
inner  = "0.4 m"
outer  = "0.9 m"
height = "0.8 m"
)"}};

/// T = 1 + 2 x - 3 y + 0.5 z, held on all walls; `points`: the line that makes or gives them.
std::string linear_case(const GivenBody& body, const std::string& points, const std::string& method) {
  return "title = \"t\"\nmethod = \"" + method + "\"\n[cloud]\nshape = \"surface\"\n" + points + body.parts +
         simple_material({.k = "2"}) +
         "[boundary.walls]\nwhere = \"1\"\ntemperature = { formula = \"101 + 2*x - 3*y + 0.5*z\", unit = \"K\" "
         "}\n[steady]\ntolerance = 1e-13\n";
}

class GivenPoints : public testing::TestWithParam<std::string> {};

TEST_P(GivenPoints, GetVolumesAndAreasOnWhichLinearTemperaturesAreExact) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / ("given-" + GetParam() + ".csv");
  for (const GivenBody& body : bodies) {
    SCOPED_TRACE(body.name);
    const CaseModel made(linear_case(body, "spacing = \"" + body.spacing + "\"\n", GetParam()));
    {
      std::ofstream out(file);
      out.precision(17);
      out << "x [m],y [m],z [m]\n";
      for (const Vec3& x : made.cloud().x) out << x.x << ',' << x.y << ',' << x.z << '\n';
    }
    const CaseModel given(linear_case(body, "points = \"" + file.string() + "\"\n", GetParam()));
    const Cloud& cloud = given.cloud();
    ASSERT_EQ(cloud.count, made.cloud().count);
    const CloudCheck is = check(cloud);
    EXPECT_LE(is.volume_error, 1e-12);
    EXPECT_LE(is.area_sum, 1e-14);
    EXPECT_LE(is.moment_sum, 1e-14);
    for (int i = 0; i < cloud.owned; ++i)  // in the order of the file
      EXPECT_EQ(norm(cloud.x[i] - made.cloud().x[cloud.id[i]]), 0);
    State state = given.steady();
    const std::vector<double> T = given.system().temperatures(state.T);
    for (int i = 0; i < cloud.owned; ++i) {
      const Vec3& x = cloud.x[i];
      EXPECT_NEAR(T[i], 101 + 2 * x.x - 3 * x.y + 0.5 * x.z, 1e-10);
    }
  }
}

/// Two plates and a fillet on either side of the upright one, which is heated from its head.
std::string t_joint(const std::string& method) {
  return "title = \"t\"\nmethod = \"" + method + R"toml("
[cloud]
shape    = "surface"
spacing  = "8 mm"
symmetry = "x"
[[cloud.part]]
shape  = "extrusion"
x      = ["-32 mm", "32 mm", "32 mm", "12 mm", "4 mm", "4 mm", "-4 mm", "-4 mm", "-12 mm", "-32 mm"]
y      = ["0 mm", "0 mm", "8 mm", "8 mm", "16 mm", "40 mm", "40 mm", "16 mm", "8 mm", "8 mm"]
height = "60 mm"
[material.steel]
library = "carbon steel EN 1993-1-2"
[initial]
temperature = "293 K"
[boundary.head]
where       = "y > 0.0399"
temperature = "900 K"
[boundary.air]
where      = "y < 0.0399"
convection = { h = "10 W/(m^2 K)", ambient = "293 K" }
[time]
end        = "30 s"
integrator = "rkl2"
[output]
fields = false
[probe]
right = ["8 mm", "10 mm", "30 mm"]
left  = ["-8 mm", "10 mm", "30 mm"]
far   = ["28 mm", "3 mm", "41 mm"]
far_left = ["-28 mm", "3 mm", "41 mm"]
)toml";
}

TEST_P(GivenPoints, OfABodyThatIsItsOwnImageAreImagesOfEachOther) {
  const CaseModel m(t_joint(GetParam()));
  const Cloud& cloud = m.cloud();
  const CloudCheck is = check(cloud);
  EXPECT_LE(is.volume_error, 1e-12);
  EXPECT_LE(is.area_sum, 1e-14);
  int beside = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 image{-cloud.x[i].x, cloud.x[i].y, cloud.x[i].z};
    int found = -1;
    for (int j = 0; j < cloud.owned; ++j)
      if (norm(cloud.x[j] - image) < 1e-15) found = j;
    ASSERT_GE(found, 0);
    beside += found != i;
    EXPECT_NEAR(cloud.volume[found], cloud.volume[i], 1e-14 * cloud.volume[i]);
    EXPECT_NEAR(cloud.area[found].x, -cloud.area[i].x, 1e-18);
    EXPECT_NEAR(cloud.area[found].y, cloud.area[i].y, 1e-18);
  }
  EXPECT_GT(beside, cloud.owned / 2);

  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / ("t-joint-" + GetParam());
  run_into(folder.string(), t_joint(GetParam()));
  std::ifstream in(folder / "probes.csv");
  std::string line, last;
  while (std::getline(in, line)) last = line;
  double t = 0, right = 0, left = 0, far = 0, far_left = 0;
  ASSERT_EQ(std::sscanf(last.c_str(), "%lf,%lf,%lf,%lf,%lf", &t, &right, &left, &far, &far_left), 5) << last;
  EXPECT_GT(right, 295);
  EXPECT_NEAR(right, left, 1e-10 * right);
  EXPECT_NEAR(far, far_left, 1e-10 * far);
}

INSTANTIATE_TEST_SUITE_P(Methods, GivenPoints, testing::Values("sph", "peridynamics", "mlpg"));

TEST(PointsOfAFile, OutsideTheBodyAreRefusedWithTheirLine) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "outside.csv";
  std::ofstream(file) << "x [m],y [m]\n0,0\n1,0\n1,0.7\n0,0.7\n0.1,0.1\n1.2,0.3\n";
  expect_refused(linear_case(bodies[0], "points = \"" + file.string() + "\"\n", "sph"),
                 {"outside.csv:7", "(1.2, 0.3, 0) m lies outside the body, 0.2 m from its surface"});
}

}  // namespace
}  // namespace calor
