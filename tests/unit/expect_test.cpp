#include "output/expect.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "app/run.hpp"
#include "case_models.hpp"
#include "output/report.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// A plate of 5 x 3 points, 4 m x 2 m; the first line after it is line 9.
const std::string body = box_case({"4 m", "2 m"}, {5, 3}) + "[material.m]\nlibrary = \"copper\"\n";
const std::string plate = body + "[steady]\n";
const std::string walls = R"toml([boundary.xmin]
temperature = "300 K"
[boundary.xmax]
temperature = "340 K"
[probe]
p = ["1.5 m", "0.5 m"]
)toml";  // T = 300 K + 10 K/m x

std::vector<Verdict> verdicts(const std::string& text, MPI_Comm comm = MPI_COMM_SELF) {
  return run_into("", text, comm).verdicts;
}
Verdict verdict(const std::string& expect, MPI_Comm comm = MPI_COMM_SELF) {
  const auto all = verdicts(plate + walls + "[[expect]]\n" + expect, comm);
  EXPECT_EQ(all.size(), 1u);
  return all.at(0);
}

void refused(const std::string& expect, const std::vector<std::string>& words) {
  expect_error([&] { verdict(expect); }, words);
}

TEST(Expectations, CompareAProbe) {
  const Verdict v = verdict("probe = \"p\"\nvalue = \"315.2 K\"\nwithin = \"0.3 K\"\nsource = \"by hand\"");
  EXPECT_EQ(v.norm, "value");
  EXPECT_EQ(v.unit, "K");
  EXPECT_NEAR(v.value, 315, 1e-9);
  EXPECT_EQ(v.reference, 315.2);
  EXPECT_NEAR(v.error, 0.2, 1e-9);
  EXPECT_EQ(v.tolerance, 0.3);
  EXPECT_TRUE(v.passed);
  EXPECT_NE(v.what.find("probe p"), std::string::npos);
  EXPECT_EQ(v.source, "by hand");
  EXPECT_FALSE(verdict("probe = \"p\"\nvalue = \"315.2 K\"\nwithin = \"0.1 K\"").passed);
  EXPECT_TRUE(verdict("probe = \"p\"\nvalue = \"41.85 degC\"\nwithin = \"0.1 degC\"").passed);  // no offset
}

TEST(Expectations, CompareTheWholeField) {
  // The reference is off by x / 100: 0 to 0.04 K.
  const std::string value = "field = true\nvalue = { formula = \"300 + 10.01*x\", unit = \"K\" }\n";
  const Verdict largest = verdict(value + "within = \"0.05 K\"");
  EXPECT_EQ(largest.norm, "max");
  EXPECT_NEAR(largest.error, 0.04, 1e-9);
  EXPECT_TRUE(largest.passed);
  const Verdict rms = verdict(value + "norm = \"rms\"\nwithin = \"0.02 K\"");
  EXPECT_NEAR(rms.error, 0.01 * std::sqrt((0 + 1 + 4 + 9 + 16) / 5.), 1e-9);
  EXPECT_FALSE(rms.passed);
}

TEST(Expectations, CompareRelatively) {
  // Reference 300 + 9.99 x: the difference 0.01 x is largest at x = 4 m.
  const std::string value = "field = true\nvalue = { formula = \"300 + 9.99*x\", unit = \"K\" }\nwithin = \"0.1 %\"\n";
  const Verdict of_value = verdict(value);
  EXPECT_EQ(of_value.unit, "%");
  EXPECT_EQ(of_value.tolerance, 0.1);
  EXPECT_NEAR(of_value.error, 100 * 0.04 / 339.96, 1e-9);
  EXPECT_NEAR(verdict(value + "of = \"maximum\"").error, 100 * 0.04 / 339.96, 1e-9);
  const Verdict of_range = verdict(value + "of = \"range\"");
  EXPECT_NEAR(of_range.error, 100 * 0.04 / 39.96, 1e-8);
  EXPECT_FALSE(of_range.passed);
}

TEST(Expectations, CompareSelectedPoints) {
  const Verdict v = verdict(
      "where = \"x < 2500\"\nlength = \"mm\"\nvalue = { formula = \"300 + 10.01*x\", unit = \"K\" }\nwithin = "
      "\"0.05 K\"");
  EXPECT_NEAR(v.error, 0.02, 1e-9);
  refused("where = \"x > 5\"\nvalue = \"300 K\"\nwithin = \"1 K\"", {"test.toml:17:9", "selects no point"});
}

TEST(Expectations, KnowErrorsThatAreExpected) {
  const std::string value =
      "field = true\nvalue = { formula = \"300 + 10.01*x\", unit = \"K\" }\nwithin = \"0.05 K\"\n";
  EXPECT_TRUE(verdict(value + "at_least = \"0.03 K\"").passed);
  EXPECT_FALSE(verdict(value + "at_least = \"0.045 K\"").passed);
  refused(value + "at_least = \"3 %\"", {"do not match"});
}

