#include "case/case.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "case/json.hpp"
#include "case/keys.hpp"
#include "case/schema.hpp"
#include "case/tree.hpp"
#include "case/values.hpp"
#include "errors.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// Some keys of every kind, so that these tests do not change with the modules.
const Schema& keys() {
  static const Schema all = [] {
    Schema s;
    declare_case(s);
    s.add({.path = "", .sentence = "", .keys = {{"method", Kind::choice, "", "sph", "", {"sph", "mlpg"}}}});
    s.add({.path = "cloud",
           .sentence = "",
           .keys = {{"shape", Kind::choice, "", "box", "", {"box", "disc", "cylinder"}},
                    {"thickness", Kind::quantity, "m", "1 m", ""}}});
    s.add({.path = "cloud",
           .sentence = "",
           .keys = {{"size", Kind::quantities, "m", optional, ""},
                    {"points", Kind::integers, "", optional, "", {}, {"spacing"}},
                    {"spacing", Kind::quantity, "m", optional, "", {}, {"points"}},
                    {"jitter", Kind::number, "", "0", ""}},
           .when_key = "shape",
           .when_value = "box"});
    for (const char* shape : {"disc", "cylinder"})
      s.add({.path = "cloud",
             .sentence = "",
             .keys = {{"radius", Kind::quantity, "m", required, ""}, {"rings", Kind::integer, "", "10", ""}},
             .when_key = "shape",
             .when_value = shape});
    s.add({.path = "material.*",
           .sentence = "",
           .keys = {{"conductivity", Kind::function, "W/(m K)", required, ""},
                    {"porosity", Kind::number, "", "0", ""},
                    {"share", Kind::function, "", optional, ""},
                    {"note", Kind::text, "", "", ""}}});
    s.add({.path = "initial",
           .sentence = "",
           .keys = {{"temperature", Kind::function, "K", required, "", {"csv", "result"}}}});
    s.add({.path = "boundary.*",
           .sentence = "",
           .keys = {{"on", Kind::texts, "", optional, ""}, {"insulated", Kind::flag, "", "false", ""}}});
    s.add({.path = "boundary.*.convection",
           .sentence = "",
           .keys = {{"h", Kind::function, "W/(m^2 K)", required, ""}, {"ambient", Kind::function, "K", required, ""}}});
    s.add({.path = "steady", .sentence = "", .keys = {{"max_iterations", Kind::integer, "", "50", ""}}});
    s.add({.path = "time",
           .sentence = "",
           .keys = {{"end", Kind::quantity, "s", required, ""}, {"tolerance", Kind::difference, "K", optional, ""}}});
    s.add({.path = "sph", .sentence = "", .keys = {{"smoothing", Kind::number, "", "1.2", ""}}});
    s.add({.path = "probe", .sentence = "", .keys = {{"*", Kind::quantities, "m", optional, ""}}});
    s.add({.path = "expect[]",
           .sentence = "",
           .keys = {{"at", Kind::quantities, "s", optional, ""},
                    {"within", Kind::raw_quantities, "", required, ""},
                    {"value", Kind::function, "K", optional, ""}}});
    s.add({.path = "expect[].filter", .sentence = "", .keys = {{"*", Kind::number, "", optional, ""}}});
    return s;
  }();
  return all;
}

/// A complete case; more of it goes below.
const std::string head = R"toml(title = "A case"
[cloud]
[material.steel]
conductivity = "50 W/(m K)"
)toml";  // four lines: what is added begins on line 5

Case parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return Case::parse(text, "folder/a.toml", keys(), overrides);
}

Case with(const std::string& more, const std::vector<std::string>& overrides = {}) {
  return parse(head + more, overrides);
}

/// What the command would print.
std::string message(const std::string& text, const std::vector<std::string>& overrides = {},
                    Fault fault = Fault::bad_case) {
  const Error e = error_of([&] { parse(text, overrides); });
  EXPECT_EQ(e.fault(), fault) << e.what();
  return e.what();
}

std::string message_with(const std::string& more) { return message(head + more); }

/// For messages that end with words of others.
testing::AssertionResult begins(const std::string& text, const std::string& start) {
  return text.starts_with(start) ? testing::AssertionSuccess() : testing::AssertionFailure() << text;
}

/// With `line` as line 4, the conductivity.
std::string message_of(const std::string& conductivity) {
  return message("title = \"A case\"\n[cloud]\n[material.steel]\nconductivity = " + conductivity + "\n");
}

Function conductivity(const std::string& value, const std::string& more = "") {
  return parse("title = \"A\"\n[cloud]\n[material.steel]\nconductivity = " + value + "\n" + more)
      .section("material")
      .sub("steel")
      .function("conductivity");
}

TEST(Case, GivesValuesOfEveryKindInSi) {
  const Case c = with(R"toml(porosity = 0.12
note = "mild"
[boundary.top]
on = ["zmax", "zmin"]
insulated = true
[time]
end = "2 min"
tolerance = "0.5 degC"
[probe]
centre = ["1 mm", "2 cm", "3 m"]
[[expect]]
at = ["1 s", "500 ms"]
within = ["0.2 K", "0.02 %"]
)toml");
  const Table steel = c.section("material").sub("steel"), top = c.section("boundary").sub("top");
  EXPECT_DOUBLE_EQ(steel.number("porosity"), 0.12);
  EXPECT_EQ(steel.text("note"), "mild");
  EXPECT_EQ(top.texts("on"), (std::vector<std::string>{"zmax", "zmin"}));
  EXPECT_TRUE(top.flag("insulated"));
  EXPECT_DOUBLE_EQ(c.section("time").number("end"), 120);
  EXPECT_DOUBLE_EQ(c.section("time").number("tolerance"), 0.5);
  EXPECT_EQ(c.section("probe").numbers("centre"), (std::vector<double>{0.001, 0.02, 3}));
  const std::vector<Table> expect = c.root().list("expect");
  ASSERT_EQ(expect.size(), 1u);
  EXPECT_EQ(expect[0].numbers("at"), (std::vector<double>{1, 0.5}));
  const auto within = expect[0].quantities_with_units("within");
  EXPECT_EQ(within, (std::vector<std::pair<double, std::string>>{{0.2, "K"}, {0.02, "%"}}));
}

