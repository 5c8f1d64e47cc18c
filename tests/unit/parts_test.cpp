// Parts of a body and what conducts in series between them.
#include "geometry/parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "case_models.hpp"
#include "cloud/points.hpp"
#include "material/material_field.hpp"

namespace calor {
namespace {

const std::string square_with_disc = R"toml(
title = "a disc in a square"
method = "sph"
[steady]
[cloud]
shape = "box"
size = ["1 m", "1 m"]
points = [11, 11]
[material.a]
conductivity = "1 W/(m K)"
density = "1 kg/m^3"
specific_heat = "1 J/(kg K)"
[material.b]
conductivity = "5 W/(m K)"
density = "3 kg/m^3"
specific_heat = "1 J/(kg K)"
[body]
material = "a"
[[body.region]]
material = "b"
where = "(x - 0.52)^2 + (y - 0.47)^2 < 0.31^2"
)toml";

const std::string layers = R"toml(
title = "three layers"
method = "sph"
[steady]
[cloud]
shape = "box"
size = ["1 m"]
points = [6]
[material.a]
conductivity = "1 W/(m K)"
[material.b]
conductivity = "5 W/(m K)"
[body]
along = "x"
[[body.layer]]
material = "a"
thickness = "0.2 m"
[[body.layer]]
material = "b"
thickness = "0.03 m"
contact = "7 W/(m^2 K)"
[[body.layer]]
material = "a"
thickness = "0.77 m"
)toml";

Cloud cloud_of(const Case& c) { return make_cloud(MPI_COMM_SELF, c, 2); }

TEST(Parts, ASegmentKnowsEveryLayerThatItRunsThroughHoweverThin) {
  const Case c = parse_case(layers);
  const Cloud cloud = cloud_of(c);
  const Parts parts(c, cloud, "");
  const Parts::Segment segments[] = {{{0.1}, {0.4}}, {{0.2}, {0.1}}, {{0.2}, {0.4}}, {{0.5}, {0.9}}};
  const Parts::Pieces pieces = parts.along(segments);
  ASSERT_EQ(pieces.row, (std::vector<std::int64_t>{0, 3, 4, 7, 8}));
  EXPECT_NEAR(pieces.piece[0].end, 1.0 / 3, 1e-12);
  EXPECT_NEAR(pieces.piece[1].end, 1.3 / 3, 1e-12);
  EXPECT_EQ(pieces.piece[1].part, 1);
  EXPECT_EQ(pieces.piece[2].part, 2);
  EXPECT_NEAR(pieces.piece[4].end, 0, 1e-12);  // begins on the interface, and lies in the second layer at once
  EXPECT_EQ(parts.contact(0, 2), nullptr);
  ASSERT_NE(parts.contact(1, 0), nullptr);
  EXPECT_EQ((*parts.contact(0, 1))(), 7);
  EXPECT_EQ(parts.contact(1, 2), nullptr);
}

TEST(Parts, APointOnAnInterfaceBelongsToBothSidesByTheirShareOfItsSurroundings) {
  std::string text = square_with_disc;
  text.replace(text.find("(x - 0.52)^2 + (y - 0.47)^2 < 0.31^2"), 36, "x < 0.5 && y > 0.3");
  const Case c = parse_case(text);
  const Cloud cloud = cloud_of(c);
  const Parts parts(c, cloud, "");
  const Vec3 x[] = {{0.5, 0.7}, {0.5, 0.3}, {0.2, 0.3}, {0.2, 0.7}, {0.2, 0.1}, {0.5, 1}};
  const int tag[] = {0, 0, 0, 0, 0, 0};
  const double size[] = {0.1, 0.1, 0.1, 0.1, 0.1, 0.1};
  const auto shares = parts.shares(x, tag, size);
  EXPECT_EQ(shares[1].place, (std::vector<int>{0, 1, 2, 3, 5}));
  EXPECT_EQ(shares[1].share, (std::vector<double>{0.5, 0.25, 0.5, 1, 0.5}));
}

