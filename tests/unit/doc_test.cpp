#include "app/doc.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "base/error.hpp"
#include "case/case.hpp"

namespace calor {
namespace {

Schema keys() {
  Schema s;
  s.add({.path = "cloud",
         .sentence = "The points.",
         .keys = {{"shape", Kind::choice, "", "box", "What makes them.", {"box", "disc"}},
                  {"thickness", Kind::quantity, "m", "1 m", "In two dimensions."}}});
  s.add({.path = "material.*",
         .sentence = "A material.",
         .keys = {{"density", Kind::function, "kg/m^3", required, "Mass per volume."}}});
  s.add({.path = "cloud",
         .sentence = "A disc.",
         .keys = {{"radius", Kind::quantity, "m", required, "Of the disc."}},
         .when_key = "shape",
         .when_value = "disc"});
  s.add({.path = "expect[]", .sentence = "A check.", .keys = {{"at", Kind::quantities, "s", optional, "When."}}});
  s.add({.path = "expect[].filter", .sentence = "Rows.", .keys = {{"*", Kind::number, "", optional, "Value."}}});
  return s;
}

TEST(Manual, TellsKindUnitDefaultAndMeaningOfEveryKey) {
  const std::string all = manual(keys());
  for (const char* line : {
           "### `[cloud]`\n\nThe points.\n",
           "| `shape` | `\"box\"`, `\"disc\"` | `box` | What makes them. |\n",
           "| `thickness` | quantity, m | `1 m` | In two dimensions. |\n",
           "### `[cloud]` with `shape = \"disc\"`\n\nA disc.\n",
           "### `[material.NAME]`\n",
           "| `density` | function, kg/m^3 | required | Mass per volume. |\n",
           "### `[[expect]]`\n",
           "### `[expect.filter]`\n",
           "| any name | number |  | Value. |\n",
       })
    EXPECT_NE(all.find(line), all.npos) << line;
  EXPECT_TRUE(all.starts_with("# The case file\n"));
}

TEST(Manual, KeepsSectionsOfOnePathTogether) {
  const std::string all = manual(keys());
  EXPECT_LT(all.find("A disc."), all.find("A material."));
}

std::string on(const std::string& word) { return manual_on(keys(), word, false); }

TEST(ManualOnATerminal, ShowsOneSection) {
  EXPECT_EQ(on("material"), on("material.steel"));
  const std::string cloud = on("cloud");
  EXPECT_TRUE(cloud.starts_with("[cloud]\nThe points.\n"));
  EXPECT_NE(cloud.find("radius"), cloud.npos);
  EXPECT_EQ(cloud.find("density"), cloud.npos);
  EXPECT_NE(on("expect").find("filter"), std::string::npos);
}

TEST(ManualOnATerminal, ShowsOneKeyByItsPathOrItsName) {
  const std::string radius =
      "[cloud] with shape = \"disc\"\nA disc.\n  radius  quantity, m; required\n      Of the disc.\n";
  EXPECT_EQ(on("cloud.radius"), radius);
  EXPECT_EQ(on("radius"), radius);
  EXPECT_EQ(on("thickness"), "[cloud]\nThe points.\n  thickness  quantity, m; default 1 m\n      In two dimensions.\n");
  EXPECT_NE(on("material.steel.density").find("Mass per volume."), std::string::npos);
  EXPECT_NE(on("expect.at").find("When."), std::string::npos);
}

TEST(ManualOnATerminal, FindsChaptersAndWhatSpeaksOfAWord) {
  EXPECT_TRUE(on("units").starts_with("Units\nA quantity is a number with its unit in quotes: \"15 mm\","));
  EXPECT_NE(on("functions").find("\n  a power law\n      { power = 2,"), std::string::npos);
  EXPECT_EQ(on("Mass"), "Keys that speak of \"Mass\"\n  material.NAME.density\n      Mass per volume.\n");
  std::istringstream lines(on("functions") + on("units"));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
}

TEST(ManualOnATerminal, OffersTheNearestWordForAnUnknownOne) {
  const auto problem = [](const std::string& word) -> std::string {
    try {
      return on(word);
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::command);
      return e.what();
    }
  };
  EXPECT_EQ(problem("cloud.raduis"), "'cloud.raduis' is nowhere in the manual: did you mean 'cloud.radius'?");
  EXPECT_EQ(problem("raduis"), "'raduis' is nowhere in the manual: did you mean 'radius'?");
  EXPECT_EQ(problem("weather"), "'weather' is nowhere in the manual: calor doc shows all of it");
}

}  // namespace
}  // namespace calor
