#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <initializer_list>

#include "app/verbs.hpp"

namespace calor {
namespace {

/// The folder that holds the package: of an installation, of Debian's package, or of the source tree.
std::string package_folder() {
  namespace fs = std::filesystem;
  const fs::path command = fs::read_symlink("/proc/self/exe").parent_path();
  const std::initializer_list<fs::path> places = {command / "../share/calor/python",
                                                  command / "../lib/python3/dist-packages", command / "../../python"};
  for (const fs::path& place : places)
    if (std::error_code none; fs::exists(place / "calor" / "__main__.py", none)) return fs::canonical(place);
  throw Error(
      Fault::command, "the Python package of calor is not beside the command",
      "install python3-calor, or calor as a whole (cmake --install), or run the command of a build in its source tree");
}

}  // namespace

void become_python(const std::vector<std::string>& words) {
  // That of Debian, for which apt installs numpy and the like, before another one that hides it.
  const std::string python = access("/usr/bin/python3", X_OK) == 0 ? "/usr/bin/python3" : "python3";
  std::string folder = package_folder();
  if (const char* others = std::getenv("PYTHONPATH")) folder += std::string(":") + others;
  setenv("PYTHONPATH", folder.c_str(), 1);
  std::vector<std::string> all{python, "-m", "calor"};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> argv;
  for (std::string& word : all) argv.push_back(word.data());
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  throw Error(Fault::command, std::string("Python cannot be started: ") + std::strerror(errno),
              "install it: apt-get install python3");
}

}  // namespace calor