TEST(Case, TakesASingleValueForAList) {
  const Case c = with("[boundary.top]\non = \"zmax\"\n[[expect]]\nat = \"3 s\"\nwithin = \"1 K\"\n");
  EXPECT_EQ(c.section("boundary").sub("top").texts("on"), std::vector<std::string>{"zmax"});
  EXPECT_EQ(c.root().list("expect")[0].numbers("at"), std::vector<double>{3});
  EXPECT_EQ(c.root().list("expect")[0].quantities_with_units("within").size(), 1u);
}

TEST(Case, FillsInDefaults) {
  const Case c = with("");
  EXPECT_DOUBLE_EQ(c.section("sph").number("smoothing"), 1.2);
  EXPECT_FALSE(c.section("sph").has("smoothing"));
  EXPECT_TRUE(c.section("sph").given("smoothing"));
  EXPECT_FALSE(c.section("time").given("tolerance"));
  EXPECT_EQ(c.section("cloud").text("shape"), "box");
  EXPECT_DOUBLE_EQ(c.section("cloud").number("thickness"), 1);
  EXPECT_FALSE(c.root().has("time"));
  EXPECT_TRUE(c.root().has("cloud"));
  EXPECT_TRUE(c.root().list("expect").empty());
  EXPECT_EQ(c.section("material").sub("steel").text("note"), "");
}

TEST(Case, KeepsNamedTablesInTheOrderOfTheFile) {
  const Case c =
      with("[material.air]\nconductivity = \"0.03 W/(m K)\"\n[material.brass]\nconductivity = \"1 W/(m K)\"\n");
  std::vector<std::string> names;
  for (const auto& [name, table] : c.section("material").children()) {
    names.push_back(name);
    EXPECT_EQ(table.path(), "material." + name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"steel", "air", "brass"}));
}

TEST(Case, KnowsThePlaceOfEveryValue) {
  const Table steel = with("  porosity =   0.3\n").section("material").sub("steel");
  EXPECT_EQ(steel.location("porosity").text(), "folder/a.toml:5:16");
  EXPECT_EQ(steel.location("conductivity").text(), "folder/a.toml:4:16");
  EXPECT_EQ(steel.location().text(), "folder/a.toml:3:1");
  EXPECT_EQ(steel.location("note").text(), "folder/a.toml:3:1");  // absent: the table's
  const Error e = error_of([&] { steel.refuse("porosity", "too many holes", "fill some"); });
  EXPECT_STREQ(e.what(), "folder/a.toml:5:16: too many holes: fill some");
  EXPECT_EQ(e.fault(), Fault::bad_case);
}

TEST(Case, NamesFilesRelativeToItself) {
  const Case c = with("[initial]\ntemperature = { csv = \"start/T.csv\" }\n");
  const Table temperature = c.section("initial").sub("temperature");
  EXPECT_TRUE(temperature.has("csv"));
  EXPECT_FALSE(temperature.has("result"));
  EXPECT_EQ(temperature.file("csv"), "folder/start/T.csv");
}

TEST(Case, IsNamedAfterItsFileAndVariant) {
  const std::string variants = "[[variant]]\nname = \"thick\"\nset = { cloud.thickness = \"2 m\" }\n";
  EXPECT_EQ(with(variants).name(), "a");
  EXPECT_EQ(with(variants, {"variant=thick"}).name(), "a/thick");
  EXPECT_EQ(with(variants).variants(), std::vector<std::string>{"thick"});
  EXPECT_EQ(with(variants).path(), "folder/a.toml");
}

TEST(Case, ReadsAFile) {
  const TemporaryFolder folder;
  const Case c = Case::read(folder.write("one.toml", head), keys());
  EXPECT_EQ(c.name(), "one");
  EXPECT_EQ(c.root().text("title"), "A case");
  for (const std::string& wrong : {folder / "two.toml", folder.path()})
    EXPECT_EQ(error_of([&] { Case::read(wrong, keys()); }).fault(), Fault::file) << wrong;
}

// Overrides

TEST(Overrides, ChangeValuesAsIfWrittenInTheCase) {
  const Case c = with("", {"cloud.shape=disc", "cloud.radius=15 mm", "cloud.rings=4", "sph.smoothing=1.3",
                           "material.steel.conductivity={ formula = \"T\", unit = \"W/(m K)\" }"});
  EXPECT_EQ(c.section("cloud").text("shape"), "disc");
  EXPECT_DOUBLE_EQ(c.section("cloud").number("radius"), 0.015);
  EXPECT_EQ(c.section("cloud").integer("rings"), 4);
  EXPECT_DOUBLE_EQ(c.section("sph").number("smoothing"), 1.3);
  EXPECT_TRUE(c.section("material").sub("steel").function("conductivity").depends_on_temperature());
}

TEST(Overrides, ReplaceLists) {
  const std::string box = "[boundary.top]\non = [\"xmin\", \"xmax\"]\n";
  EXPECT_EQ(with(box, {"boundary.top.on=[\"ymin\"]"}).section("boundary").sub("top").texts("on"),
            std::vector<std::string>{"ymin"});
}

