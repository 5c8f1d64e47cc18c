#include <gtest/gtest.h>

#include <cmath>

#include "base/parallel.hpp"
#include "cloud/cloud.hpp"
#include "cloud/shapes.hpp"
#include "errors.hpp"
#include "results.hpp"

namespace calor {
namespace {

Points read(const std::string& text, double section = 1) {
  const TemporaryFolder folder;
  return read_points(MPI_COMM_SELF, folder.write("cloud.csv", text), [&](int) { return section; });
}

std::string refusal(const std::string& text) {
  const TemporaryFolder folder;
  const std::string file = folder.write("cloud.csv", text);
  const Error e = error_of([&] { read_points(MPI_COMM_SELF, file, [](int) { return 1.0; }); });
  EXPECT_FALSE(e.cure().empty());
  const std::string what = e.what();
  return what.starts_with(file) ? "FILE" + what.substr(file.size()) : what;
}

testing::AssertionResult says(const std::string& text, const std::string& place, const std::string& part) {
  const std::string what = refusal(text);
  if (what.starts_with(place) && what.find(part) != what.npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << '"' << what << "\" is not \"" << place << " ... " << part << '"';
}

TEST(CsvCloud, ReadsPointsInTheUnitsOfTheHeader) {
  const Points p = read("x [mm],y [cm],volume [mm^3],tag\n1,2,8,core\n3,4,27,\n");
  ASSERT_EQ(p.points.size(), 2u);
  EXPECT_EQ(p.dimension, 2);
  EXPECT_NEAR(norm(p.points[0].x - Vec3{0.001, 0.02, 0}), 0, 1e-17);
  EXPECT_NEAR(p.points[1].volume, 27e-9, 1e-22);
  EXPECT_EQ(p.points[1].id, 1);
  EXPECT_EQ(p.tags, (std::vector<std::string>{"", "core"}));
  EXPECT_EQ(p.points[0].tag, 1);
  EXPECT_EQ(p.points[1].tag, 0);
  EXPECT_FALSE(p.has_areas);
}

TEST(CsvCloud, MayBeginWithTheMarkOfUtf8AndAComment) {
  EXPECT_EQ(read("\xEF\xBB\xBF# by hand\nx [mm],volume [mm^3]\n1,2\n3,2\n").points.size(), 2u);
  EXPECT_EQ(read("\xEF\xBB\xBFx [mm],volume [mm^3]\n1,2\n3,2\n").points.size(), 2u);
}

TEST(CsvCloud, TakesTheSpacingFromTheVolume) {
  EXPECT_NEAR(read("x [m],volume [m^3]\n0,0.06\n", 0.1).points[0].spacing, 0.6, 1e-15);
  EXPECT_NEAR(read("x [m],y [m],volume [m^3]\n0,1,0.09\n", 0.25).points[0].spacing, 0.6, 1e-15);
  EXPECT_NEAR(read("x [m],y [m],z [m],volume [m^3]\n0,0,1,0.216\n").points[0].spacing, 0.6, 1e-15);
}

TEST(CsvCloud, ReadsPiecesOfSurfaceWithTheirFaces) {
  const Points p = read(
      "x [m],y [m],volume [m^3],area_x [m^2],area_y [m^2],face,area2_x [m^2],area2_y [m^2],face2\n"
      "0,0,1,-2,0,left,0,-3,low\n"
      "1,0,1,0,-3,low,,,\n"
      "1,1,1,0,0,,0,0,\n");
  EXPECT_TRUE(p.has_areas);
  EXPECT_EQ(p.faces, (std::vector<std::string>{"left", "low"}));
  EXPECT_EQ(p.points[0].facets, 2);
  EXPECT_EQ(p.points[0].area, (Vec3{-2, -3, 0}));
  EXPECT_EQ(p.points[0].on_faces, 3u);
  EXPECT_EQ(p.points[1].on_faces, 2u);
  EXPECT_EQ(p.points[2].facets, 0);
  ASSERT_EQ(p.facets.size(), 3u);
  EXPECT_EQ(p.facets[1].face, 1);
  EXPECT_EQ(p.facets[1].area, 3);
  EXPECT_EQ(p.facets[1].normal, (Vec3{0, -1, 0}));
}

TEST(CsvCloud, CallsTheFaceSurfaceWhereItHasNoName) {
  const Points p = read("x [m],volume [m^3],area_x [m^2]\n0,1,-1\n1,1,1\n");
  EXPECT_EQ(p.faces, std::vector<std::string>{"surface"});
  EXPECT_EQ(p.facets[1].normal, (Vec3{1, 0, 0}));
}

TEST(CsvCloud, NamesThePlaceOfWhatIsWrong) {
  const std::string head = "x [m],y [m],volume [m^3],tag\n";
  EXPECT_TRUE(says(head + "0,0,1,a\n0,nan,1,b\n", "FILE:3:3", "not finite"));
  EXPECT_TRUE(says(head + "0,0,1,a\n0,zero,1,b\n", "FILE:3:3", "not a number"));
  EXPECT_TRUE(says(head + "0,0,1,a\n\n0,1\n", "FILE:4", "2 cells"));
  EXPECT_TRUE(says(head + "0,0,0,a\n", "FILE:2:5", "not positive"));
  EXPECT_TRUE(says(head + "0,0,-1,a\n", "FILE:2:5", "-1"));
  EXPECT_TRUE(says("", "FILE", "empty"));
  EXPECT_TRUE(says(head, "FILE", "no rows"));
  EXPECT_TRUE(says("x [m],y [m]\n0,0\n", "FILE:1", "no column 'volume'"));
  EXPECT_TRUE(says("y [m],volume [m^3]\n0,1\n", "FILE:1", "no column 'x'"));
  EXPECT_TRUE(says("x [parsec2],volume [m^3]\n0,1\n", "FILE:1", "parsec2"));
  EXPECT_TRUE(says("x [kg],volume [m^3]\n0,1\n", "FILE:1", "kg"));
  EXPECT_TRUE(says("x,volume [m^3]\n0,1\n", "FILE:1", "no unit"));
  EXPECT_TRUE(says("x [m],z [m],volume [m^3]\n0,0,1\n", "FILE:1", "'z'"));
  EXPECT_TRUE(says("x [m],colour,volume [m^3]\n0,red,1\n", "FILE:1", "'colour' is not a column"));
  EXPECT_TRUE(says("x [m],x [m],volume [m^3]\n0,0,1\n", "FILE:1", "two columns 'x'"));
  EXPECT_TRUE(says("x [m],y [m],volume [m^3],area_x [m^2]\n0,0,1,1\n", "FILE:1", "no column 'area_y'"));
  EXPECT_TRUE(says("x [m],volume [m^3],area_x [m^2],face\n0,1,1,\n", "FILE:2", "without the name"));
}

TEST(CsvCloud, RefusesMoreFacesThanItCanCount) {
  std::string text = "x [m],volume [m^3],area_x [m^2],face\n";
  for (int i = 0; i < 33; ++i) text += std::to_string(i) + ",1,1,f" + std::to_string(i) + "\n";
  EXPECT_TRUE(says(text, "FILE", "33 faces"));
}

TEST(CsvCloud, SaysWhenAFileCannotBeRead) {
  try {
    read_points(MPI_COMM_SELF, "/nowhere/cloud.csv", [](int) { return 1.0; });
    ADD_FAILURE() << "read";
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::file);
  }
}

std::string squares(int n) {  // n x n points with the areas of the unit square's sides
  std::string text = "x [m],y [m],volume [m^3],area_x [m^2],area_y [m^2],face,tag\n";
  for (int i = 0; i < n * n; ++i) {
    const int x = i % n, y = i / n;
    const std::string side = x == 0 ? "west" : x == n - 1 ? "east" : y == 0 ? "south" : y == n - 1 ? "north" : "";
    text += std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(1 + i) + ",";
    text += side.empty() ? "0,0,," : std::to_string(x == 0 ? -1 : x == n - 1) + ",1," + side + ",";
    text += (y > n / 2 ? "upper" : "") + std::string("\n");
  }
  return text;
}

TEST(CsvCloudParallel, IsReadInPartsThatGiveTheSameCloud) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const std::string file = folder.write("cloud.csv", squares(9));
  const Points all = read_points(MPI_COMM_SELF, file, [](int) { return 1.0; });
  const Points mine = read_points(MPI_COMM_WORLD, file, [](int) { return 1.0; });
  EXPECT_EQ(mine.faces, all.faces);
  EXPECT_EQ(mine.tags, all.tags);
  EXPECT_EQ(total(MPI_COMM_WORLD, static_cast<std::int64_t>(mine.points.size())), 81);
  const std::int64_t first = offset(MPI_COMM_WORLD, static_cast<std::int64_t>(mine.points.size()));
  for (std::size_t k = 0; k < mine.points.size(); ++k) {
    const Point &p = mine.points[k], &q = all.points[first + static_cast<std::int64_t>(k)];
    EXPECT_EQ(p.id, q.id);
    EXPECT_EQ(p.x, q.x);
    EXPECT_EQ(p.volume, q.volume);
    EXPECT_EQ(p.on_faces, q.on_faces);
    EXPECT_EQ(p.tag, q.tag);
    EXPECT_EQ(p.area, q.area);
  }
}

TEST(CsvCloudParallel, HasTheSameErrorOnAllRanks) {
  std::string text = squares(9);
  text += "0,0,nan,0,0,,\n";
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const std::string file = folder.write("cloud.csv", text);
  const Error e = error_of([&] { read_points(MPI_COMM_WORLD, file, [](int) { return 1.0; }); });
  EXPECT_EQ(e.location().line, 83);  // header, 81 rows, this one
}

}  // namespace
}  // namespace calor