TEST(Expectations, InterpolateAReferenceByCubics) {
  const TemporaryFolder folder;
  const std::string file = folder / "line.csv";
  std::string rows = "x [mm],T [degC],wrong [K]\n";
  for (const double x : {-0.5, 0.7, 1.6, 2.2, 3.1, 4.4})  // unevenly, none on a point: 300 + 10 x + x^3 / 50
    rows += fmt::format("{},{},0\n", 1000 * x, 300 + 10 * x + x * x * x / 50 - 273.15);
  write_file(file, rows);
  const std::string reference = fmt::format("reference = \"{}\"\nwithin = \"2 K\"\n", file);
  EXPECT_NEAR(verdict("field = true\n" + reference).error, 64 / 50., 1e-9);
  EXPECT_NEAR(verdict("where = \"x < 1.5\"\n" + reference).error, 1 / 50., 1e-9);
  refused("field = true\n" + reference + "column = \"Tx\"", {"line.csv", "Tx"});
  write_file(file, "x [m],T [K]\n0,300\n2,320\n3,330\n3.5,335\n");
  refused("field = true\n" + reference, {"goes from x = 0 to 3.5 m", "lies at 4 m"});
  EXPECT_NEAR(verdict("where = \"x < 3.5\"\n" + reference).error, 0, 1e-9);
  write_file(file, "x [m],T [K]\n0,300\n2,320\n2,321\n4,340\n");
  refused("field = true\n" + reference, {"more than one row for x = 2 m"});
}

TEST(Expectations, MatchRowsToPoints) {
  const TemporaryFolder folder;
  const std::string file = folder / "points.csv";
  const std::string reference = fmt::format("field = true\nreference = \"{}\"\nwithin = \"2 K\"\n", file);
  // Two rows lie on points, the third on none.
  write_file(file, "y [m],x [m],T [K],B\n1,2,320.5,1\n2,3,330.25,1\n0.5,3,0,1\n");
  EXPECT_NEAR(verdict(reference).error, 0.5, 1e-9);
  EXPECT_NEAR(verdict(reference + "norm = \"rms\"").error, std::sqrt((0.25 + 0.0625) / 2), 1e-9);
  write_file(file, "y [m],x [m],T [K],B\n1,2,320.5,1\n1,2,330.25,2\n");
  refused(reference, {"more than one row for the point (2, 1, 0) m", "filter"});
  EXPECT_NEAR(verdict(reference + "filter = { B = 1 }").error, 0.5, 1e-9);
  refused(reference + "filter = { B = 3 }", {"no row", "passes the filter"});
  write_file(file, "y [m],x [m],T [K]\n1.1,2,320.5\n");
  refused(reference, {"no row of", "lies on a point"});
}

TEST(Expectations, BoundNumbersOfTheReport) {
  const auto all = verdicts(plate + walls +
                            "[[expect]]\nreport = \"points\"\nat_most = 14\n[[expect]]\nreport = \"points\"\nat_least "
                            "= 15\n");
  ASSERT_EQ(all.size(), 2u);
  EXPECT_FALSE(all[0].passed);
  EXPECT_EQ(all[0].error, 15);
  EXPECT_TRUE(all[1].passed);
}

TEST(Expectations, RefuseWhatTheyCannotCompare) {
  refused("value = \"300 K\"\nwithin = \"1 K\"", {"does not say what it is about", "probe"});
  refused("field = true\nprobe = \"p\"\nvalue = \"300 K\"\nwithin = \"1 K\"", {"in one [[expect]]"});
  refused("field = true\nwithin = \"1 K\"", {"what to compare with"});
  refused("field = true\nvalue = \"300 K\"", {"within"});
  refused("field = true\nvalue = \"300 K\"\nwithin = \"-1 K\"", {"negative"});
  refused("field = true\nvalue = \"300 K\"\nwithin = \"1 m\"", {"no difference of temperatures"});
  refused("field = true\nvalue = \"300 K\"\nwithin = [\"1 K\", \"2 K\"]", {"2 differences for 1 times"});
  refused("field = true\nat = \"1 s\"\nvalue = \"300 K\"\nwithin = \"1 K\"", {"steady case has no times"});
  refused("probe = \"q\"\nvalue = \"300 K\"\nwithin = \"1 K\"", {"no probe 'q'", "p"});
  refused("field = true\nvalue = { formula = \"T\", unit = \"K\" }\nwithin = \"1 K\"", {"depends on T"});
  refused("report = \"points\"", {"no bound"});
  refused("report = \"point\"\nat_most = 1", {"no number 'point'", "did you mean 'points'? it has points, "});
  refused("report = \"points\"\nat_most = \"3 K\"", {"a number without unit is needed"});
  const Error none = error_of([] { verdict("field = true\nreference = \"nowhere.csv\"\nwithin = \"1 K\""); });
  EXPECT_EQ(none.fault(), Fault::file);
}

// ---- in time --------------------------------------------------------------------------------------------------------

/// Heated by 1 K/s everywhere.
const std::string oven =
    box_case({"4 m", "2 m"}, {5, 3}) + simple_material({.k = "1", .rho = "10", .c = "10"}) + R"toml(