TEST(Overrides, ChangeEntriesOfListsCountedFromZero) {
  const std::string text =
      "conductivity = { table = [[300, 40], [500, 30]], unit = \"W/(m K)\", of = \"temperature\" }\n"
      "[boundary.top]\non = [\"xmin\", \"xmax\"]\n[[expect]]\nwithin = \"1 K\"\n[[expect]]\nwithin = \"2 K\"\nat = \"1 "
      "s\"\n";
  const std::vector<std::string> changes = {"expect[1].at=\"3 s\"", "boundary.top.on[1]=ymax",
                                            "material.steel.conductivity.table[0][1]=50"};
  const Case c = parse("title = \"A case\"\n[cloud]\n[material.steel]\n" + text, changes);
  const auto all = c.root().list("expect");
  EXPECT_FALSE(all[0].has("at"));
  EXPECT_EQ(all[1].numbers("at"), std::vector<double>{3});
  EXPECT_EQ(c.section("boundary").sub("top").texts("on"), (std::vector<std::string>{"xmin", "ymax"}));
  EXPECT_EQ(c.section("material").sub("steel").function("conductivity")({}, 0, 400), 40);
  EXPECT_EQ(message(head, {"expect[0].within=1 K"}),
            "command line (expect[0].within): the case has no list 'expect': [n] after a key is an entry of a list");
  EXPECT_EQ(message(head + "[[expect]]\nwithin = \"1 K\"\n", {"expect[1].within=1 K"}),
            "command line (expect[1].within): the case has no 'expect[1]': entries of lists are counted from 0");
  for (const std::string path : {"expect[]", "expect[one].at", "expect[0", "[0].at", "expect[0]at"})
    EXPECT_EQ(message(head, {path + "=1 s"}, Fault::command),
              "'" + path + "' is not the path of a key: write it as in cloud.radius=\"20 mm\"");
}

TEST(Overrides, ReplaceWithinEntriesWhatTheyReplaceElsewhere) {
  // A key that stands in place of another one drops it: here, of a list of clouds.
  Schema s;
  s.add({.path = "", .sentence = "", .keys = {{"title", Kind::text, "", "", ""}}});
  s.add({.path = "body.part[]",
         .sentence = "",
         .keys = {{"points", Kind::integer, "", optional, "", {}, {"spacing"}},
                  {"spacing", Kind::quantity, "m", optional, "", {}, {"points"}}}});
  const Case c = Case::parse("[[body.part]]\npoints = 3\n[[body.part]]\npoints = 4\n", "a.toml", s,
                             {"body.part[1].spacing=\"2 mm\""});
  const auto parts = c.section("body").list("part");
  EXPECT_TRUE(parts[0].has("points"));
  EXPECT_FALSE(parts[1].has("points"));
  EXPECT_DOUBLE_EQ(parts[1].number("spacing"), 0.002);
}

TEST(Overrides, MayGiveWhatTheFileLacks) {
  EXPECT_EQ(parse("[cloud]\n[material.a]\nconductivity = \"1 W/(m K)\"\n", {"title=\"Late\""}).root().text("title"),
            "Late");
}

TEST(Overrides, AreNamedInMessages) {
  EXPECT_EQ(message(head, {"cloud.pionts=[3]"}),
            "command line (cloud.pionts): 'pionts' is not a key of [cloud]: did you mean 'points'?");
  EXPECT_EQ(message(head, {"cloud.thickness=3"}),
            "command line (cloud.thickness): 3 has no unit: 'thickness' needs a unit, e.g. \"3 m\"");
  EXPECT_EQ(message(head, {"title.x=3"}),
            "command line (title.x): 'title' is the text \"A case\", not a table: a key=value changes whole lists and "
            "values: give a new one for title");
  EXPECT_EQ(message(head, {"cloud.points"}, Fault::command),
            "'cloud.points' is not key=value: write it as in cloud.radius=\"20 mm\"");
  EXPECT_EQ(message(head, {"cloud..points=3"}, Fault::command),
            "'cloud..points' is not the path of a key: write it as in cloud.radius=\"20 mm\"");
  EXPECT_TRUE(begins(message(head, {"cloud.points=[3"}), "command line (cloud.points): [3: "));
}

// Variants

const std::string two_variants = R"toml([parameter]
B = 0.5
[steady]
[[expect]]
within = "1 K"
at = "1 s"
[[variant]]
name = "deep"
set = { parameter.B = 1.0, cloud.size = ["1 m", "2 m"], material.steel.porosity = 0.1 }
[[variant]]
name = "marching"
remove = ["steady"]
set.time = { end = "3 s" }
[[variant.expect]]
within = "2 K"
[[variant.expect]]
within = "3 K"
)toml";

TEST(Variants, AreMergedDeepIntoTheCase) {
  const Case c = with(two_variants, {"variant=deep"});
  EXPECT_DOUBLE_EQ(c.context().parameters.at("B"), 1);
  EXPECT_EQ(c.section("cloud").numbers("size"), (std::vector<double>{1, 2}));
  EXPECT_DOUBLE_EQ(c.section("material").sub("steel").number("porosity"), 0.1);
  EXPECT_DOUBLE_EQ(c.section("material").sub("steel").function("conductivity")(), 50);
  EXPECT_EQ(c.root().list("expect").size(), 1u);
  EXPECT_TRUE(c.root().has("steady"));
}

TEST(Variants, ReplaceExpectationsAndRemoveTables) {
  const Case c = with(two_variants, {"variant=marching"});
  EXPECT_FALSE(c.root().has("steady"));
  EXPECT_DOUBLE_EQ(c.section("time").number("end"), 3);
  const std::vector<Table> expect = c.root().list("expect");
  ASSERT_EQ(expect.size(), 2u);
  EXPECT_DOUBLE_EQ(expect[1].quantities_with_units("within")[0].first, 3);
  EXPECT_FALSE(expect[0].has("at"));
}

TEST(Variants, LeaveTheBaseCaseAlone) {
  const Case c = with(two_variants);
  EXPECT_DOUBLE_EQ(c.context().parameters.at("B"), 0.5);
  EXPECT_FALSE(c.section("cloud").has("size"));
  EXPECT_EQ(c.variants(), (std::vector<std::string>{"deep", "marching"}));
}

