// A run that is cut short and goes on is the run that was not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "app/run.hpp"
#include "app/schema.hpp"
#include "errors.hpp"
#include "output/files.hpp"
#include "results.hpp"

namespace calor {
namespace {

constexpr double at_once = 1e-9;  // s; a limit of time that is over after one step

/// A plate of two materials, one of which melts, with conditions and a source that depend on time and temperature.
const std::string plate = R"toml(title = "stored plate"
[cloud]
shape = "box"
size = ["40 mm", "30 mm"]
points = [9, 7]
[body]
material = "b"
[[body.region]]
where = "x < 0.018"
material = "a"
[material.a]
conductivity = { formula = "20 + 0.02*T", unit = "W/(m K)" }
density = "7800 kg/m^3"
specific_heat = { formula = "450 + 0.2*T + 2000*x", unit = "J/(kg K)" }
[material.b]
library = "stainless steel 304"
[initial]
temperature = { formula = "600 + 5000*x", unit = "K" }
[boundary.hot]
on = "xmin"
temperature = { formula = "700 + 20*t", unit = "K" }
[boundary.cold]
on = "ymin"
temperature = "650 K"
[boundary.air]
on = ["xmax", "ymax"]
convection = { h = { formula = "200 + 0.1*T", unit = "W/(m^2 K)" }, ambient = "300 K" }
radiation = { emissivity = 0.7, ambient = "300 K" }
[source.wire]
power_density = { table = [[0, 0], [0.37, 2e8], [2, 0]], unit = "W/m^3", of = "time" }
[probe]
centre = ["20 mm", "15 mm"]
corner = ["0.04 m", "0.03 m"]
[output]
times = ["0.1 s", "0.33 s"]
samples = 20
[[expect]]
probe = "centre"
at = ["0.1 s", "0.5 s"]
value = "700 K"
within = "50 %"
[[expect]]
mean = "b"
at = "0.33 s"
value = "700 K"
within = "50 %"
)toml";

/// A weld that melts a line of points and cools again.
const std::string weld = R"toml(title = "stored weld"
[cloud]
shape = "box"
size = ["60 mm", "10 mm"]
points = [25, 5]
thickness = "3 mm"
[material.steel]
conductivity = "40 W/(m K)"
density = "7850 kg/m^3"
specific_heat = "500 J/(kg K)"
latent_heat = "270 kJ/kg"
solidus = "1450 degC"
liquidus = "1460 degC"
[initial]
temperature = "20 degC"
[source.arc]
power = "3 kW"
half = true
column = { sigma = "3 mm" }
[[source.arc.pass]]
from = ["10 mm", "0 mm"]
to = ["50 mm", "0 mm"]
speed = "20 mm/s"
[boundary.air]
on = "ymax"
convection = { h = "100 W/(m^2 K)", ambient = "20 degC" }
[probe]
seam = ["30 mm", "1 mm"]
[weld]
isotherm = "1455 degC"
cooling = ["800 degC", "500 degC"]
[weld.extent.width]
from = ["30 mm", "0 mm"]
to = ["30 mm", "9 mm"]
[output]
every = "1 s"
samples = 30
)toml";

struct Stored {
  std::string name, text;
};

