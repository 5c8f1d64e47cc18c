#include "output/checkpoint.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>

#include "base/parallel.hpp"
#include "case/json.hpp"

namespace calor {
namespace {

constexpr int slots = 2;

std::string slot_path(const std::string& folder, int slot) { return fmt::format("{}/checkpoint-{}", folder, slot); }

/// Keys that say when checkpoints are written, which no result depends on.
bool is_free(const std::string& key) { return key.starts_with("output.checkpoint"); }

void require_same_case(const Case& c, const CheckpointHead& head, const std::string& path) {
  const auto now = json_members(c.json()), then = json_members(head.case_json);
  const auto refuse = [&](const std::string& key, const std::string& here, const std::string& there) {
    throw Error(Fault::bad_case, SourceLocation{.file = c.path()},
                fmt::format("{} is of another case: {} is {} here and {} there", path, key, here, there),
                "restart with the case as it was, or run it anew without --restart");
  };
  std::set<std::string> known;
  for (const auto& [key, value] : now) {
    known.insert(key);
    const auto found = std::ranges::find(then, key, &std::pair<std::string, std::string>::first);
    if (is_free(key)) continue;
    if (found == then.end()) refuse(key, value, "absent");
    if (found->second != value) refuse(key, value, found->second);
  }
  for (const auto& [key, value] : then)
    if (!is_free(key) && !known.contains(key)) refuse(key, "absent", value);
}

}  // namespace

void CheckpointHead::exchange(Archive& archive) {
  archive.text("calor", version);
  archive.text("written", written);
  archive.value("processes", ranks);
  archive.value("step", steps);
  archive.value("t", t);
  archive.text("case", case_json);
}

StoredRun find_checkpoint(MPI_Comm comm, const std::string& folder, const Case& c) {
  std::optional<StoredRun> newest;
  std::vector<std::string> notes;
  for (int slot = 0; slot < slots; ++slot) {
    const std::string path = slot_path(folder, slot);
    if (!any(comm, rank_of(comm) == 0 && std::filesystem::exists(path))) continue;
    try {
      StoredRun found{.head = {}, .archive = std::make_unique<ArchiveReader>(comm, path), .slot = slot, .notes = {}};
      found.head.exchange(*found.archive);
      if (!newest || found.head.steps > newest->head.steps) newest = std::move(found);
    } catch (const Error& e) {
      if (e.fault() != Fault::file) throw;
      notes.push_back(fmt::format("{}: {}", path, e.problem()));
    }
  }
  if (!newest) {
    std::string problem = "there is no checkpoint to go on from";
    for (const std::string& note : notes) problem += "; " + note;
    throw Error(Fault::file, SourceLocation{.file = folder}, problem,
                "run without --restart, or name the folder of the run: -o FOLDER");
  }
  const std::string path = slot_path(folder, newest->slot);
  if (newest->head.version != CALOR_VERSION)
    throw Error(Fault::file, SourceLocation{.file = path},
                fmt::format("was written by calor {}, this is {}", newest->head.version, CALOR_VERSION),
                "go on with the version that began the run");
  require_same_case(c, newest->head, path);
  for (const std::string& note : notes)
    newest->notes.push_back(fmt::format("{}: the run goes on from {}, at t = {:.6g} s", note, path, newest->head.t));
  return std::move(*newest);
}

Checkpoints::Checkpoints(const Case& c, const NumberedPoints& points, std::string folder, std::optional<int> last)
    : case_(c), points_(points), folder_(std::move(folder)), next_(last ? 1 - *last : 0) {}

void Checkpoints::write(double t, long steps, const std::function<void(Archive&)>& exchange) {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  CheckpointHead head{.version = CALOR_VERSION,
                      .case_json = case_.json(),
                      .written = fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::gmtime(now)),
                      .ranks = size_of(points_.comm()),
                      .steps = steps,
                      .t = t};
  ArchiveWriter archive(points_);
  head.exchange(archive);
  exchange(archive);
  archive.save(slot_path(folder_, next_));
  next_ = (next_ + 1) % slots;
}

void Checkpoints::remove() const {
  if (folder_.empty() || rank_of(points_.comm()) != 0) return;
  for (int slot = 0; slot < slots; ++slot) {
    std::remove(slot_path(folder_, slot).c_str());
    std::remove((slot_path(folder_, slot) + ".part").c_str());
  }
}

std::optional<std::string> newest_checkpoint(const std::string& folder) {
  long most_steps = -1;
  std::string t;
  for (int slot = 0; slot < slots; ++slot) {
    std::ifstream file(slot_path(folder, slot));
    long steps = -1;
    for (std::string line; std::getline(file, line) && !line.starts_with("case");) {
      if (line.starts_with("step = ")) steps = std::strtol(line.c_str() + 7, nullptr, 10);
      if (line.starts_with("t = ") && steps > most_steps) most_steps = steps, t = line.substr(4);
    }
  }
  if (most_steps < 0) return std::nullopt;
  return fmt::format("t = {} s (step {})", t, most_steps);
}

}  // namespace calor