// What a change replaces.

const std::string plate_of_points =
    "title = \"A case\"\n[cloud]\nsize = [\"1 m\"]\npoints = [11]\n[material.steel]\nconductivity = \"1 W/(m K)\"\n";

TEST(Changes, OfAKeyDropTheOneInWhosePlaceItStands) {
  const Case finer = parse(plate_of_points, {"cloud.spacing=1 mm"});
  EXPECT_TRUE(finer.section("cloud").has("spacing"));
  EXPECT_FALSE(finer.section("cloud").has("points"));
  const Case by_variant =
      parse(plate_of_points + "[[variant]]\nname = \"fine\"\nset = { cloud.spacing = \"1 mm\" }\n", {"variant=fine"});
  EXPECT_FALSE(by_variant.section("cloud").has("points"));
  EXPECT_TRUE(by_variant.section("cloud").has("size"));
}

TEST(Changes, OfAChoiceDropTheKeysThatWentWithTheOldOne) {
  const std::string disc = "[[variant]]\nname = \"disc\"\nset.cloud = { shape = \"disc\", radius = \"1 m\" }\n";
  const Case c = parse(plate_of_points + disc, {"variant=disc"});
  EXPECT_DOUBLE_EQ(c.section("cloud").number("radius"), 1);
  EXPECT_EQ(c.section("cloud").keys(), (std::vector<std::string>{"shape", "radius"}));
  const Case by_words = parse(plate_of_points, {"cloud.radius=2 m", "cloud.shape=disc"});
  EXPECT_DOUBLE_EQ(by_words.section("cloud").number("radius"), 2);
  // What the change itself writes is not dropped in silence.
  EXPECT_EQ(message(plate_of_points + "[[variant]]\nname = \"d\"\nset.cloud = { shape = \"disc\", jitter = 0.1 }\n"),
            "folder/a.toml:9:31: 'jitter' goes with shape = \"box\", not \"disc\": leave it out, or change 'shape'");
}

TEST(Functions, StandInTheirPlaceAsIfInParentheses) {
  const std::string sum = "[parameter]\nB = 2\n[function.V]\nformula = \"x + B\"\n[function.W]\nformula = \"2*V\"\n";
  // 3 (x + 2), and 2 (x + 2) - 1e2 with x in mm.
  EXPECT_DOUBLE_EQ(conductivity("{ formula = \"3*V\", unit = \"W/(m K)\" }", sum)({1, 0, 0}), 9);
  EXPECT_DOUBLE_EQ(conductivity("{ formula = \"W - 1e2\", unit = \"W/(m K)\", length = \"mm\" }", sum)({1, 0, 0}),
                   1904);
}

TEST(Functions, OfTheWrongKindAreRefused) {
  EXPECT_EQ(
      message_with("[function.V]\nformula = \"2*W\"\n").find("folder/a.toml:6:11: formula '2*W': unknown symbol 'W'"),
      0u);
  EXPECT_EQ(message_with("[function.V]\nformula = \"V\"\n").find("folder/a.toml:6:11: formula 'V': unknown symbol 'V'"),
            0u);
  EXPECT_EQ(message_with("[parameter]\nV = 1\n[function.V]\nformula = \"x\"\n"),
            "folder/a.toml:7:11: 'V' is the name of a parameter and of a function: rename one of them");
  EXPECT_EQ(message_with("[function]\nV = \"x\"\n"),
            "folder/a.toml:6:1: 'V' cannot be the text \"x\": [function] holds tables with names of your choice: write "
            "[function.NAME] above it");
}

TEST(Variants, ComeBeforeOtherOverrides) {
  EXPECT_DOUBLE_EQ(with(two_variants, {"parameter.B=7", "variant=deep"}).context().parameters.at("B"), 7);
}

TEST(Variants, ReplaceFunctionsAsAWhole) {
  const Case c = parse(R"toml(title = "A"
[cloud]
[material.steel]
conductivity = { formula = "1 + T", unit = "W/(m K)" }
[[variant]]
name = "table"
set = { material.steel.conductivity = { table = [[300, 1], [400, 3]], unit = "W/(m K)" } }
)toml",
                       {"variant=table"});
  EXPECT_DOUBLE_EQ(c.section("material").sub("steel").function("conductivity")({}, 0, 350), 2);
}

TEST(Variants, AreCheckedWithTheCase) {
  EXPECT_EQ(message_with("[[variant]]\nname = \"a\"\nset = { cloud.pionts = [3] }\n"),
            "folder/a.toml:7:15: 'pionts' is not a key of [cloud]: did you mean 'points'?");
  EXPECT_EQ(message_with("[[variant]]\nnam = \"a\"\n"),
            "folder/a.toml:6:1: 'nam' is not a key of [[variant]]: did you mean 'name'?");
  EXPECT_EQ(message_with("[[variant]]\nset = 3\n"),
            "folder/a.toml:6:7: 'set' cannot be the number 3: write a table: [set], or set = { ... }");
  EXPECT_EQ(message_with("[[variant]]\nname = \"a\"\n[[variant]]\nname = \"a\"\n"),
            "folder/a.toml:8:8: there are two variants \"a\": give each a name of its own");
  EXPECT_EQ(message_with("[[variant]]\nname = \"a\"\nremove = [\"time\"]\n"),
            "folder/a.toml:7:10: the case has no 'time' to remove: check the name");
}

TEST(Variants, ThatAreUnknownAreRefusedWithTheListOfThem) {
  EXPECT_EQ(message(head + two_variants, {"variant=shallow"}, Fault::command),
            "folder/a.toml: there is no variant \"shallow\": the variants are deep, marching");
  EXPECT_EQ(message(head, {"variant=shallow"}, Fault::command),
            "folder/a.toml: there is no variant \"shallow\": the case has no variants: leave variant= out");
}