std::vector<Stored> stored_runs() {
  const auto timed = [](const std::string& keys) { return "[time]\nend = \"0.5 s\"\n" + keys; };
  const std::string sph = "method = \"sph\"\n" + plate, mlpg = "method = \"mlpg\"\n" + plate;
  const std::string crack =
      "[[crack]]\nx = [\"10 mm\", \"10 mm\"]\ny = [\"5 mm\", \"40 mm\"]\nopens = \"0.21 s\"\ncontact = \"10 W/(m^2 "
      "K)\"\n";
  const std::string cold = std::string("method = \"sph\"\n") + R"toml(title = "comes to rest"
[cloud]
shape = "box"
size = ["10 mm"]
points = [11]
[material.steel]
library = "stainless steel 304"
[initial]
temperature = { formula = "300 + 1e4*x", unit = "K" }
)toml";
  return {
      {"euler", sph + timed("integrator = \"euler\"\nsafety = 0.3\n")},
      {"euler with a step", sph + timed("integrator = \"euler\"\nstep = \"30 ms\"\n")},
      {"rkl2", sph + timed("integrator = \"rkl2\"\ntolerance = \"0.005 K\"\n")},
      {"rkl2 with a step", sph + timed("integrator = \"rkl2\"\nstep = \"40 ms\"\n")},
      {"backward-euler", sph + timed("integrator = \"backward-euler\"\nstep = \"40 ms\"\n")},
      {"crank-nicolson", sph + timed("integrator = \"crank-nicolson\"\nstep = \"40 ms\"\n")},
      {"tr-bdf2", sph + timed("integrator = \"tr-bdf2\"\ntolerance = \"0.005 K\"\n")},
      {"tr-bdf2 with a step", sph + timed("integrator = \"tr-bdf2\"\nstep = \"40 ms\"\n")},
      {"a crack opens", sph + crack + timed("integrator = \"tr-bdf2\"\nstep = \"30 ms\"\n")},
      {"a crack opens, explicit", sph + crack + timed("integrator = \"rkl2\"\ntolerance = \"0.005 K\"\n")},
      {"peridynamics",
       "method = \"peridynamics\"\n" + plate + timed("integrator = \"tr-bdf2\"\ntolerance = \"0.005 K\"\n")},
      {"mlpg", mlpg + timed("integrator = \"tr-bdf2\"\ntolerance = \"0.005 K\"\n")},
      {"mlpg, explicit",
       mlpg + "[mlpg]\nflux = \"edge-stabilised\"\n" + timed("integrator = \"rkl2\"\ntolerance = \"0.005 K\"\n")},
      {"weld", "method = \"sph\"\n" + weld + "[time]\nend = \"5 s\"\nintegrator = \"rkl2\"\n"},
      {"implicit weld", "method = \"sph\"\n" + weld + "[time]\nend = \"5 s\"\nintegrator = \"tr-bdf2\"\n"},
      {"comes to rest", cold + "[time]\nend = \"1 h\"\nintegrator = \"tr-bdf2\"\nsteady_below = \"1e-3 K/s\"\n"},
  };
}

/// Everything in a folder but what tells of the clock.
std::map<std::string, std::string> files_in(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = std::filesystem::relative(entry.path(), folder).string();
    if (entry.is_regular_file() && name != "run.log" && name != "report.json") files[name] = read_file(entry.path());
  }
  return files;
}

/// Cuts the run short after every `stride`-th step and lets it go on, until it has come to its end.
RunResult run_in_pieces(const Case& c, MPI_Comm comm, const std::string& folder, int& pieces) {
  RunResult result = run(c, comm, {.folder = folder, .quiet = true, .restart = false, .time_limit = at_once});
  for (pieces = 1; result.is_out_of_time; ++pieces) {
    EXPECT_FALSE(result.passed());
    result = run(c, comm, {.folder = folder, .quiet = true, .restart = true, .time_limit = at_once});
  }
  return result;
}

