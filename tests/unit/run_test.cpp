#include "app/run.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "case_models.hpp"
#include "output/files.hpp"
#include "output/vtu.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// A graded plate with all kinds of conditions; integrators and steps are added.
const std::string plate = R"toml(method = "sph"
title = "a \"plate\" & <more>"
[cloud]
shape = "box"
size = ["40 mm", "30 mm"]
points = [9, 7]
thickness = "5 mm"
[material.a]
library = "alumina"
specific_heat = "1178 J/(kg K)"
[material.b]
library = "zirconia"
[material.m]
mix = "voigt"
phases = ["a", "b"]
fraction = { formula = "x/40", length = "mm" }
basis = "volume"
[initial]
temperature = { formula = "600 + 5000*x", unit = "K" }
[boundary.hot]
on = "xmin"
temperature = { formula = "700 + 20*t", unit = "K" }
[boundary.air]
on = ["xmax", "ymax"]
convection = { h = { formula = "200 + 0.1*T", unit = "W/(m^2 K)" }, ambient = "300 K" }
radiation = { emissivity = 0.7, ambient = "300 K" }
[source.wire]
power_density = { table = [[0, 0], [0.7, 2e6], [2, 0]], unit = "W/m^3", of = "time" }
[probe]
centre = ["20 mm", "15 mm"]
corner = ["0.04 m", "0.03 m"]
)toml";

/// Its line under [initial].
const std::string start = "temperature = { formula = \"600 + 5000*x\", unit = \"K\" }";
const std::string constant_walls = replaced(plate, "700 + 20*t", "700");

/// Temperatures of final.csv in the order of the ids.
std::vector<double> final_temperatures(const std::string& folder) {
  const CsvTable table = read_csv(folder + "/final.csv");
  EXPECT_EQ(table.header, (std::vector<std::string>{"id", "x [m]", "y [m]", "z [m]", "T [K]"}));
  std::vector<double> T(table.rows.size(), NAN);
  for (const auto& row : table.rows) T.at(static_cast<std::size_t>(row[0])) = row[4];
  return T;
}

TEST(Run, WritesTheFoldersOfItsContract) {
  const TemporaryFolder folder;
  const RunResult result = run_into(folder.path(), plate + R"toml(
[time]
end = "2 s"
[output]
every = "0.8 s"
times = ["0.5 s"]
[[expect]]
probe = "centre"
value = "700 K"
within = "50 %"
source = "a guess, \\ and \"quotes\""
)toml");
  // probes.csv and energy.csv end with the end, and have the times of the fields and of the table among them.
  const CsvTable probes = read_csv(folder / "probes.csv"), energy = read_csv(folder / "energy.csv");
  EXPECT_EQ(probes.header, (std::vector<std::string>{"time [s]", "centre [K]", "corner [K]"}));
  EXPECT_EQ(energy.header,
            (std::vector<std::string>{"time [s]", "stored [J]", "through hot [J]", "through air [J]", "from wire [J]",
                                      "asked of wire [W]", "deposited by wire [W]", "imbalance"}));
  for (const CsvTable* table : {&probes, &energy}) {
    EXPECT_EQ(table->rows.front()[0], 0);
    EXPECT_EQ(table->rows.back()[0], 2);
    EXPECT_GE(table->rows.size(), 6u);
    for (std::size_t n = 1; n < table->rows.size(); ++n) EXPECT_GT(table->rows[n][0], table->rows[n - 1][0]);
    for (const double t : {0.5, 0.7, 0.8, 1.6})
      EXPECT_EQ(std::ranges::count(table->rows, t, [](const auto& row) { return row[0]; }), 1) << t;
  }
  for (const auto& row : energy.rows) {
    EXPECT_LE(row[7], 1e-12);
    EXPECT_NEAR(row[6], row[5], 1e-12 * row[5]);
    EXPECT_NEAR(row[1], row[2] + row[3] + row[4], 1e-12 * (std::abs(row[2]) + std::abs(row[3]) + std::abs(row[4])));
  }
  // The source gave the integral of its table over the plate.
  EXPECT_NEAR(energy.rows.back()[4], 2e6 * 2 / 2 * 40e-3 * 30e-3 * 5e-3, 1e-9);

  const Xml pvd = Xml::parse(read_file(folder / "fields.pvd"));
  EXPECT_EQ(pvd.attributes.at("type"), "Collection");
  std::vector<double> times;
  for (const Xml* set : pvd.all("DataSet")) {
    times.push_back(std::stod(set->attributes.at("timestep")));
    const Vtu vtu(folder / set->attributes.at("file"));
    EXPECT_EQ(std::stod(vtu.xml().find("DataArray", "TimeValue").text), times.back());
    EXPECT_EQ(vtu.points(), 63u);
  }
  EXPECT_EQ(times, (std::vector<double>{0, 0.5, 0.8, 1.6, 2}));
  EXPECT_EQ(final_temperatures(folder.path()).size(), 63u);
  EXPECT_EQ(result.interrupted_by, 0);
}