// Functions

TEST(CaseFunction, IsAQuantity) {
  const Function k = conductivity("\"2 kW/(m K)\"");
  EXPECT_TRUE(k.is_constant());
  EXPECT_DOUBLE_EQ(k(), 2000);
}

TEST(CaseFunction, IsAFormulaInItsOwnUnits) {
  const Function k =
      conductivity("{ formula = \"2*x + T + B\", unit = \"kW/(m K)\", length = \"mm\", temperature = \"degC\" }",
                   "[parameter]\nB = 0.5\n");
  EXPECT_DOUBLE_EQ(k({.x = 0.003}, 0, 293.15), 1000 * (6 + 20 + 0.5));
}

TEST(CaseFunction, OfAFormulaKnowsItsBreaks) {
  const Function k = conductivity("{ formula = \"t < 60 ? 1 : 2\", unit = \"W/(m K)\", breaks = [\"1 min\"] }");
  EXPECT_EQ(k.changes().events, std::vector<double>{60});
}

TEST(CaseFunction, IsATableOfTemperature) {
  const std::string table = "table = [[0, 20], [100, 18], [200, 10]], unit = \"W/(m K)\", temperature = \"degC\"";
  EXPECT_DOUBLE_EQ(conductivity("{ " + table + " }")({}, 0, 323.15), 19);
  const Function cubic = conductivity("{ " + table + ", interpolation = \"cubic\" }");
  EXPECT_DOUBLE_EQ(cubic({}, 0, 373.15), 18);
  EXPECT_NE(cubic({}, 0, 323.15), 19);
}

TEST(CaseFunction, IsATableOfTime) {
  const Function k = conductivity("{ table = [[0, 1], [2, 3]], of = \"time\", time = \"min\", unit = \"W/(m K)\" }");
  EXPECT_TRUE(k.depends_on_time());
  EXPECT_DOUBLE_EQ(k({}, 60, 0), 2);
}

TEST(CaseFunction, OfATemperatureIsATableOfTimeUnlessSaid) {
  const Case c = with(
      "[boundary.a.convection]\nh = { table = [[300, 1], [400, 2]], unit = \"W/(m^2 K)\", of = \"temperature\" }\n"
      "ambient = { table = [[0, 20], [10, 30]], unit = \"degC\" }\n");
  const Table convection = c.section("boundary").sub("a").sub("convection");
  EXPECT_TRUE(convection.function("h").depends_on_temperature());
  EXPECT_TRUE(convection.function("ambient").depends_on_time());
  EXPECT_DOUBLE_EQ(convection.function("ambient")({}, 5), 298.15);
}

TEST(CaseFunction, ReadsATableFromAFileWithUnitsInItsHeader) {
  const TemporaryFolder folder;
  folder.write("k.csv", "T [degC],k [kW/(m K)]\n0,1\n100,2\n");
  folder.write("q.csv", "t [min],k [W/(m K)]\n0,1\n1,2\n");
  const std::string file = folder.write("a.toml", R"toml(title = "A"
[cloud]
[material.a]
conductivity = { file = "k.csv" }
[material.b]
conductivity = { file = "q.csv" }
)toml");
  const Table materials = Case::read(file, keys()).section("material");
  EXPECT_DOUBLE_EQ(materials.sub("a").function("conductivity")({}, 0, 323.15), 1500);
  EXPECT_DOUBLE_EQ(materials.sub("b").function("conductivity")({}, 30, 0), 1.5);
}

TEST(CaseFunction, IsOneOfTheProgramThatReadsTheCase) {
  const Function::Callback twice{.evaluate =
                                     [](const Arguments& args, std::span<double> out) {
                                       for (std::size_t i = 0; i < out.size(); ++i) out[i] = 2 * args.T[i];
                                     },
                                 .on = {.temperature = true}};
  const std::string text = "title = \"A\"\n[cloud]\n[material.a]\nconductivity = { callback = \"twice T\" }\n";
  const Case c = Case::parse(text, "a.toml", keys(), {}, {{"twice T", twice}});
  const Function k = c.section("material").sub("a").function("conductivity");
  EXPECT_EQ(k({}, 0, 150), 300);
  EXPECT_TRUE(k.depends_on_temperature());
  EXPECT_FALSE(k.depends_on_place() || k.depends_on_time());
  EXPECT_EQ(k.location().line, 4);
  EXPECT_EQ(error_of([&] {
              Case::parse(text, "a.toml", keys(), {}, {{"thrice", twice}});
            }).cure(),
            "the program gives thrice");
}

TEST(CaseFunction, IsConstantInLayers) {
  const Function k = conductivity(
      "{ layers = [1, 2], along = \"z\", thickness = [\"1 mm\", \"2 mm\"], start = \"1 mm\", unit = \"W/(m K)\" }");
  EXPECT_DOUBLE_EQ(k({.z = 0.0015}), 1);
  EXPECT_DOUBLE_EQ(k({.z = 0.0035}), 2);
  EXPECT_TRUE(k.is_layered());
  const Function same =
      conductivity("{ layers = [\"1 W/(m K)\", \"2 W/(cm K)\"], along = \"x\", thickness = \"1 m\" }");
  EXPECT_DOUBLE_EQ(same({.x = 1.5}), 200);
}

TEST(CaseFunction, WithoutDimensionNeedsNoUnit) {
  const Table steel = with("share = { formula = \"x\" }\n").section("material").sub("steel");
  EXPECT_DOUBLE_EQ(steel.function("share")({.x = 0.25}), 0.25);
  EXPECT_DOUBLE_EQ(with("share = 0.5\n").section("material").sub("steel").function("share")(), 0.5);
}

// What is refused

