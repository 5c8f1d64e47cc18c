#include "output/report.hpp"

#include <fmt/format.h>
#include <petscversion.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/parallel.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* earlier = "/report.earlier.json";

std::string mpi_version() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING];
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string whole(text, static_cast<std::size_t>(length));
  return whole.substr(0, whole.find_first_of(",\n"));
}

/// As Json has no NaN and no infinity it writes null for them.
Json json(const Verdict& v) {
  return {{"what", v.what},
          {"norm", v.norm},
          {"unit", v.unit},
          {"error", v.error},
          {"tolerance", v.tolerance},
          {"passed", v.passed},
          {"value", v.value},
          {"reference", v.reference},
          {"value_unit", v.value_unit},
          {"worst_place", v.worst_place.empty() ? Json() : Json(v.worst_place)},
          {"source", v.source}};
}

Json json(const Extreme& extreme) { return {{"T", extreme.T}, {"t", extreme.t}, {"x", extreme.x}}; }

/// The words that a shell needs to repeat the run where it was started.
std::vector<std::string> command_of(const RunResult& result, MPI_Comm comm) {
  std::vector<std::string> words = result.command;
  if (!words.empty() && size_of(comm) > 1) words.insert(words.end(), {"-j", std::to_string(size_of(comm))});
  return words;
}

}  // namespace

bool RunResult::passed() const { return !is_cut_short() && std::ranges::all_of(verdicts, &Verdict::passed); }

void set_report_aside(MPI_Comm comm, const std::string& folder) {
  if (folder.empty()) return;
  collective_try(comm, [&] {
    const std::string report = folder + "/report.json";
    if (rank_of(comm) == 0 && std::rename(report.c_str(), (folder + earlier).c_str()) != 0 && errno != ENOENT)
      refuse_writing(report, errno);
  });
}

void write_report(MPI_Comm comm, const std::string& folder, const Case& c, const RunResult& result,
                  const Phases& phases) {
  if (folder.empty()) return;
  Json seconds = Json::object();
  for (const auto& [name, timing] : phases.timings()) {
    const double wall = max(comm, timing.wall), cpu = sum(comm, std::span(&timing.cpu, 1));
    seconds[name] = {{"wall", wall}, {"cpu", cpu}};
  }
  Json report = {{"name", c.name()},
                 {"file", std::filesystem::absolute(c.path()).lexically_normal().string()},
                 {"command", command_of(result, comm)}};
  for (const auto& [name, text] : result.texts) report[name] = text;
  report["versions"] = {
      {"calor", CALOR_VERSION},
      {"petsc", fmt::format("{}.{}.{}", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR)},
      {"mpi", mpi_version()}};
  report["temperatures"] = {{"lowest", json(result.lowest)}, {"highest", json(result.highest)}};
  report["numbers"] = result.numbers;
  report["units"] = result.units;
  report["seconds"] = std::move(seconds);
  report["passed"] = result.passed();
  report["expect"] = Json::array();
  for (const Verdict& v : result.verdicts) report["expect"].push_back(json(v));
  report["case"] = Json::parse(c.json());
  const std::string text = report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  make_folder(comm, folder);
  collective_try(comm, [&] {
    if (rank_of(comm) != 0) return;
    replace_file(folder + "/report.json", text);
    std::remove((folder + earlier).c_str());
  });
}

}  // namespace calor