TEST(Run, WritesFieldsThatParaViewReads) {
  const TemporaryFolder folder;
  run_into(folder.path(), plate + "[time]\nend = \"0.5 s\"\n");
  const auto final_T = final_temperatures(folder.path());
  const Xml pvd = Xml::parse(read_file(folder / "fields.pvd"));
  const Vtu vtu(folder / pvd.all("DataSet").back()->attributes.at("file"));
  const std::size_t n = vtu.points();
  EXPECT_EQ(vtu.xml().find("Piece").attributes.at("NumberOfCells"), std::to_string(n));
  const auto x = vtu.values<double>("Points", 3), T = vtu.values<double>("temperature [K]", 1),
             q = vtu.values<double>("heat flux [W/m^2]", 3), k = vtu.values<double>("conductivity [W/(m K)]", 1),
             rho_c = vtu.values<double>("volumetric heat capacity [J/(m^3 K)]", 1);
  const auto id = vtu.values<std::int64_t>("id", 1), tag = vtu.values<std::int64_t>("tag", 1),
             connectivity = vtu.values<std::int64_t>("connectivity", 1),
             offsets = vtu.values<std::int64_t>("offsets", 1);
  const auto types = vtu.values<std::uint8_t>("types", 1);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(T[i], final_T.at(id[i]));
    const double a = x[3 * i] / 40e-3;
    const double alumina = 5.85 + 26524.4 * std::exp(-0.002 * T[i]) / (242.85 + T[i]);
    EXPECT_NEAR(k[i], (1 - a) * alumina + a * 2.8, 1e-8);
    EXPECT_NEAR(rho_c[i], (1 - a) * 3984 * 1178 + a * 6050 * 600, 1e-3);
    EXPECT_EQ(tag[i], 0);
    EXPECT_EQ(connectivity[i], static_cast<std::int64_t>(i));
    EXPECT_EQ(offsets[i], static_cast<std::int64_t>(i + 1));
    EXPECT_EQ(types[i], 1);
    EXPECT_EQ(q[3 * i + 2], 0);
  }
  EXPECT_EQ(vtu.xml().find("PointData").attributes.at("Scalars"), "temperature [K]");
  const auto volume = vtu.values<double>("volume [m^3]", 1), spacing = vtu.values<double>("spacing [m]", 1);
  EXPECT_NEAR(std::reduce(volume.begin(), volume.end()), 40e-3 * 30e-3 * 5e-3, 1e-18);
  EXPECT_NEAR(std::ranges::max(spacing), 5e-3, 1e-15);
  EXPECT_EQ(vtu.values<std::int64_t>("part", 1), std::vector<std::int64_t>(n, 0));
  EXPECT_EQ(vtu.xml().find("DataArray", "part m").text, "0");
}

/// All pieces of the surface at the last time, in a result of several ranks.
std::vector<Vtu> last_surface(const std::string& folder) {
  const Xml pvd = Xml::parse(read_file(folder + "/surface.pvd"));
  const std::string file = pvd.all("DataSet").back()->attributes.at("file");
  std::vector<Vtu> pieces;
  if (file.ends_with(".vtp")) {
    pieces.emplace_back(folder + "/" + file);
    return pieces;
  }
  const Xml list = Xml::parse(read_file(folder + "/" + file));
  for (const Xml* piece : list.all("Piece")) pieces.emplace_back(folder + "/fields/" + piece->attributes.at("Source"));
  return pieces;
}