TEST(BadCase, OfBrokenTomlIsRefusedAtItsPlace) {
  EXPECT_EQ(
      message("title = \"A\"\nradius = 15 mm\n"),
      "folder/a.toml:2:13: Error while parsing key-value pair: expected a comment or whitespace, saw 'm': one key a "
      "line; a number with a unit goes in quotes, e.g. \"15 mm\"");
  EXPECT_EQ(
      message("title = \"A\"\ntitle = \"B\"\n"),
      "folder/a.toml:2:9: Error while parsing key-value pair: cannot redefine existing string 'title': give every key "
      "and every [table] once");
  EXPECT_TRUE(begins(message("title = \"A\n"), "folder/a.toml:"));
}

TEST(BadCase, HasAnUnknownKey) {
  EXPECT_EQ(message("title = \"A\"\n[cloud]\n[material.steel]\n  conductivty = \"1 W/(m K)\"\n"),
            "folder/a.toml:4:3: 'conductivty' is not a key of [material.steel]: did you mean 'conductivity'?");
  EXPECT_EQ(message_with("colour = 3\n"),
            "folder/a.toml:5:1: 'colour' is not a key of [material.steel]: its keys are conductivity, porosity, share, "
            "note");
  EXPECT_EQ(message_with("[bonudary.top]\n"),
            "folder/a.toml:5:2: 'bonudary' is not a key of the case: did you mean 'boundary'?");
  EXPECT_EQ(message_with("[boundary.top.convecton]\n"),
            "folder/a.toml:5:15: 'convecton' is not a key of [boundary.top]: did you mean 'convection'?");
}

TEST(BadCase, HasAKeyOfAnotherChoice) {
  EXPECT_EQ(
      message("title = \"A\"\n[cloud]\nrings = 3\n"),
      "folder/a.toml:3:1: 'rings' goes with shape = \"disc\" or \"cylinder\", not \"box\": leave it out, or change "
      "'shape'");
}

TEST(BadCase, HasAValueOfAWrongType) {
  EXPECT_EQ(message_with("note = 3\n"), "folder/a.toml:5:8: 'note' cannot be the number 3: write a text in quotes");
  EXPECT_EQ(message_with("[sph]\nsmoothing = \"wide\"\n"),
            "folder/a.toml:6:13: 'smoothing' cannot be the text \"wide\": write a number without unit, e.g. 1.5");
  EXPECT_EQ(message_with("[steady]\nmax_iterations = 1.5\n"),
            "folder/a.toml:6:18: 'max_iterations' cannot be the number 1.5: write a whole number, e.g. 10");
  EXPECT_EQ(message_with("[boundary.a]\ninsulated = \"yes\"\n"),
            "folder/a.toml:6:13: 'insulated' cannot be the text \"yes\": write true or false");
  EXPECT_EQ(
      message_with("[boundary.a]\non = [\"xmin\", 3]\n"),
      "folder/a.toml:6:15: 'on' cannot be the number 3: write a text in quotes, or a list of texts: [\"a\", \"b\"]");
  EXPECT_TRUE(
      begins(message_with("[probe]\na = [\"1 m\", true]\n"), "folder/a.toml:6:13: 'a' cannot be true: write a num"));
  EXPECT_EQ(message_with("porosity = \"3 m\"\n"),
            "folder/a.toml:5:12: 'porosity' cannot be the text \"3 m\": write a number without unit, e.g. 1.5");
  EXPECT_EQ(message_with("[sph]\nsmoothing = nan\n"),
            "folder/a.toml:6:13: 'smoothing' is not finite: the number nan: write a finite number");
}

TEST(BadCase, HasAValueForASection) {
  EXPECT_EQ(message("title = \"A\"\ncloud = \"disc\"\n"),
            "folder/a.toml:2:9: 'cloud' cannot be the text \"disc\": write a table: [cloud]");
  EXPECT_EQ(message("title = \"A\"\n[cloud]\n[material]\nconductivity = \"1 W/(m K)\"\n"),
            "folder/a.toml:4:1: 'conductivity' cannot be the text \"1 W/(m K)\": [material] holds tables with names of "
            "your choice: write [material.NAME] above it");
  EXPECT_EQ(message_with("[expect]\nwithin = \"1 K\"\n"),
            "folder/a.toml:5:1: 'expect' cannot be a table: there can be several: write [[expect]]");
}

TEST(BadCase, HasAQuantityWithoutUnit) {
  EXPECT_EQ(message_of("50"), "folder/a.toml:4:16: 50 has no unit: 'conductivity' needs a unit, e.g. \"50 W/(m K)\"");
  EXPECT_EQ(message_of("\"50\""),
            "folder/a.toml:4:16: \"50\" has no unit: 'conductivity' needs a unit, e.g. \"50 W/(m K)\"");
}

TEST(BadCase, HasAnUnknownOrWrongUnit) {
  EXPECT_TRUE(begins(message_of("\"50 W/(m Q)\""), "folder/a.toml:4:16: 'conductivity' = \"50 W/(m Q)\": 'W/(m Q)"));
  EXPECT_EQ(
      message_of("\"50 J/(kg K)\""),
      "folder/a.toml:4:16: 'conductivity' = \"50 J/(kg K)\": 'J/(kg K)' cannot be converted to 'W/(m K)': write it "
      "in W/(m K), or in a unit that converts to that");
}

TEST(BadCase, LacksARequiredKey) {
  EXPECT_EQ(message("title = \"A\"\n[cloud]\n[material.steel]\n"),
            "folder/a.toml:3:1: [material.steel] needs 'conductivity': add conductivity = a number with its unit, e.g. "
            "\"1 W/(m K)\", or { formula = \"...\", unit = \"W/(m K)\" }, { table = ... }, { layers = ... }");
  EXPECT_EQ(message("[cloud]\n[material.a]\nconductivity = \"1 W/(m K)\"\n"),
            "folder/a.toml:1:1: the case needs 'title': add title = a text in quotes");
  EXPECT_EQ(message("title = \"A\"\n[material.a]\nconductivity = \"1 W/(m K)\"\n"),
            "folder/a.toml:1:1: the case needs 'cloud': add a table: [cloud], or cloud = { ... }");
  EXPECT_EQ(message("title = \"A\"\n[cloud]\nshape = \"disc\"\n"),
            "folder/a.toml:2:1: [cloud] needs 'radius': add radius = a number with its unit, e.g. \"1 m\"");
}

