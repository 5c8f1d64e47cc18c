// What a run says to people, and files whose rows can be compared.
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "case_models.hpp"
#include "output/report.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// A plate between two temperatures, which starts at the lower one.
const std::string plate = R"toml(title = "plate"
method = "sph"
[cloud]
shape = "box"
size = ["20 mm", "10 mm"]
points = [11, 6]
[material.steel]
conductivity = "40 W/(m K)"
density = "7850 kg/m^3"
specific_heat = "470 J/(kg K)"
[initial]
temperature = "20 degC"
[boundary.hot]
on = "xmin"
temperature = "120 degC"
[boundary.cold]
on = "xmax"
temperature = "20 degC"
[probe]
middle = ["10 mm", "5 mm"]
[time]
end = "10 s"
)toml";

TemperatureUnit in(const std::string& unit) {
  return TemperatureUnit::of(parse_case(plate + "[output]\ntemperature = \"" + unit + "\"\n"));
}

TEST(Verdict, SaysComputedExpectedDifferenceAndAllowed) {
  const Verdict v{.what = "probe hot at 60 s",
                  .norm = "value",
                  .unit = "K",
                  .error = 160,
                  .tolerance = 1,
                  .value = 313.15,
                  .reference = 473.15,
                  .value_unit = "K"};
  EXPECT_EQ(line(v, in("degC")), "FAIL  probe hot at 60 s: 40.0 degC, expected 200.0 degC, off by 160 K, allowed 1 K");
  EXPECT_EQ(sentence(v), "probe hot at 60 s: 313.1 K, expected 473.1 K, off by 160 K, allowed 1 K");
  EXPECT_EQ(sentence(v, in("degF")),
            "probe hot at 60 s: 104.0 degF, expected 392.0 degF, off by 288 degF, allowed 1.8 degF");
  EXPECT_EQ(status(v, true), "\x1b[1m\x1b[31mFAIL\x1b[0m");
}

TEST(Verdict, SaysWhereAFieldIsOffMost) {
  const Verdict v{.what = "all points",
                  .norm = "rms",
                  .unit = "%",
                  .error = 2,
                  .tolerance = 1,
                  .value = 10.3,
                  .reference = 10,
                  .value_unit = "K",
                  .least = 0.5,
                  .worst_place = {0.5, 2},
                  .source = "a book"};
  EXPECT_EQ(sentence(v),
            "all points: off by a root mean square of 2 %, allowed 0.5 to 1 %; most at (0.5, 2) m: 10.30 K, expected "
            "10.00 K (a book)");
}

TEST(Verdict, SaysWhatIsAllowedToANumberOfTheReport) {
  EXPECT_EQ(sentence({.what = "steps", .norm = "at least", .unit = "", .error = 3, .tolerance = 5, .value = 3}),
            "steps: 3, allowed at least 5");
  EXPECT_EQ(sentence({.what = "steps (did you mean step?)", .norm = "at most", .unit = "", .error = NAN}),
            "steps (did you mean step?): there is no number to compare");
}

TEST(Verdict, NamesThePointThatIsWrong) {
  const RunResult result = run_into("", plate + R"toml(
[[expect]]
field = true
value = { formula = "x > 5 && x < 7 && y > 3 && y < 5 ? 0 : 100*(1 - x/20) + 20", length = "mm", unit = "degC" }
within = "1 K"
)toml");
  const Verdict& v = result.verdicts.at(0);
  EXPECT_FALSE(v.passed);
  ASSERT_EQ(v.worst_place.size(), 2u);
  EXPECT_NEAR(v.worst_place[0], 6e-3, 1e-15);
  EXPECT_NEAR(v.worst_place[1], 4e-3, 1e-15);
  EXPECT_EQ(v.reference, 273.15);
  EXPECT_NEAR(v.error, v.value - v.reference, 1e-12);
}

TEST(TemperatureUnit, IsRefusedWhereItIsNone) {
  expect_error([] { in("mm"); }, {"'temperature' = \"mm\"", "K, degC or degF"});
}

TEST(Summary, SaysWhatARunCameTo) {
  const RunResult result = run_into("", plate);
  const std::vector<std::string> lines = summary(result, in("degC"));
  const std::string text = fmt::format("{}", fmt::join(lines, "\n"));
  for (const std::string& line : lines) EXPECT_LE(line.size(), 80u) << line;
  for (const std::string part :
       {"points       66 in 2D, sph", "integrator   rkl2: explicit Euler would take ",
        "lowest       20.00 degC at (0.002, 0) m, 0 s", "highest      120.00 degC at (0, 0) m, 0 s", "in by hot",
        "out by cold", "stored", "imbalance", "time "})
    EXPECT_NE(text.find(part), text.npos) << part << " in\n" << text;
  // What came in less what went out is what is stored.
  EXPECT_NEAR(result.numbers.at("stored"), result.numbers.at("heat.hot") + result.numbers.at("heat.cold"),
              1e-12 * result.numbers.at("heat.hot"));
}

TEST(Summary, OfASteadyCaseHasHeatFlowsAndNoTimes) {
  const RunResult result = run_into("", replaced(plate, "[time]\nend = \"10 s\"", "[steady]"));
  const std::string text = fmt::format("{}", fmt::join(summary(result), "\n"));
  // 40 W/(m K) * 100 K / 20 mm * 10 mm * 1 m
  EXPECT_NE(text.find("heat flow    out by cold 2 kW, in by hot 2 kW"), text.npos) << text;
  EXPECT_NE(text.find("highest      393.15 K at (0, 0) m\n"), text.npos) << text;
}

TEST(SummaryParallel, AndFilesDoNotDependOnTheRanks) {
  const std::string text = plate + "[output]\nprobes = \"every 2.5 s\"\nfields = false\n";
  const TemporaryFolder alone, together(MPI_COMM_WORLD);
  const RunResult one = run_into(alone.path(), text), all = run_into(together.path(), text, MPI_COMM_WORLD);
  EXPECT_EQ(one.highest.x, all.highest.x);
  EXPECT_EQ(one.lowest.x, all.lowest.x);
  EXPECT_EQ(one.lowest.T, all.lowest.T);
  MPI_Barrier(MPI_COMM_WORLD);
  const CsvTable probes = read_csv(together / "probes.csv"), end = read_csv(together / "final.csv"),
                 expected = read_csv(alone / "final.csv");
  std::vector<double> times;
  for (const auto& row : probes.rows) times.push_back(row[0]);
  EXPECT_EQ(times, (std::vector<double>{0, 2.5, 5, 7.5, 10}));
  ASSERT_EQ(end.rows.size(), 66u);
  for (std::size_t n = 0; n < end.rows.size(); ++n) {
    EXPECT_EQ(end.rows[n][0], static_cast<double>(n));
    EXPECT_NEAR(end.rows[n][4], expected.rows[n][4], 1e-9);
  }
}

TEST(ProbeRows, ThatAreNoTimesAreRefused) {
  for (const auto& [text, problem] : {std::pair{"often", "'probes' cannot be"},
                                      {"every 0 s", "every 0 s"},
                                      {"every 1 m", "cannot be converted"},
                                      {"every 1 ns", "rows of probes.csv"}})
    expect_error([&] { run_into("", plate + "[output]\nprobes = \"" + text + "\"\n"); }, {problem});
}

}  // namespace
}  // namespace calor
