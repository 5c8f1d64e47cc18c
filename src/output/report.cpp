#include "output/report.hpp"

#include <fmt/format.h>
#include <petscversion.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include "base/parallel.hpp"
#include "case/json.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

constexpr const char* earlier = "/report.earlier.json";

std::string mpi_version() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING];
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string whole(text, static_cast<std::size_t>(length));
  return whole.substr(0, whole.find_first_of(",\n"));
}

std::string json(const std::vector<double>& numbers) {
  std::string list;
  for (const double number : numbers) list += (list.empty() ? "" : ", ") + json_number(number);
  return "[" + list + "]";
}

std::string json(const Verdict& v) {
  return fmt::format(
      R"({{"what": {}, "norm": {}, "unit": {}, "error": {}, "tolerance": {}, "passed": {}, "value": {}, "reference": {}, "value_unit": {}, "worst_place": {}, "source": {}}})",
      json_string(v.what), json_string(v.norm), json_string(v.unit), json_number(v.error), json_number(v.tolerance),
      v.passed, json_number(v.value), json_number(v.reference), json_string(v.value_unit),
      v.worst_place.empty() ? "null" : json(v.worst_place), json_string(v.source));
}

std::string json(const Extreme& extreme) {
  return fmt::format(R"({{"T": {}, "t": {}, "x": {}}})", json_number(extreme.T), json_number(extreme.t),
                     json(extreme.x));
}

/// `"name": value` a line, as an object.
std::string object(const std::vector<std::pair<std::string, std::string>>& members) {
  std::string text;
  for (const auto& [name, value] : members)
    text += fmt::format("{}\n    {}: {}", text.empty() ? "" : ",", json_string(name), value);
  return "{" + text + "\n  }";
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
  std::vector<std::pair<std::string, std::string>> counted, timed;
  for (const auto& [name, value] : result.numbers) counted.emplace_back(name, json_number(value));
  for (const auto& [name, timing] : phases.timings()) {
    const double wall = max(comm, timing.wall), cpu = sum(comm, std::span(&timing.cpu, 1));
    timed.emplace_back(name, fmt::format(R"({{"wall": {}, "cpu": {}}})", json_number(wall), json_number(cpu)));
  }
  std::string list;
  for (const Verdict& v : result.verdicts) list += fmt::format("{}\n    {}", list.empty() ? "" : ",", json(v));

  const std::string petsc = fmt::format("{}.{}.{}", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR);
  std::string text = fmt::format("{{\n  \"name\": {},\n", json_string(c.name()));
  for (const auto& [name, value] : result.texts)
    text += fmt::format("  {}: {},\n", json_string(name), json_string(value));
  text += fmt::format(
      "  \"versions\": {},\n  \"temperatures\": {},\n  \"numbers\": {},\n  \"seconds\": {},\n",
      object(
          {{"calor", json_string(CALOR_VERSION)}, {"petsc", json_string(petsc)}, {"mpi", json_string(mpi_version())}}),
      object({{"lowest", json(result.lowest)}, {"highest", json(result.highest)}}), object(counted), object(timed));
  text += fmt::format("  \"passed\": {},\n  \"expect\": [{}],\n  \"case\": {}\n}}\n", result.passed(),
                      list.empty() ? "" : list + "\n  ", c.json());
  make_folder(comm, folder);
  collective_try(comm, [&] {
    if (rank_of(comm) != 0) return;
    replace_file(folder + "/report.json", text);
    std::remove((folder + earlier).c_str());
  });
}

}  // namespace calor
