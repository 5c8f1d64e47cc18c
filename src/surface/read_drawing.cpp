// STEP and BREP files by the program gmsh, which makes triangles of their curved faces. It is run as a command of its
// own, never linked.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>

#include "surface/surface_files.hpp"
#include "surface/words.hpp"

extern char** environ;

namespace calor {
namespace {

/// A folder of its own, which goes with it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "calor-XXXXXX").string();
    if (!mkdtemp(name.data()))
      throw Error(Fault::file,
                  fmt::format("no folder can be made in {}", std::filesystem::temp_directory_path().string()),
                  "set TMPDIR to a folder that can be written");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// Runs a command, its output in a file; its exit code, or -1 where there is no such program.
int run(const std::vector<std::string>& words, const std::string& output) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return -1;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

/// What gmsh said went wrong, its last line of "Error".
std::string complaint(const std::string& log) {
  std::string said = "without a word";
  for (std::size_t at = log.find("Error"); at != std::string::npos; at = log.find("Error", at + 1)) {
    const std::size_t text = log.find(": ", at);
    if (text != std::string::npos) said = log.substr(text + 2, log.find('\n', text) - text - 2);
  }
  return said;
}

/// The surfaces of the volumes in a file of format MSH 4.1 (Gmsh reference manual, "File formats").
class Msh {
 public:
  Msh(const std::string& path, std::string_view contents) : words_(path, contents) {}

  std::vector<Surface> read() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
      if (word == "$PhysicalNames") read_names();
      if (word == "$Entities") read_entities();
      if (word == "$Nodes") read_nodes();
      if (word == "$Elements") read_elements();
    }
    std::vector<Surface> solids;
    for (const auto& [number, surfaces] : volumes_) {
      Surface& solid = solids.emplace_back();
      solid.vertices = vertices_;
      for (const std::int64_t s : surfaces) {
        const std::int32_t face = face_named(solid, name_of(s));
        for (const auto& vertex : facets_[s]) solid.facets.push_back({vertex, face});
      }
    }
    return solids;
  }

 private:
  std::int64_t integer() { return words_.integer(words_.next()); }
  void skip(std::int64_t count) {
    for (std::int64_t n = 0; n < count; ++n) words_.next();
  }

  std::string name_of(std::int64_t surface) const {
    const auto physical = physical_.find(surface);
    const auto name = physical == physical_.end() ? names_.end() : names_.find(physical->second);
    return name == names_.end() ? fmt::format("face{}", surface) : name->second;
  }

  void read_names() {
    const std::int64_t count = integer();
    for (std::int64_t n = 0; n < count; ++n) {
      const std::int64_t dimension = integer(), tag = integer();
      const std::string_view name = words_.rest_of_line();
      if (dimension == 2 && name.size() > 2) names_[tag] = name.substr(1, name.size() - 2);
    }
  }

  void read_entities() {
    const std::int64_t points = integer(), curves = integer(), surfaces = integer(), volumes = integer();
    for (std::int64_t n = 0; n < points; ++n) skip(4), skip(integer());
    constexpr int box = 6;
    for (std::int64_t n = 0; n < curves; ++n) skip(1 + box), skip(integer()), skip(integer());
    for (std::int64_t n = 0; n < surfaces; ++n) {
      const std::int64_t tag = integer();
      skip(box);
      const std::int64_t groups = integer();
      for (std::int64_t g = 0; g < groups; ++g) physical_[tag] = integer();
      skip(integer());
    }
    for (std::int64_t n = 0; n < volumes; ++n) {
      std::vector<std::int64_t>& sides = volumes_[integer()];
      skip(box), skip(integer());
      const std::int64_t count = integer();
      for (std::int64_t s = 0; s < count; ++s) sides.push_back(std::abs(integer()));
    }
  }