TEST(BadCase, ChoosesWhatThereIsNot) {
  EXPECT_EQ(message("title = \"A\"\n[cloud]\nshape = \"disk\"\n"),
            "folder/a.toml:3:9: 'shape' cannot be \"disk\": did you mean \"disc\"? It is one of \"box\", \"disc\", "
            "\"cylinder\"");
}

TEST(BadCase, HasAnEmptyList) {
  EXPECT_TRUE(begins(message_with("[boundary.a]\non = []\n"), "folder/a.toml:6:6: 'on' is an empty list: "));
}

TEST(BadCase, NamesAParameterAsAVariable) {
  EXPECT_EQ(message_with("[parameter]\nT = 3\n"),
            "folder/a.toml:6:1: 'T' cannot be a parameter: formulas have a meaning for x, y, z, r, t, T, pi, e: choose "
            "another name");
  EXPECT_EQ(message_with("[parameter]\n\"a b\" = 3\n"),
            "folder/a.toml:6:1: 'a b' cannot be a parameter: names are made of letters, digits and _");
  EXPECT_TRUE(
      begins(message_with("[parameter]\nB = \"3 m\"\n"), "folder/a.toml:6:5: 'B' cannot be the text \"3 m\": write"));
}

TEST(BadFunction, IsAFormulaWithoutUnit) {
  EXPECT_EQ(message_of("{ formula = \"1 + x\" }"),
            "folder/a.toml:4:16: conductivity = { ... } has no unit: it needs a unit, e.g. unit = \"W/(m K)\"");
}

TEST(BadFunction, HasAWrongUnit) {
  EXPECT_EQ(
      message_of("{ formula = \"1\", unit = \"J\" }"),
      "folder/a.toml:4:40: 'unit' of conductivity: 'J' cannot be converted to 'W/(m K)': write W/(m K), or a unit that "
      "converts to it");
  EXPECT_EQ(message_of("{ formula = \"1\", unit = \"W/(m K)\", length = \"s\" }"),
            "folder/a.toml:4:60: 'length' of conductivity: 's' cannot be converted to 'm': write m, or a unit that "
            "converts to it");
}

TEST(BadFunction, IsAFormulaWithAnUnknownSymbolOrASyntaxError) {
  EXPECT_TRUE(begins(message_of("{ unit = \"W/(m K)\", formula = \"1 + q\" }"),
                     "folder/a.toml:4:46: formula '1 + q': unknown symbol 'q' (cha"));
  EXPECT_TRUE(
      begins(message_of("{ formula = \"1 + \", unit = \"W/(m K)\" }"), "folder/a.toml:4:28: formula '1 + ': un"));
}

TEST(BadFunction, HasAnUnknownKey) {
  EXPECT_EQ(message_of("{ formula = \"x\", lenght = \"mm\" }"),
            "folder/a.toml:4:33: 'lenght' is not a key of conductivity = { formula = ... }: did you mean 'length'?");
  EXPECT_TRUE(begins(message_of("{ formula = \"x\", table = [] }"),
                     "folder/a.toml:4:33: 'table' is not a key of conductivity = { formula = ... }: "));
  EXPECT_TRUE(begins(message_of("{ fromula = \"x\" }"),
                     "folder/a.toml:4:16: 'conductivity' is a table without formula, table, file, layers, grid, "
                     "power, exponential or hump: wr"));
}

TEST(BadFunction, IsATableThatIsNone) {
  const auto table = [](const std::string& rows) { return message_of("{ unit = \"W/(m K)\", table = " + rows + " }"); };
  EXPECT_EQ(
      table("[[300, 1]]"),
      "folder/a.toml:4:44: the table has one row: a table needs at least two; write a single value as a number with "
      "its unit");
  EXPECT_TRUE(begins(table("[]"), "folder/a.toml:4:44: the table has no rows: a "));
  EXPECT_EQ(table("[[300, 1], [400, 2], [400, 3]]"),
            "folder/a.toml:4:65: row 3 of the table is not above row 2: 400 after 400 K: sort the rows by temperature, "
            "each once");
  EXPECT_EQ(
      table("[[300, 1], [400, nan]]"),
      "folder/a.toml:4:55: row 2 of the table is not a pair of finite numbers: write [temperature, value], the units "
      "go into 'temperature' and 'unit'");
  EXPECT_TRUE(begins(table("[[300, 1], [400]]"), "folder/a.toml:4:55: row 2 of the table is not a pair"));
  EXPECT_TRUE(begins(table("\"k.csv\""), "folder/a.toml:4:44: 'table' cannot be the text \"k.csv\": write"));
}

TEST(BadFunction, IsAFileThatIsNoTable) {
  EXPECT_EQ(message("title = \"A\"\n[cloud]\n[material.a]\nconductivity = { file = \"none.csv\" }\n", {}, Fault::file),
            "folder/a.toml:4:25: the file \"folder/none.csv\" cannot be read: check the name and the permissions");
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& csv) -> std::string {
    folder.write("k.csv", csv);
    const std::string file =
        folder.write("a.toml", "title = \"A\"\n[cloud]\n[material.a]\nconductivity = { file = \"k.csv\" }\n");
    const Error e = error_of([&] { Case::read(file, keys()); });
    return std::filesystem::path(e.location().text()).filename().string() + ": " + e.problem();
  };
  EXPECT_EQ(refused("T [K],k [W/(m K)],q\n1,2,3\n"), "k.csv:1: the file has 3 columns");
  EXPECT_EQ(refused("T [K],k [W/(m K)]\n300,1\n300,2\n"),
            "k.csv:3: row 2 of the table is not above row 1: 300 after 300 K");
  EXPECT_EQ(refused("T [K],k [W/(m K)]\n300,1\n400,nan\n"), "k.csv:3:5: 'nan' in column 'k' is not finite");
  EXPECT_EQ(refused("T [K],k [W/(m K)]\n300,1\n"), "a.toml:4:25: the table has one row");
  EXPECT_TRUE(begins(refused("T [K],k [J]\n300,1\n"), "k.csv:1: column 'k': "));
}

