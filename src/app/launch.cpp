#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "app/verbs.hpp"

namespace calor {

void launch(int ranks, const std::vector<std::string>& arguments) {
  // What Open MPI wants to be told in containers, on laptops and on busy machines; a user's own settings win.
  for (const auto& [name, value] : {std::pair{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                                    {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                                    {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
                                    {"OMPI_MCA_mpi_yield_when_idle", "1"},
                                    {"OMPI_MCA_hwloc_base_binding_policy", "none"}})
    setenv(name, value, 0);
  std::vector<std::string> words{"mpiexec", "-n", std::to_string(ranks),
                                 std::filesystem::read_symlink("/proc/self/exe").string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  throw Error(Fault::command, std::string("cannot start mpiexec: ") + std::strerror(errno),
              "install Open MPI (package openmpi-bin), or run without -j");
}

}  // namespace calor