TEST(RestartParallel, GivesTheSameBitsAfterEveryStepOfEveryIntegrator) {
  for (const Stored& stored : stored_runs()) {
    SCOPED_TRACE(stored.name);
    const TemporaryFolder whole(MPI_COMM_WORLD), pieces(MPI_COMM_WORLD);
    const Case c = Case::parse(stored.text, "stored.toml", schema());
    RunResult a = run(c, MPI_COMM_WORLD, {.folder = whole.path(), .quiet = true});
    int count = 0;
    RunResult b = run_in_pieces(c, MPI_COMM_WORLD, pieces.path(), count);
    EXPECT_GE(count, 4);
    EXPECT_EQ(count, a.numbers.at("steps"));
    for (RunResult* result : {&a, &b}) result->numbers.erase("memory_bytes");
    EXPECT_EQ(a.numbers, b.numbers);
    for (Extreme RunResult::*which : {&RunResult::lowest, &RunResult::highest}) {
      EXPECT_EQ((a.*which).T, (b.*which).T);
      EXPECT_EQ((a.*which).t, (b.*which).t);
      EXPECT_EQ((a.*which).x, (b.*which).x);
    }
    ASSERT_EQ(a.verdicts.size(), b.verdicts.size());
    for (std::size_t n = 0; n < a.verdicts.size(); ++n) EXPECT_EQ(a.verdicts[n].error, b.verdicts[n].error);
    MPI_Barrier(MPI_COMM_WORLD);
    const auto files = files_in(whole.path()), files_of_pieces = files_in(pieces.path());
    EXPECT_EQ(files.size(), files_of_pieces.size());
    for (const auto& [name, text] : files) {
      const auto found = files_of_pieces.find(name);
      EXPECT_TRUE(found != files_of_pieces.end() && found->second == text) << name;
    }
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

std::string short_run() {
  return "method = \"sph\"\n" + plate + "[time]\nend = \"0.5 s\"\nintegrator = \"tr-bdf2\"\nstep = \"30 ms\"\n";
}

TEST(RestartParallel, GoesOnWithAnotherNumberOfRanks) {
  const TemporaryFolder whole, pieces(MPI_COMM_WORLD);
  const Case c = Case::parse(short_run(), "stored.toml", schema());
  run(c, MPI_COMM_SELF, {.folder = whole.path(), .quiet = true});
  for (int n = 0; n < 5; ++n)
    run(c, MPI_COMM_WORLD, {.folder = pieces.path(), .quiet = true, .restart = n > 0, .time_limit = at_once});
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    for (int n = 0; n < 3; ++n)
      run(c, MPI_COMM_SELF, {.folder = pieces.path(), .quiet = true, .restart = true, .time_limit = at_once});
  }
  MPI_Barrier(MPI_COMM_WORLD);
  run(c, MPI_COMM_WORLD, {.folder = pieces.path(), .quiet = true, .restart = true});
  MPI_Barrier(MPI_COMM_WORLD);
  for (const char* file : {"/probes.csv", "/energy.csv", "/balance.csv"}) {
    const CsvTable a = read_csv(whole.path() + file), b = read_csv(pieces.path() + file);
    ASSERT_EQ(a.rows.size(), b.rows.size()) << file;
    for (std::size_t n = 0; n < a.rows.size(); ++n)
      for (std::size_t k = 0; k + (file[1] == 'e' ? 1 : 0) < a.header.size(); ++k)  // the last is an imbalance
        EXPECT_NEAR(a.rows[n][k], b.rows[n][k], 1e-7 * std::abs(a.rows[n][k]) + 1e-9) << a.header[k] << n;
  }
}

TEST(Restart, FallsBackToTheOtherCheckpointWhereOneIsDamaged) {
  const TemporaryFolder whole, pieces;
  const Case c = Case::parse(short_run(), "stored.toml", schema());
  run(c, MPI_COMM_SELF, {.folder = whole.path(), .quiet = true});
  for (int n = 0; n < 4; ++n)
    run(c, MPI_COMM_SELF, {.folder = pieces.path(), .quiet = true, .restart = n > 0, .time_limit = at_once});
  // Steps 1, 2, 3 and 4 were stored in the slots 0, 1, 0 and 1.
  std::string bytes = read_file(pieces / "checkpoint-1");
  bytes[bytes.size() - 9] ^= 64;
  write_file(pieces / "checkpoint-1", bytes);
  run(c, MPI_COMM_SELF, {.folder = pieces.path(), .quiet = true, .restart = true});
  expect_words(read_file(pieces / "run.log"), {"checkpoint-1: the file does not match its checksum",
                                               "goes on from " + (pieces / "checkpoint-0"), "after 3 steps"});
  for (const char* file : {"/probes.csv", "/energy.csv", "/balance.csv", "/final.csv"})
    EXPECT_EQ(read_file(whole.path() + file), read_file(pieces.path() + file));
  EXPECT_FALSE(std::filesystem::exists(pieces / "checkpoint-0"));
  EXPECT_FALSE(std::filesystem::exists(pieces / "checkpoint-1"));
}

TEST(Restart, RefusesWhatItCannotGoOnFromAndSaysWhy) {
  const TemporaryFolder folder;
  const Case c = Case::parse(short_run(), "stored.toml", schema());
  const RunOptions again{.folder = folder.path(), .quiet = true, .restart = true};
  expect_error([&] { run(c, MPI_COMM_SELF, again); }, {"there is no checkpoint to go on from"}, Fault::file);
  run(c, MPI_COMM_SELF, {.folder = folder.path(), .quiet = true, .restart = false, .time_limit = at_once});
  const auto changed = [&](const std::vector<std::string>& overrides) {
    return Case::parse(short_run(), "stored.toml", schema(), overrides);
  };
  expect_error([&] { run(changed({"time.end=0.6 s"}), MPI_COMM_SELF, again); }, {"time.end is", "0.6", "0.5"});
  expect_error([&] { run(changed({"material.a.density=7801 kg/m^3"}), MPI_COMM_SELF, again); },
               {"material.a.density is"});
  expect_error([&] { run(changed({"sph.smoothing=1.3"}), MPI_COMM_SELF, again); }, {"sph.smoothing is"});
  expect_error([&] { run(changed({"probe.more=[\"1 mm\", \"1 mm\"]"}), MPI_COMM_SELF, again); },
               {"probe.more is", "here and absent there"});
  const std::string rows = read_file(folder / "probes.csv");
  write_file(folder / "probes.csv", rows.substr(0, rows.size() / 2));
  expect_error([&] { run(c, MPI_COMM_SELF, again); }, {"probes.csv: rows are missing"}, Fault::file);
  write_file(folder / "probes.csv", rows);
  for (const char* slot : {"checkpoint-0", "checkpoint-1"}) write_file(folder / slot, "nonsense");
  expect_error([&] { run(c, MPI_COMM_SELF, again); }, {"checkpoint-0: the file is too short", "checkpoint-1"},
               Fault::file);
}

TEST(Restart, MayChangeWhenItIsStored) {
  const TemporaryFolder folder;
  const RunOptions first{.folder = folder.path(), .quiet = true, .restart = false, .time_limit = at_once};
  run(Case::parse(short_run(), "stored.toml", schema()), MPI_COMM_SELF, first);
  const Case c = Case::parse(short_run(), "stored.toml", schema(), {"output.checkpoint_steps=2"});
  EXPECT_TRUE(run(c, MPI_COMM_SELF, {.folder = folder.path(), .quiet = true, .restart = true}).passed());
}

TEST(Restart, ResultsDoNotDependOnWhenARunIsStored) {
  const TemporaryFolder whole, stored;
  run(Case::parse(short_run(), "stored.toml", schema()), MPI_COMM_SELF, {.folder = whole.path(), .quiet = true});
  run(Case::parse(short_run(), "stored.toml", schema(), {"output.checkpoint_steps=1"}), MPI_COMM_SELF,
      {.folder = stored.path(), .quiet = true});
  EXPECT_EQ(files_in(whole.path()), files_in(stored.path()));
}

TEST(Restart, ASecondRunIntoAFolderIsRefusedWithTheFirstOnesProcess) {
  const TemporaryFolder folder;
  FolderLock lock(MPI_COMM_SELF, folder.path());
  lock.take();
  const Case c = Case::parse(short_run(), "stored.toml", schema());
  expect_error([&] { run(c, MPI_COMM_SELF, {.folder = folder.path(), .quiet = true}); },
               {folder.path(), fmt::format("another run writes into this folder: process {} on", getpid()), "since 20"},
               Fault::file);
}

TEST(Restart, ARunWhoseFolderIsTakenAwayDoesNotClaimResults) {
  const TemporaryFolder folder;
  FolderLock lock(MPI_COMM_SELF, folder / "results");
  lock.take();
  std::filesystem::rename(folder / "results", folder / "elsewhere");
  expect_error([&] { lock.require_folder(); }, {"has been removed or replaced"}, Fault::file);
  std::filesystem::create_directories(folder / "results");
  expect_error([&] { lock.require_folder(); }, {"has been removed or replaced"}, Fault::file);
}

}  // namespace
}  // namespace calor