// Lines of a plate: their lengths times the thickness are the areas, and the fluxes of a section its heat flow.
TEST(RunParallel, WritesASurfaceWhoseFluxesAddUpToTheBalance) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  run_into(folder.path(), plate + "[time]\nend = \"0.5 s\"\n", MPI_COMM_WORLD);
  MPI_Barrier(MPI_COMM_WORLD);
  double area = 0, lines = 0, through_air = 0, through_insulation = 0;
  const std::vector<Vtu> pieces = last_surface(folder.path());
  ASSERT_EQ(pieces.size(), static_cast<std::size_t>(size_of(MPI_COMM_WORLD)));
  for (const Vtu& piece : pieces) {
    EXPECT_EQ(piece.xml().find("DataArray", "condition air").text, "1");
    const auto A = piece.values<double>("area [m^2]", 1),
               q = piece.values<double>("heat flux into the body [W/m^2]", 1), x = piece.values<double>("Points", 3);
    const auto condition = piece.values<std::int64_t>("condition", 1), face = piece.values<std::int64_t>("face", 1);
    for (std::size_t n = 0; n < A.size(); ++n) {
      area += A[n];
      lines += std::hypot(x[6 * n + 3] - x[6 * n], x[6 * n + 4] - x[6 * n + 1]);
      (condition[n] == 1 ? through_air : through_insulation) += condition[n] != 0 ? A[n] * q[n] : 0;
      const std::int64_t expected[] = {0, 1, -1, 1};  // xmin is hot; air at xmax and ymax
      EXPECT_EQ(condition[n], expected[face[n]]);
    }
  }
  EXPECT_NEAR(area, 2 * (40e-3 + 30e-3) * 5e-3, 1e-15);
  EXPECT_NEAR(lines, 2 * (40e-3 + 30e-3), 1e-14);
  const CsvTable balance = read_csv(folder / "balance.csv");
  ASSERT_EQ(balance.header[2], "heat flow through air [W]");
  EXPECT_NEAR(through_air, balance.rows.back()[2], 1e-12 * std::abs(through_air));
  EXPECT_LT(through_air, -1);
  EXPECT_EQ(through_insulation, 0);
}

TEST(Run, WritesTheTagsOfACloud) {
  const TemporaryFolder folder;
  Cloud cloud = *CaseModel(plate + "[time]\nend = \"1 s\"\n").model().cloud;
  cloud.tags = {"", "core <&>"};
  for (int i = 0; i < cloud.owned; ++i) cloud.tag[i] = i % 2;
  std::vector<double> T(cloud.owned, 300);
  const auto writer = make_vtu_writer({.cloud = cloud, .folder = folder.path()});
  writer->open();
  EXPECT_EQ(Xml::parse(read_file(folder / "fields.pvd")).all("DataSet").size(), 0u);
  writer->write(1. / 3, {{"temperature [K]", 1, T}}, {});
  const Vtu vtu(folder / "fields/fields_0000.vtu");
  const auto tag = vtu.values<std::int64_t>("tag", 1);
  for (int i = 0; i < cloud.owned; ++i) EXPECT_EQ(tag[i], i % 2);
  // Names are arrays of one integer: meshio reads no texts.
  EXPECT_EQ(vtu.xml().find("DataArray", "tag core <&>").text, "1");
  for (const Xml* array : vtu.xml().all("DataArray")) EXPECT_NE(array->attributes.at("type"), "String");
  EXPECT_EQ(std::stod(vtu.xml().find("DataArray", "TimeValue").text), 1. / 3);
}