TEST(BadFunction, HasLayersThatDoNotFit) {
  const auto layers = [](const std::string& rest) {
    return message_of("{ unit = \"W/(m K)\", layers = " + rest + " }");
  };
  EXPECT_EQ(layers("[1, 2], along = \"z\", thickness = [\"1 m\", \"2 m\", \"3 m\"]"),
            "folder/a.toml:4:78: 3 thicknesses for 2 layers: give one for all layers, or one a layer");
  EXPECT_EQ(layers("[1, 2], along = \"z\", thickness = \"0 m\""),
            "folder/a.toml:4:78: a layer's thickness is not positive: write a thickness above 0 m");
  EXPECT_TRUE(
      begins(layers("[1, 2], thickness = \"1 m\""), "folder/a.toml:4:16: conductivity = { ... } needs 'along': add"));
  EXPECT_TRUE(begins(layers("[1, \"2 J\"], along = \"z\", thickness = \"1 m\""),
                     "folder/a.toml:4:49: 'layers' = \"2 J\": 'J' cannot"));
}

TEST(BadCase, HasAnotherFormOfAFunctionThatIsWrong) {
  EXPECT_EQ(message_with("[initial]\ntemperature = { csv = 3 }\n"),
            "folder/a.toml:6:23: 'csv' cannot be the number 3: write a text in quotes");
  EXPECT_EQ(message_with("[initial]\ntemperature = { csv = \"a\", unit = \"K\" }\n"),
            "folder/a.toml:6:28: 'unit' is not a key of temperature = { csv = ... }: its keys are csv");
}

// Nearest words

TEST(Nearest, FindsSlipsOfTheFingers) {
  const std::vector<std::string> known{"conductivity", "density", "specific_heat"};
  EXPECT_EQ(nearest("conductivty", known), "conductivity");
  EXPECT_EQ(nearest("denisty", known), "density");
  EXPECT_EQ(nearest("specific_heta", known), "specific_heat");
  EXPECT_EQ(nearest("radius", known), "");
  EXPECT_EQ(nearest("k", {}), "");
}

// JSON

TEST(CaseJson, HoldsTheWholeCaseWithItsDefaults) {
  EXPECT_EQ(
      with("").json(),
      "{\"title\": \"A case\", \"cloud\": {\"shape\": \"box\", \"thickness\": \"1 m\", \"jitter\": 0}, \"material\": "
      "{\"steel\": {\"conductivity\": \"50 W/(m K)\", \"porosity\": 0, \"note\": \"\"}}, \"method\": \"sph\", "
      "\"sph\": {\"smoothing\": 1.2}}");
}

TEST(CaseJson, HoldsListsAndTables) {
  const std::string json = with("[steady]\n[[expect]]\nwithin = [\"1 K\", 2]\nfilter = { B = 0.5 }\n").json();
  EXPECT_NE(json.find("\"steady\": {\"max_iterations\": 50}"), json.npos) << json;
  EXPECT_NE(json.find("\"expect\": [{\"within\": [\"1 K\", 2], \"filter\": {\"B\": 0.5}}]"), json.npos) << json;
}

// TOML

TEST(CaseToml, IsReadAgainAsTheSameCase) {
  const std::string more =
      "note = \"a \\\"b\\\"\\n\"\nshare = 1.0\n[material.\"my steel\"]\nconductivity = { table = [[300, 5], [400, "
      "1e-7]], unit "
      "= \"W/(m K)\" }\n[steady]\n[[expect]]\nwithin = [\"1 K\", 2]\nfilter = { B = 0.5 }\n[[expect]]\nwithin = \"1 "
      "K\"\n";
  const std::string text = toml_of(*with(more).root().node().root);
  EXPECT_EQ(parse(text).json(), with(more).json()) << text;
  EXPECT_EQ(toml_of(*parse(text).root().node().root), text);
  EXPECT_TRUE(begins(text, "title = \"A case\"\n\n[cloud]\n\n[material.steel]\nconductivity = \"50 W/(m K)\"\n"))
      << text;
}

TEST(CaseToml, HasTheVariantInItsPlaceOrAllWhereNoneWasChosen) {
  const auto variants_in = [](const Case& c) { return toml_of(*c.root().node().root).find("[[variant]]"); };
  EXPECT_EQ(variants_in(with(two_variants, {"variant=deep"})), std::string::npos);
  EXPECT_NE(variants_in(with(two_variants)), std::string::npos);
  EXPECT_EQ(with(two_variants).json().find("variant"), std::string::npos);
}

TEST(Overrides, ChooseAVariantInQuotesToo) { EXPECT_EQ(with(two_variants, {"variant=\"deep\""}).name(), "a/deep"); }

TEST(Json, EscapesTextsAndKeepsAllDigits) {
  EXPECT_EQ(json_string("a \"b\"\\\n\x01 µ"), "\"a \\\"b\\\"\\\\\\n\\u0001 µ\"");
  EXPECT_EQ(json_number(0.1), "0.1");
  EXPECT_EQ(json_number(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(json_number(std::nan("")), "null");
  EXPECT_EQ(json_number(INFINITY), "null");
}

}  // namespace
}  // namespace calor