[source.s]
power_density = "100 W/m^3"
[initial]
temperature = "300 K"
[time]
end = "4 s"
[probe]
p = ["1.5 m", "0.5 m"]
)toml";

TEST(Expectations, CompareAtTheirTimes) {
  const auto all = verdicts(oven + R"toml(
[[expect]]
probe = "p"
at = ["0 s", "1.3 s", "4 s"]
value = { formula = "300 + 1.1*t", unit = "K" }
within = ["1e-9 K", "0.2 K", "0.3 K"]
[[expect]]
field = true
at = ["1 s", "2.7 s", "0.3 s"]
value = { formula = "300 + 1.1*t", unit = "K" }
within = "0.25 K"
[[expect]]
probe = "p"
value = "304 K"
within = "1e-6 K"
)toml");
  ASSERT_EQ(all.size(), 5u);
  EXPECT_NEAR(all[0].error, 0, 1e-9);
  EXPECT_NEAR(all[1].error, 0.13, 1e-6);
  EXPECT_TRUE(all[1].passed);
  EXPECT_NEAR(all[2].error, 0.4, 1e-6);
  EXPECT_FALSE(all[2].passed);
  EXPECT_NEAR(all[3].error, 0.27, 1e-6);  // one verdict for all times: the worst of them
  EXPECT_FALSE(all[3].passed);
  EXPECT_NE(all[3].what.find("worst at 2.7 s"), std::string::npos) << all[3].what;
  EXPECT_TRUE(all[4].passed);  // at the end
  const Error late = error_of(
      [] { verdicts(oven + "[[expect]]\nprobe = \"p\"\nat = \"5 s\"\nvalue = \"304 K\"\nwithin = \"1 K\"\n"); });
  expect_words(late.what(), {"5 s is not between the start and the end"});
}

TEST(Expectations, TakeTheRowsOfTheirTimes) {
  const TemporaryFolder folder;
  const std::string file = folder / "history.csv";
  write_file(file, "t [s],T [K]\n1,301.5\n2,302\n4,304\n");
  const std::string expect = fmt::format("[[expect]]\nprobe = \"p\"\nreference = \"{}\"\nwithin = \"0.1 K\"\n", file);
  const auto all = verdicts(oven + expect + "at = [\"1 s\", \"2 s\"]\n");
  ASSERT_EQ(all.size(), 1u);
  EXPECT_NEAR(all[0].error, 0.5, 1e-6);
  const Error none = error_of([&] { verdicts(oven + expect + "at = \"3 s\"\n"); });
  expect_words(none.what(), {"has no rows at 3 s", "1, 2, 4 s"});

  write_file(file, "t [s],x [m],T [K]\n1,0,301\n1,2,301\n1,4,301.25\n2,0,302\n2,4,302\n");
  const auto field = verdicts(
      oven + fmt::format("[[expect]]\nfield = true\nat = [\"1 s\", \"2 s\"]\nreference = \"{}\"\nwithin = [\"0.3 "
                         "K\", \"0.1 K\"]\n",
                         file));
  ASSERT_EQ(field.size(), 2u);
  EXPECT_NEAR(field[0].error, 0.25, 1e-6);
  EXPECT_NEAR(field[1].error, 0, 1e-6);
}

TEST(Expectations, CompareWithTheEndWhereTheRunBecameSteadyBefore) {
  // A body at rest is steady at once; what was expected later is compared with the end.
  const auto all = verdicts(body +
                            "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"10 s\"\nsteady_below = \"1e-6 "
                            "K/s\"\n[[expect]]\nfield = true\nat = \"9 s\"\nvalue = \"300 K\"\nwithin = \"1e-9 K\"\n");
  ASSERT_EQ(all.size(), 1u);
  EXPECT_TRUE(all[0].passed);
}

TEST(ExpectationsParallel, AreTheSameOnAnyNumberOfRanks) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const std::string line = folder.write("line.csv", "x [m],T [K]\n0,300\n1,310.2\n2.5,325\n4,340\n"),
                    points = folder.write("points.csv", "x [m],y [m],T [K]\n0,0,300.25\n2,1,320.5\n4,2,340\n");
  for (const std::string& expect :
       {fmt::format("field = true\nreference = \"{}\"\nwithin = \"1 K\"", line),
        fmt::format("field = true\nreference = \"{}\"\nwithin = \"1 %\"\nnorm = \"rms\"\nof = \"range\"", points),
        std::string("probe = \"p\"\nvalue = \"316 K\"\nwithin = \"2 K\""),
        std::string("where = \"x < 0.5 && y < 0.5\"\nvalue = \"301 K\"\nwithin = \"2 K\"")}) {
    const Verdict a = verdict(expect), b = verdict(expect, MPI_COMM_WORLD);
    EXPECT_NEAR(a.error, b.error, 1e-9) << expect;
    EXPECT_EQ(a.passed, b.passed);
  }
}

}  // namespace
}  // namespace calor
