// Parts of which only the points know: clouds with tags.
#include "geometry/point_tags.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "case_models.hpp"
#include "method_clouds.hpp"
#include "results.hpp"

namespace calor {
namespace {

TEST(PointTagsParallel, AreThoseOfTheNearestPointAllAlongASegment) {
  for (const std::vector<long>& size : {std::vector<long>{30}, {9, 8}, {6, 6, 5}}) {
    Cloud cloud = box_cloud(size, 0.1, {.jitter = 0.3, .comm = MPI_COMM_WORLD});
    const Cloud whole = box_cloud(size, 0.1, {.jitter = 0.3});
    const auto tag_of = [](std::int64_t id) { return scattered(static_cast<double>(id)) > 0 ? 1 : 0; };
    for (int i = 0; i < cloud.local(); ++i) cloud.tag[i] = tag_of(cloud.id[i]);
    const PointTags tags(cloud, cloud.tag);
    for (int n = 0; n < 50; ++n) {
      Vec3 a, b;
      for (int axis = 0; axis < cloud.dimension; ++axis) {
        a[axis] = 0.25 + 0.25 * scattered(10 * n + axis);
        b[axis] = 0.25 + 0.25 * scattered(10 * n + axis + 5);
      }
      const std::vector<TagPiece> pieces = tags.along(a, b);
      EXPECT_EQ(pieces.back().end, 1);
      std::size_t piece = 0;
      for (int k = 0; k < 500; ++k) {
        const double s = (k + 0.5) / 500;
        while (pieces[piece].end < s) ++piece;
        const Vec3 x = a + s * (b - a);
        int nearest = 0;
        for (int i = 0; i < whole.local(); ++i)
          if (norm(whole.x[i] - x) < norm(whole.x[nearest] - x)) nearest = i;
        EXPECT_EQ(pieces[piece].tag, tag_of(whole.id[nearest])) << "at " << s;
      }
    }
  }
}

/// Points in columns at x of a strip 0.5 m wide, cells from midway to midway, those of some columns with a tag.
std::string columns_of_points(const std::vector<double>& x, int first, int count) {
  constexpr int rows = 11;
  constexpr double d = 0.05;
  std::string text = "x [m],y [m],volume [m^3],tag,area_x [m^2],area_y [m^2],face,area2_x [m^2],area2_y [m^2],face2\n";
  const int n = static_cast<int>(x.size());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < rows; ++j) {
      const double width = 0.5 * (x[std::min(i + 1, n - 1)] - x[std::max(i - 1, 0)]);
      const double height = j == 0 || j == rows - 1 ? d / 2 : d;
      std::string side =
          i == 0 || i == n - 1 ? fmt::format(",{},0,{}", i == 0 ? -height : height, i == 0 ? "low" : "high") : "";
      if (j == 0 || j == rows - 1) side += fmt::format(",0,{},{}", j == 0 ? -width : width, j == 0 ? "front" : "back");
      while (std::ranges::count(side, ',') < 6) side += ",";
      text += fmt::format("{},{},{},{}{}\n", x[i], j * d, width * height,
                          i < first || i >= first + count ? "" : "strip", side);
    }
  return text;
}

TEST(PointTags, PairsThatJumpOverThinPartsRunThroughThem) {
  // An insulator of so many columns of points across a metal bar: resistances in series, with its contacts.
  const TemporaryFolder folder;
  for (const bool even : {true, false}) {
    std::vector<double> x = {0};
    for (int i = 0; i < 20; ++i) x.push_back(x.back() + 0.05 * (even ? 1 : 1 + 0.25 * scattered(i)));
    for (const int columns : {1, 2, 3}) {
      const std::string file = folder.write("cloud.csv", columns_of_points(x, 8, columns));
      const double thickness = 0.5 * (x[8 + columns] + x[7 + columns] - x[8] - x[7]);
      for (const std::string method : {"sph", "peridynamics", "mlpg"})
        for (const double contact : {0., 50.}) {
          SCOPED_TRACE(fmt::format("{}, {} columns, contact {}, even {}", method, columns, contact, even));
          const double resistance = (x.back() - thickness) / 400 + thickness / 0.1 + (contact > 0 ? 2 / contact : 0);
          const std::string text =
              fmt::format("title = \"t\"\nmethod = \"{}\"\n[cloud]\nshape = \"csv\"\nfile = \"{}\"\n", method, file) +
              simple_material({.name = "metal", .k = "400"}) + simple_material({.name = "insulator", .k = "0.1"}) +
              "[body]\nmaterial = \"metal\"\n[[body.region]]\nmaterial = \"insulator\"\ntag = \"strip\"\n" +
              (contact > 0 ? fmt::format("contact = \"{} W/(m^2 K)\"\n", contact) : "") +
              "[steady]\n[boundary.hot]\non = \"low\"\ntemperature = \"400 K\"\n"
              "[boundary.cold]\non = \"high\"\ntemperature = \"300 K\"\n" +
              fmt::format("[[expect]]\nheat_flow = \"hot\"\nvalue = \"{:.15g} W\"\nwithin = \"1e-5 W\"\n",
                          100 * 0.5 / resistance);
          for (const Verdict& v : run_into("", text).verdicts)
            EXPECT_TRUE(v.passed) << v.value << " W, exact " << 100 * 0.5 / resistance;
        }
    }
  }
}

}  // namespace
}  // namespace calor