TEST(Run, ReportsAllThatWasPromised) {
  const TemporaryFolder folder;
  const RunResult result = run_into(folder.path(), plate + R"toml(
[time]
end = "0.5 s"
[[expect]]
probe = "centre"
value = "700 K"
within = "50 %"
source = "a guess, \\ and \"quotes\""
[[expect]]
report = "points"
at_most = 1
)toml");
  EXPECT_FALSE(result.passed());
  const Json report = Json::parse(read_file(folder / "report.json"));
  EXPECT_EQ(report["method"].text, "sph");
  EXPECT_EQ(report["integrator"].text, "rkl2");
  for (const char* of : {"calor", "petsc", "mpi"}) EXPECT_FALSE(report["versions"][of].text.empty());
  const Json& numbers = report["numbers"];
  for (const char* name : {"points", "neighbours", "pairs", "volume", "volume_error", "area_sum", "moment_sum", "steps",
                           "rejected_steps", "rate_evaluations", "newton_iterations", "most_stages", "smallest_step",
                           "largest_step", "end", "energy_imbalance", "ranks", "memory_bytes", "weight_residual"})
    EXPECT_EQ(numbers[name].type, Json::Type::number) << name;
  EXPECT_EQ(numbers["points"].number, 63);
  EXPECT_EQ(numbers["end"].number, 0.5);
  EXPECT_EQ(numbers["ranks"].number, 1);
  EXPECT_NEAR(numbers["volume"].number, 40e-3 * 30e-3 * 5e-3, 1e-16);
  EXPECT_LE(numbers["energy_imbalance"].number, 1e-12);
  EXPECT_GT(numbers["memory_bytes"].number, 1e6);
  for (const char* phase : {"cloud", "weights", "march"})
    for (const char* clock : {"wall", "cpu"}) EXPECT_GE(report["seconds"][phase][clock].number, 0);

  EXPECT_FALSE(report["passed"].flag);
  ASSERT_EQ(report["expect"].list.size(), 2u);
  const Json& verdict = report["expect"].list[0];
  EXPECT_TRUE(verdict["passed"].flag);
  EXPECT_EQ(verdict["source"].text, "a guess, \\ and \"quotes\"");
  EXPECT_EQ(verdict["unit"].text, "%");
  EXPECT_EQ(verdict["tolerance"].number, 50);
  EXPECT_EQ(verdict["reference"].number, 700);
  EXPECT_FALSE(report["expect"].list[1]["passed"].flag);

  // The case with all its defaults.
  const Json& c = report["case"];
  EXPECT_EQ(c["title"].text, "a \"plate\" & <more>");
  EXPECT_EQ(c["cloud"]["thickness"].text, "5 mm");
  EXPECT_EQ(c["cloud"]["at"].text, "walls");
  EXPECT_EQ(c["cloud"]["jitter"].number, 0);
  EXPECT_EQ(c["sph"]["correction"].text, "consistent");
  EXPECT_EQ(c["time"]["integrator"].text, "automatic");
  EXPECT_EQ(c["time"]["safety"].number, 0.9);
  EXPECT_EQ(c["expect"].list[0]["norm"].text, "max");
}

TEST(Run, ReportsTheSteadyState) {
  const TemporaryFolder folder;
  run_into(folder.path(), plate + "[steady]\n");
  const Json report = Json::parse(read_file(folder / "report.json"));
  EXPECT_EQ(report["integrator"].text, "steady");
  EXPECT_GT(report["numbers"]["newton_iterations"].number, 0);
  EXPECT_LE(report["numbers"]["residual"].number, 1e-11);
  EXPECT_EQ(Xml::parse(read_file(folder / "fields.pvd")).all("DataSet").size(), 1u);
  EXPECT_EQ(read_csv(folder / "probes.csv").rows.size(), 1u);
}

TEST(Run, WritesEveryTimeOnceThoughItEndsInASteadyState) {
  const TemporaryFolder folder;
  run_into(folder.path(), constant_walls + "[time]\nend = \"10000 s\"\nsteady_below = \"1 mK/s\"\n");
  const CsvTable probes = read_csv(folder / "probes.csv");
  EXPECT_LT(probes.rows.back()[0], 10000);
  for (std::size_t n = 1; n < probes.rows.size(); ++n) EXPECT_GT(probes.rows[n][0], probes.rows[n - 1][0]);
}