TEST(Parts, TheirSharesOfTheCellsAddUpToTheirVolumes) {
  for (const bool jitter : {false, true}) {
    std::string text = square_with_disc;
    if (jitter) text.replace(text.find("points = [11, 11]"), 17, "points = [11, 11]\njitter = 0.2");
    const Case c = parse_case(text);
    const Cloud cloud = cloud_of(c);
    const auto shares = Parts(c, cloud, "").cell_shares();
    double volume = 0;
    for (std::size_t n = 0; n < shares[1].place.size(); ++n)
      volume += shares[1].share[n] * cloud.volume[shares[1].place[n]];
    EXPECT_NEAR(volume, M_PI * 0.31 * 0.31, jitter ? 6e-3 : 2e-3);
  }
}

TEST(Parts, TheNormalOfARegionsSurfaceIsFoundFromItsFormula) {
  const Case c = parse_case(square_with_disc);
  const Cloud cloud = cloud_of(c);
  const Parts parts(c, cloud, "");
  const Vec3 n{std::cos(0.7), std::sin(0.7)}, x = Vec3{0.52, 0.47} + 0.31 * n;
  const Vec3 found = parts.interface_at(x, {1, 0.1}, 0, 1, 0, 0.1).normal;
  EXPECT_NEAR(std::abs(dot(found, n)), 1, 1e-6);
}

/// They touch at x = 0.5 and 0.53.
const std::string rods = R"toml(
title = "three rods that touch"
method = "sph"
[steady]
[cloud]
shape = "surface"
spacing = "0.1 m"
part = [{ name = "first", shape = "rectangle", size = ["0.5 m", "0.4 m"] },
        { name = "thin", shape = "rectangle", size = ["0.03 m", "0.4 m"], at = ["0.5 m", "0 m"] },
        { name = "last", shape = "rectangle", size = ["0.47 m", "0.4 m"], at = ["0.53 m", "0 m"] }]
[material.a]
conductivity = "1 W/(m K)"
[body]
region = [{ tag = "first", material = "a" }, { tag = "thin", material = "a" }, { tag = "last", material = "a" }]
)toml";

TEST(Parts, ASegmentKnowsEverySolidThatItRunsThroughToRoundOff) {
  const Case c = parse_case(rods);
  const Cloud cloud = cloud_of(c);
  const Parts parts(c, cloud, "");
  const Parts::Segment segments[] = {{{0.1, 0.1}, {0.9, 0.2}}, {{0.5, 0.1}, {0.6, 0.1}}, {{0.5, 0.1}, {0.5, 0.2}}};
  const Parts::Pieces pieces = parts.along(segments);
  ASSERT_EQ(pieces.row, (std::vector<std::int64_t>{0, 3, 6, 7}));
  EXPECT_NEAR(pieces.piece[0].end, 0.4 / 0.8, 1e-15);
  EXPECT_NEAR(pieces.piece[1].end, 0.43 / 0.8, 1e-15);
  for (int n = 0; n < 6; ++n) EXPECT_EQ(pieces.piece[n].part, n % 3);
  EXPECT_NEAR(pieces.piece[3].end, 0, 1e-15);  // begins on the interface, and leaves the first part at once
  EXPECT_NEAR(pieces.piece[4].end, 0.3, 1e-15);
}

TEST(Parts, OneIsAroundAPlaceUpToTheNextInterface) {
  const Case c = parse_case(rods);
  const Cloud cloud = cloud_of(c);
  const Parts parts(c, cloud, "");
  EXPECT_TRUE(parts.is_one_around({0.3, 0.2}, 0.199));
  EXPECT_FALSE(parts.is_one_around({0.3, 0.2}, 0.201));
  const Case of_formula = parse_case(square_with_disc);
  const Cloud square = cloud_of(of_formula);
  EXPECT_FALSE(Parts(of_formula, square, "").is_one_around({0.1, 0.1}, 1e-3));  // nobody knows
}

TEST(PartsParallel, ARegionThatLaterOnesCoverIsToldOfWithItsPlace) {
  const auto notes = [](const std::string& where) {
    const CaseModel m(square_with_disc + "[boundary.b]\non = \"xmin\"\ntemperature = \"1 K\"\n[[body.region]]\n" +
                          "material = \"a\"\nwhere = \"" + where + "\"\n",
                      MPI_COMM_WORLD);
    return std::ranges::count_if(m.model().notes, [](const std::string& note) {
      return note == "test.toml:20:12: nothing of the body is left for this 'b': later regions cover it";
    });
  };
  EXPECT_EQ(notes("x > 0.1"), 1);
  EXPECT_EQ(notes("x > 0.6"), 0);
}

}  // namespace
}  // namespace calor
