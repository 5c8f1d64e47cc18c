#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "app/run.hpp"
#include "app/say.hpp"
#include "app/schema.hpp"
#include "app/verbs.hpp"
#include "base/parallel.hpp"
#include "base/terminal.hpp"
#include "case/json.hpp"

namespace calor {
namespace {

/// All .toml files at or below the paths, sorted.
std::vector<std::string> case_files(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    if (!std::filesystem::exists(path))
      throw Error(Fault::file, {path}, "there is no such file or folder", "check the path");
    if (!std::filesystem::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path))
      if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
  }
  if (files.empty()) throw Error(Fault::file, {paths.front()}, "there is no case (*.toml) in it", "check the path");
  std::ranges::sort(files);
  return files;
}

/// One line of the table: verdict, case, what was compared.
void print(const std::string& name, const Verdict& v, const TemperatureUnit& unit) {
  if (v.passed)
    say(fmt::format("{}  {:<34} {:<60} {} {:.3g} of {:.3g} {}\n", status(v, stdout_takes_colour()), name, v.what,
                    v.norm, v.error, v.tolerance, v.unit));
  else
    say(fmt::format("{}  {:<34} {}\n", status(v, stdout_takes_colour()), name,
                    v.norm == "run" ? v.what : sentence(v, unit)));
  std::fflush(stdout);
}

}  // namespace

int verify(const std::vector<std::string>& paths, const std::string& json, MPI_Comm comm) {
  const bool speaks = rank_of(comm) == 0;
  int passed = 0, failed = 0;
  std::string entries;
  const auto book = [&](const std::string& name, const Verdict& v, const TemperatureUnit& unit = {}) {
    (v.passed ? passed : failed) += 1;
    if (!speaks) return;
    print(name, v, unit);
    const std::string what = v.what + (v.source.empty() ? "" : fmt::format(" ({})", v.source));
    entries += fmt::format(
        R"({}  {{"case": {}, "what": {}, "norm": {}, "unit": {}, "error": {}, "tolerance": {}, "passed": {}}})",
        entries.empty() ? "" : ",\n", json_string(name), json_string(what), json_string(v.norm), json_string(v.unit),
        json_number(v.error), json_number(v.tolerance), v.passed);
  };

  for (const std::string& file : case_files(paths)) {
    std::vector<std::vector<std::string>> runs{{}};
    for (std::size_t n = 0; n < runs.size(); ++n) {
      std::string name = file;
      try {
        const Case c = Case::read(file, schema(), runs[n]);
        name = c.name();
        if (n == 0)
          for (const std::string& variant : c.variants()) runs.push_back({"variant=" + variant});
        if (c.root().list("expect").empty()) continue;
        for (const Verdict& v : run(c, comm, {.folder = "", .quiet = true}).verdicts)
          book(name, v, TemperatureUnit::of(c));
      } catch (const Error& e) {
        book(name, {.what = e.what(), .norm = "run", .unit = "", .error = NAN, .tolerance = 0, .passed = false});
      }
    }
  }
  if (speaks) {
    say(fmt::format("{} passed, {} failed\n", passed, failed));
    if (!json.empty()) {
      std::ofstream out(json);
      out << "[\n" << entries << "\n]\n";
      if (!out) throw Error(Fault::file, {json}, "cannot be written", "choose another file for --json");
    }
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace calor