TEST(Run, LetsAnInsulatedBodyComeToRest) {
  // No heat comes in, by no account; the mean of cos^2 is 1/2.
  const TemporaryFolder folder;
  const RunResult result =
      run_into(folder.path(), box_case({"1 m"}, {9}) + simple_material({.k = "1", .rho = "1", .c = "1"}) + R"toml(
[initial]
temperature = { formula = "300 + cos(pi*x)^2", unit = "K" }
[time]
end = "5 s"
)toml");
  EXPECT_LE(result.numbers.at("energy_imbalance"), 1e-12);
  for (const double T : final_temperatures(folder.path())) EXPECT_NEAR(T, 300.5, 1e-6);
  EXPECT_EQ(read_csv(folder / "energy.csv").header, (std::vector<std::string>{"time [s]", "stored [J]", "imbalance"}));
}

TEST(Run, WritesNoFieldsWhereNoneAreWanted) {
  const TemporaryFolder folder;
  run_into(folder.path(), plate + "[time]\nend = \"0.1 s\"\n[output]\nfields = false\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "fields.pvd"));
  EXPECT_TRUE(std::filesystem::exists(folder / "report.json"));
}

TEST(Run, StartsFromTheEndOfAnother) {
  // Nothing depends on time, so that a second run from the middle ends where one run ends.
  std::string text = constant_walls;
  const auto wire = text.find("[source.wire]"), after = text.find("[probe]");
  text.erase(wire, after - wire);
  const std::string steps = "integrator = \"euler\"\nstep = \"2 ms\"\n";
  const TemporaryFolder first, second, whole;
  run_into(first.path(), text + "[time]\nend = \"0.5 s\"\n" + steps);
  run_into(whole.path(), text + "[time]\nend = \"1 s\"\n" + steps);
  const std::string onwards = replaced(text, start, fmt::format("result = \"{}\"", first.path()));
  run_into(second.path(), onwards + "[time]\nend = \"0.5 s\"\n" + steps);
  const auto a = final_temperatures(whole.path()), b = final_temperatures(second.path());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(b[i] / a[i], 1, 1e-12);

  // A file of another cloud has no row for every point.
  const std::string coarser = replaced(onwards, "[9, 7]", "[5, 7]"), other = replaced(onwards, "[9, 7]", "[8, 7]");
  EXPECT_NO_THROW(run_into("", coarser + "[time]\nend = \"0.1 s\"\n"));  // has all its points there
  expect_refused(other + "[time]\nend = \"0.1 s\"\n", {"test.toml:19:10", "has no row for the point"});
}

TEST(Run, StartsFromACsvFile) {
  const TemporaryFolder folder;
  std::string rows = "id,T [degC]\n";
  for (int id = 62; id >= 0; --id) rows += fmt::format("{},{}\n", id, 100 + id);
  const std::string file = folder.write("start.csv", rows);
  const CaseModel m(replaced(plate, start, fmt::format("csv = \"{}\"", file)) + "[time]\nend = \"1 s\"\n");
  for (int i = 0; i < m.cloud().owned; ++i)
    EXPECT_NEAR(m.model().T_start[i], 373.15 + static_cast<double>(m.cloud().id[i]), 1e-10);
}

TEST(Run, RefusesAFolderThatCannotBeWritten) {
  const TemporaryFolder folder;
  write_file(folder / "file", "");
  expect_error([&] { run_into(folder / "file/results", plate + "[time]\nend = \"1 s\"\n"); }, {"cannot be written"},
               Fault::file);
}

TEST(Run, RefusesACaseThatIsNeitherSteadyNorTransient) {
  expect_refused(plate, {"neither [steady] nor [time]"});
  expect_refused(plate + "[steady]\n[time]\nend = \"1 s\"\n", {"both [steady] and [time]"});
}

TEST(Files, AppearWhenTheyAreComplete) {
  const TemporaryFolder folder;
  replace_file(folder / "a.txt", "first");
  replace_file(folder / "a.txt", "second");
  EXPECT_EQ(read_file(folder / "a.txt"), "second");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.txt.part"));
  EXPECT_EQ(error_of([&] { replace_file(folder / "none/a.txt", ""); }).fault(), Fault::file);
}

TEST(FilesParallel, AreWrittenRankAfterRank) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const int rank = rank_of(MPI_COMM_WORLD), ranks = size_of(MPI_COMM_WORLD);
  write_in_turns(MPI_COMM_WORLD, folder / "turns.csv", "rank",
                 [&](std::FILE* file) { fmt::print(file, "{}\n", rank); });
  MPI_Barrier(MPI_COMM_WORLD);
  const CsvTable table = read_csv(folder / "turns.csv");
  ASSERT_EQ(table.rows.size(), static_cast<std::size_t>(ranks));
  for (int r = 0; r < ranks; ++r) EXPECT_EQ(table.rows[r][0], r);
  EXPECT_EQ(error_of([&] { write_in_turns(MPI_COMM_WORLD, folder / "no/file.csv", "", [](std::FILE*) {}); }).fault(),
            Fault::file);
}

