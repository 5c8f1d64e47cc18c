// The [cloud] table of a case.
#include "cloud/cloud.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/points.hpp"
#include "errors.hpp"

namespace calor {
namespace {

const Schema& keys() {
  static const Schema all = [] {
    Schema s;
    declare_case(s);
    declare_cloud(s);
    s.add({.path = "material.*", .sentence = "", .keys = {}});
    return s;
  }();
  return all;
}

Cloud cloud_of(const std::string& table) {
  return make_cloud(MPI_COMM_SELF,
                    Case::parse("title = \"t\"\n[cloud]\n" + table + "\n[material.any]\n", "t.toml", keys()), 2);
}

std::string refusal(const std::string& table) {
  const Error e = error_of([&] { cloud_of(table); });
  EXPECT_EQ(e.fault(), Fault::bad_case) << e.what();
  EXPECT_FALSE(e.cure().empty());
  return e.what();
}

testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != text.npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << '"' << text << "\" does not contain \"" << part << '"';
}

TEST(CloudOfACase, IsABoxOfTheGivenPoints) {
  const Cloud c =
      cloud_of("shape = \"box\"\nsize = [\"4 m\", \"200 cm\"]\npoints = [5, 3]\norigin = [\"1 m\", \"0 m\"]");
  EXPECT_EQ(c.dimension, 2);
  EXPECT_EQ(c.count, 15);
  EXPECT_EQ(c.x[0], (Vec3{1, 0, 0}));
  EXPECT_EQ(c.x[14], (Vec3{5, 2, 0}));
  EXPECT_DOUBLE_EQ(check(c).volume, 8);
  EXPECT_EQ(c.faces, (std::vector<std::string>{"xmin", "xmax", "ymin", "ymax"}));
  EXPECT_TRUE(c.box_lattice);
}

TEST(CloudOfACase, TakesASpacingInsteadOfPoints) {
  EXPECT_EQ(cloud_of("shape = \"box\"\nsize = [\"1 m\"]\nspacing = \"10 cm\"").count, 11);
  EXPECT_EQ(cloud_of("shape = \"box\"\nat = \"cells\"\nsize = [\"1 m\"]\nspacing = \"10 cm\"").count, 10);
  EXPECT_EQ(cloud_of("shape = \"disc\"\nradius = \"1 m\"\nspacing = \"50 cm\"").count, 1 + 6 + 12);
  EXPECT_EQ(cloud_of("shape = \"cylinder\"\nradius = \"1 m\"\nheight = \"1 m\"\nspacing = \"50 cm\"").count, 3 * 19);
}

TEST(CloudOfACase, CountsThicknessAndSectionInVolumesAndAreas) {
  const Cloud plate = cloud_of("shape = \"box\"\nsize = [\"1 m\", \"2 m\"]\npoints = [3, 5]\nthickness = \"10 cm\"");
  EXPECT_DOUBLE_EQ(check(plate).volume, 0.2);
  double xmin = 0;
  for (const Facet& p : plate.facets) xmin += p.face == 0 ? p.area : 0;
  EXPECT_DOUBLE_EQ(xmin, 0.2);  // 2 m long, 0.1 m thick
  const Cloud bar = cloud_of("shape = \"box\"\nsize = [\"1 m\"]\npoints = [3]\nsection = \"1 cm^2\"");
  EXPECT_DOUBLE_EQ(check(bar).volume, 1e-4);
  EXPECT_DOUBLE_EQ(bar.facets[0].area, 1e-4);
  const Cloud disc = cloud_of("shape = \"disc\"\nradius = \"1 m\"\nrings = 4\nthickness = \"25 cm\"");
  EXPECT_NEAR(check(disc).volume, std::numbers::pi / 4, 1e-14);
}

TEST(CloudOfACase, RefusesWhatTheDimensionDoesNotHave) {
  const std::string solid = "shape = \"box\"\nsize = [\"1 m\", \"1 m\", \"1 m\"]\npoints = [2, 2, 2]\n";
  EXPECT_TRUE(contains(refusal(solid + "thickness = \"1 m\""), "t.toml:6"));
  EXPECT_TRUE(contains(refusal(solid + "section = \"1 m^2\""), "no cross-section"));
  EXPECT_TRUE(
      contains(refusal("shape = \"disc\"\nradius = \"1 m\"\nrings = 3\nsection = \"1 m^2\""), "no cross-section"));
  EXPECT_TRUE(contains(refusal("shape = \"box\"\nsize = [\"1 m\", \"1 m\"]\npoints = [2, 2]\nthickness = \"0 m\""),
                       "not positive"));
}

TEST(CloudOfACase, NamesTheNearestSpacingsThatDivideALength) {
  const std::string text = refusal("shape = \"box\"\nsize = [\"1 m\", \"1 m\"]\nspacing = \"0.3 m\"");
  EXPECT_TRUE(contains(text, "t.toml:5"));
  EXPECT_TRUE(contains(text, "0.3333333333 m or 0.25 m"));
}

TEST(CloudOfACase, RefusesNumbersThatMakeNoCloud) {
  const auto box = [](const std::string& rest) { return refusal("shape = \"box\"\n" + rest); };
  EXPECT_TRUE(contains(box("size = [\"1 m\"]"), "neither points nor spacing"));
  EXPECT_TRUE(contains(box("size = [\"1 m\"]\npoints = [3]\nspacing = \"0.5 m\""), "both points and spacing"));
  EXPECT_TRUE(contains(box("size = [\"1 m\", \"1 m\"]\npoints = [3]"), "1 value for 2 axes"));
  EXPECT_TRUE(contains(box("size = [\"1 m\", \"1 m\"]\npoints = [3, 1]"), "1 point along y"));
  EXPECT_TRUE(contains(box("size = [\"-1 m\"]\npoints = [3]"), "not positive"));
  EXPECT_TRUE(contains(box("size = []\npoints = [3]"), "size"));
  EXPECT_TRUE(contains(box("size = [\"1 m\"]\npoints = [3]\norigin = [\"1 m\", \"1 m\"]"), "2 values for 1 axis"));
  EXPECT_TRUE(contains(box("size = [\"1 m\"]\npoints = [3]\njitter = 0.5"), "below 0.5"));
  EXPECT_TRUE(contains(box("size = [\"1 m\", \"1 m\"]\npoints = [100000, 1000000]"), "too many"));
  EXPECT_TRUE(contains(refusal("shape = \"disc\"\nradius = \"1 m\"\nrings = 0"), "at least 1"));
  EXPECT_TRUE(contains(refusal("shape = \"disc\"\nradius = \"0 m\"\nrings = 2"), "not positive"));
  EXPECT_TRUE(contains(refusal("shape = \"disc\"\nradius = \"1 m\""), "neither rings nor spacing"));
  const std::string cylinder = "shape = \"cylinder\"\nradius = \"1 m\"\nrings = 2\n";
  EXPECT_TRUE(contains(refusal(cylinder + "height = \"1 m\"\nlevels = 1"), "at least 2"));
  EXPECT_TRUE(contains(refusal(cylinder + "height = \"1 m\""), "levels"));
  EXPECT_TRUE(contains(refusal(cylinder + "height = \"0 m\"\nlevels = 2"), "not positive"));
}

TEST(CloudCheckParallel, SeesAreasThatDoNotCloseTheBody) {
  Points p;
  p.dimension = 2;
  p.faces = {"a"};
  p.exact.volume = 3;
  if (slice(MPI_COMM_WORLD, 1).end == 1 && slice(MPI_COMM_WORLD, 1).begin == 0) {
    for (std::int64_t i = 0; i < 4; ++i) {
      p.points.push_back(
          {.id = i, .x = {double(i % 2), double(i / 2), 0}, .volume = 1, .full_volume = 1, .spacing = 1});
      p.add_patch(0, 1, {1, 0, 0});
    }
  }
  const CloudCheck c = check(distribute(MPI_COMM_WORLD, std::move(p), 2));
  EXPECT_DOUBLE_EQ(c.volume, 4);
  EXPECT_DOUBLE_EQ(c.volume_error, 1.0 / 3);
  EXPECT_DOUBLE_EQ(c.area_sum, 1);
  EXPECT_NEAR(c.moment_sum, 0, 1e-15);  // about the middle
}

}  // namespace
}  // namespace calor
