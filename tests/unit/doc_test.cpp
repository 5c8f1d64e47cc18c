#include "app/doc.hpp"

#include <gtest/gtest.h>

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

TEST(Manual, ShowsOneSection) {
  EXPECT_EQ(manual(keys(), "material"), manual(keys(), "material.steel"));
  const std::string cloud = manual(keys(), "cloud");
  EXPECT_TRUE(cloud.starts_with("### `[cloud]`\n"));
  EXPECT_NE(cloud.find("radius"), cloud.npos);
  EXPECT_EQ(cloud.find("density"), cloud.npos);
  EXPECT_NE(manual(keys(), "expect").find("filter"), std::string::npos);
}

TEST(Manual, ShowsOneKey) {
  EXPECT_EQ(manual(keys(), "cloud.radius"),
            "### `[cloud]` with `shape = \"disc\"`\n\nA disc.\n\n| key | kind | default | |\n|---|---|---|---|\n"
            "| `radius` | quantity, m | required | Of the disc. |\n");
  EXPECT_NE(manual(keys(), "material.steel.density").find("Mass per volume."), std::string::npos);
  EXPECT_NE(manual(keys(), "expect.at").find("When."), std::string::npos);
}

TEST(Manual, OffersTheNearestKeyForAnUnknownOne) {
  const auto problem = [](const std::string& key) -> std::string {
    try {
      return manual(keys(), key);
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::command);
      return e.what();
    }
  };
  EXPECT_EQ(problem("cloud.raduis"), "'cloud.raduis' is neither a section nor a key: did you mean 'cloud.radius'?");
  EXPECT_EQ(problem("radius"), "'radius' is neither a section nor a key: did you mean 'cloud.radius'?");
  EXPECT_EQ(problem("weather"), "'weather' is neither a section nor a key: calor doc lists all of them");
}

}  // namespace
}  // namespace calor