TEST(FilesParallel, OfRowsAreOnDiskWhenTheyWereAdded) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  CsvLog log(MPI_COMM_WORLD, folder / "deep/er/log.csv", "a,b");
  log.open();
  log.row(std::vector<double>{1. / 3, -2e-300});
  const CsvTable table = read_csv(folder / "deep/er/log.csv");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0], (std::vector<double>{1. / 3, -2e-300}));
  CsvLog().row(std::vector<double>{1});  // writes nothing
}

// ---- on several ranks -----------------------------------------------------------------------------------------------

/// Cases as they are shipped, small.
struct Small {
  std::string name, text;
  double allowed;  // relative
};
std::vector<Small> small_cases() {
  const std::string explicit_steps = "integrator = \"euler\"\nstep = \"5 ms\"\n";
  const std::string jittered = replaced(plate, "[9, 7]", "[9, 7]\njitter = 0.2");
  const std::string disc = R"toml(title = "test"
method = "sph"
[cloud]
shape = "cylinder"
radius = "15 mm"
height = "2.5 mm"
rings = 5
levels = 3
sector = "quarter"
[material.steel]
library = "stainless steel 304"
conductivity = { formula = "8 + 0.02*T", unit = "W/(m K)" }
specific_heat = { formula = "400 + 0.2*T", unit = "J/(kg K)" }
[initial]
temperature = "900 K"
[boundary.top]
convection = { h = { formula = "350/(1 + (r/11.7)^2)", unit = "W/(m^2 K)", length = "mm" }, ambient = "293 K" }
[boundary.side]
radiation = { emissivity = 0.8, ambient = "293 K" }
)toml";
  const std::string paper = plate + "[sph]\ncorrection = \"paper\"\n";
  const auto timed = [](const std::string& integrator, const std::string& step) {
    return fmt::format("[time]\nend = \"0.25 s\"\nintegrator = \"{}\"\nstep = \"{}\"\n", integrator, step);
  };
  return {{"euler on a lattice", plate + timed("euler", "5 ms"), 1e-12},
          {"euler on a jittered lattice", jittered + timed("euler", "5 ms"), 1e-12},
          {"rkl2 on a jittered lattice", jittered + timed("rkl2", "50 ms"), 1e-12},
          {"rkl2 on a cylinder", disc + timed("rkl2", "50 ms"), 1e-12},
          {"euler with algebraic walls", paper + timed("euler", "5 ms"), 1e-12},
          {"backward-euler", jittered + timed("backward-euler", "50 ms"), 1e-9},
          {"crank-nicolson", jittered + timed("crank-nicolson", "50 ms"), 1e-9},
          {"tr-bdf2 on a cylinder", disc + timed("tr-bdf2", "50 ms"), 1e-9},
          {"tr-bdf2 with steps of its own", plate + "[time]\nend = \"0.25 s\"\nintegrator = \"tr-bdf2\"\n", 1e-8},
          {"steady", plate + "[steady]\n", 1e-9},
          {"steady on a jittered lattice", jittered + "[steady]\n", 1e-9}};
}