  void read_nodes() {
    const std::int64_t blocks = integer();
    skip(3);
    for (std::int64_t b = 0; b < blocks; ++b) {
      skip(3);
      const std::int64_t count = integer();
      std::vector<std::int64_t> tags;
      for (std::int64_t n = 0; n < count; ++n) tags.push_back(integer());
      for (const std::int64_t tag : tags) {
        node_[tag] = static_cast<std::int32_t>(vertices_.size());
        Vec3& x = vertices_.emplace_back();
        for (int a = 0; a < 3; ++a) x[a] = words_.coordinate(words_.next());
      }
    }
  }

  void read_elements() {
    const std::int64_t blocks = integer();
    skip(3);
    for (std::int64_t b = 0; b < blocks; ++b) {
      constexpr std::int64_t triangle = 2;
      skip(1);
      const std::int64_t entity = integer(), type = integer(), count = integer();
      for (std::int64_t n = 0; n < count; ++n) {
        skip(1);
        if (type != triangle) {
          words_.rest_of_line();
          continue;
        }
        std::array<std::int32_t, 3> vertex;
        for (std::int32_t& v : vertex) v = node_.at(integer());
        facets_[entity].push_back(vertex);
      }
    }
  }

  Words words_;
  std::map<std::int64_t, std::string> names_;                  // of groups of surfaces
  std::map<std::int64_t, std::int64_t> physical_;              // group of a surface
  std::map<std::int64_t, std::vector<std::int64_t>> volumes_;  // surfaces of a volume
  std::map<std::int64_t, std::vector<std::array<std::int32_t, 3>>> facets_;
  std::map<std::int64_t, std::int32_t> node_;
  std::vector<Vec3> vertices_;
};

}  // namespace

std::vector<Surface> read_drawing(const std::string& path, const SourceLocation& named, double chord) {
  const std::string written = read_whole_file(path, named);
  // Of anything else gmsh would make what it can, and may take for ever over it.
  const bool is_drawing = written.starts_with("ISO-10303-21") || written.starts_with("DBRep_DrawableShape") ||
                          written.substr(0, 100).find("CASCADE Topology") != std::string::npos;
  if (!is_drawing)
    throw Error(Fault::bad_case, named, fmt::format("\"{}\" is no STEP and no BREP file", path),
                "write one by the program that the drawing comes from");
  const TemporaryFolder folder;
  const std::string script = folder.file("script.geo"), mesh = folder.file("surface.msh"), log = folder.file("log");
  const std::string drawing = "drawing" + std::filesystem::path(path).extension().string();
  std::filesystem::create_symlink(std::filesystem::absolute(path), folder.file(drawing));
  // Coherence: solids that touch share the face between them, and so its triangles.
  std::ofstream(script) << "SetFactory(\"OpenCASCADE\");\nGeometry.OCCTargetUnit = \"M\";\nMerge \"" << drawing
                        << "\";\nCoherence;\n";
  constexpr const char* chords_in_a_circle = "24";  // at least
  const int code = run({"gmsh", script, "-2", "-format", "msh41", "-save_all", "-clmax", fmt::format("{:.6g}", chord),
                        "-clcurv", chords_in_a_circle, "-o", mesh},
                       log);
  constexpr int no_program = 127;
  if (code < 0 || code == no_program)
    throw Error(Fault::file, named, fmt::format("\"{}\" is read by the program gmsh, which is not installed", path),
                "install it (apt-get install gmsh), or write the body as STL");
  if (code != 0 || !std::filesystem::exists(mesh))
    throw Error(Fault::bad_case, named,
                fmt::format("gmsh makes no surface of \"{}\": {}", path, complaint(read_whole_file(log, named))),
                "mend the drawing, or write the body as STL");
  const std::string contents = read_whole_file(mesh, named);
  std::vector<Surface> solids = Msh(mesh, contents).read();
  if (solids.empty())
    throw Error(Fault::bad_case, named, fmt::format("\"{}\" holds no solid", path),
                "write solids, not surfaces alone, from the program it comes from");
  return solids;
}

}  // namespace calor