TEST(RunParallel, GivesTheSameTemperaturesOnAnyNumberOfRanks) {
  const TemporaryFolder shared(MPI_COMM_WORLD), alone;
  for (const Small& small : small_cases()) {
    SCOPED_TRACE(small.name);
    const std::string text =
        small.text + (small.text.find("[output]") == small.text.npos ? "[output]\nfields = false\n" : "");
    const RunResult a = run_into(alone.path(), text), b = run_into(shared.path(), text, MPI_COMM_WORLD);
    MPI_Barrier(MPI_COMM_WORLD);
    const auto T = final_temperatures(alone.path()), T_shared = final_temperatures(shared.path());
    ASSERT_EQ(T.size(), T_shared.size());
    double worst = 0;
    for (std::size_t i = 0; i < T.size(); ++i) worst = std::max(worst, std::abs(T_shared[i] / T[i] - 1));
    EXPECT_LE(worst, small.allowed);
    for (const char* count : {"steps", "most_stages", "rate_evaluations"})
      if (a.numbers.contains(count)) {
        EXPECT_EQ(a.numbers.at(count), b.numbers.at(count)) << count;
      }
    EXPECT_EQ(a.numbers.at("volume"), b.numbers.at("volume"));
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

TEST(RunParallel, WritesAPieceARankForParaView) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const int ranks = size_of(MPI_COMM_WORLD);
  run_into(folder.path(), plate + "[time]\nend = \"0.1 s\"\n", MPI_COMM_WORLD);
  MPI_Barrier(MPI_COMM_WORLD);
  const Xml pvd = Xml::parse(read_file(folder / "fields.pvd"));
  ASSERT_EQ(pvd.all("DataSet").size(), 2u);
  const std::string file = pvd.all("DataSet").back()->attributes.at("file");
  std::vector<std::string> segments{file};
  std::vector<std::string> declared;
  if (ranks > 1) {
    EXPECT_EQ(file, "fields/fields_0001.pvtu");
    const Xml pvtu = Xml::parse(read_file(folder / file));
    EXPECT_EQ(pvtu.attributes.at("type"), "PUnstructuredGrid");
    segments.clear();
    for (const Xml* piece : pvtu.all("Piece")) segments.push_back("fields/" + piece->attributes.at("Source"));
    for (const Xml* array : pvtu.find("PPointData").all("PDataArray")) declared.push_back(array->attributes.at("Name"));
    EXPECT_EQ(pvtu.find("PPoints").all("PDataArray").size(), 1u);
  }
  EXPECT_EQ(segments.size(), static_cast<std::size_t>(ranks));
  std::vector<double> T(63, NAN);
  for (const std::string& piece : segments) {
    const Vtu vtu(folder / piece);
    std::vector<std::string> names;
    for (const Xml* array : vtu.xml().find("PointData").all("DataArray")) names.push_back(array->attributes.at("Name"));
    if (ranks > 1) {
      EXPECT_EQ(names, declared);
    }
    const auto id = vtu.values<std::int64_t>("id", 1);
    const auto values = vtu.values<double>("temperature [K]", 1);
    for (std::size_t i = 0; i < id.size(); ++i) T.at(id[i]) = values[i];
  }
  EXPECT_EQ(T, final_temperatures(folder.path()));
}

// ---- the command ----------------------------------------------------------------------------------------------------

/// Runs a shell command without what MPI left in the environment of this process; returns its exit code.
int shell(const std::string& command) {
  const std::string clean =
      "env -i PATH=\"$PATH\" HOME=\"$HOME\" TMPDIR=\"${TMPDIR:-/tmp}\" ASAN_OPTIONS=\"$ASAN_OPTIONS\" sh -c '" +
      command + "'";
  const int status = std::system(clean.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Command, StartsRanksItself) {
  const TemporaryFolder folder;
  write_file(folder / "case.toml", plate + "[time]\nend = \"0.1 s\"\n");
  ASSERT_EQ(shell(fmt::format("{} run {} -j 2 -o {} --quiet >{} 2>&1", CALOR_COMMAND, folder / "case.toml",
                              folder / "results", folder / "log")),
            0)
      << read_file(folder / "log");
  const Json report = Json::parse(read_file(folder / "results/report.json"));
  EXPECT_EQ(report["numbers"]["ranks"].number, 2);
  EXPECT_TRUE(std::filesystem::exists(folder / "results/fields/fields_0001_1.vtu"));
}

void expect_readable_after(const std::string& signal, int expected_code) {
  const TemporaryFolder folder;
  // Long enough never to end by itself, and with a row of the logs every hundred steps.
  write_file(folder / "case.toml",
             constant_walls +
                 "[time]\nend = \"1e5 s\"\nintegrator = \"euler\"\nstep = \"1 ms\"\n[output]\ntimes = [\"1 "
                 "s\"]\nsamples = 1000000\n");
  // The signal comes when the fields at 1 s are there.
  const std::string results = folder / "results";
  const int code =
      shell(fmt::format("{0} run {1} -o {2} --quiet >{3} 2>&1 & id=$!; until [ -e "
                        "{2}/fields/fields_0001.vtu ]; do sleep 0.02; kill -0 $id || break; done; kill "
                        "-{4} $id; wait $id",
                        CALOR_COMMAND, folder / "case.toml", results, folder / "log", signal));
  EXPECT_EQ(code, expected_code) << read_file(folder / "log");
  const Xml pvd = Xml::parse(read_file(results + "/fields.pvd"));
  for (const Xml* set : pvd.all("DataSet")) {
    const Vtu vtu(results + "/" + set->attributes.at("file"));
    for (const double T : vtu.values<double>("temperature [K]", 1)) EXPECT_GT(T, 200);
  }
  EXPECT_GE(pvd.all("DataSet").size(), 3u);  // the last one where it was interrupted
  const double end = std::stod(pvd.all("DataSet").back()->attributes.at("timestep"));
  const CsvTable probes = read_csv(results + "/probes.csv");
  EXPECT_EQ(probes.rows.back().front(), end);
  for (std::size_t n = 1; n < probes.rows.size(); ++n) EXPECT_GT(probes.rows[n][0], probes.rows[n - 1][0]);
  for (const auto& row : read_csv(results + "/energy.csv").rows) EXPECT_EQ(row.size(), 8u);
  EXPECT_EQ(Json::parse(read_file(results + "/report.json"))["numbers"]["end"].number, end);
  EXPECT_EQ(final_temperatures(results).size(), 63u);
}

TEST(Command, LeavesWhatWasFinishedReadableWhenInterrupted) {
  expect_readable_after("INT", 130);
  expect_readable_after("TERM", 143);
}

TEST(Command, TellsByItsExitCodeWhatHappened) {
  const TemporaryFolder folder;
  const auto code = [&](const std::string& text, const std::string& more = "") {
    write_file(folder / "case.toml", text);
    return shell(fmt::format("{} run {} -o {} --quiet {} >{} 2>&1", CALOR_COMMAND, folder / "case.toml",
                             folder / "results", more, folder / "log"));
  };
  const std::string end = "[time]\nend = \"0.01 s\"\n";
  EXPECT_EQ(code(plate + end), 0);
  EXPECT_EQ(code(plate + end + "[[expect]]\nprobe = \"centre\"\nvalue = \"1 K\"\nwithin = \"1 K\"\n"), 1);
  EXPECT_EQ(code(plate + end, "--no-such-option"), 2);
  EXPECT_EQ(code(plate + end, "cloud.points=[1,1]"), 3);
  EXPECT_EQ(code(plate + end, "-j 2 cloud.point=[1,1]"), 3);
  EXPECT_EQ(code(plate + end + "[output]\nfields = true\n", "-o /proc/no/such/folder"), 2);  // two folders
  EXPECT_EQ(code("no case"), 3);
  EXPECT_EQ(shell(fmt::format("{} run {} >{} 2>&1", CALOR_COMMAND, folder / "none.toml", folder / "log")), 4);
  EXPECT_EQ(
      shell(fmt::format("{} run {} -o /proc/no/such >{} 2>&1", CALOR_COMMAND, folder / "case.toml", folder / "log")),
      3);
}

}  // namespace
}  // namespace calor
