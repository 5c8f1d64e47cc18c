#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "app/verbs.hpp"

namespace calor {
namespace {

volatile std::sig_atomic_t mpiexec = 0, received = 0;

/// mpiexec would kill the ranks a second after SIGINT or SIGTERM; SIGUSR1 it passes on to them. The second time it is
/// meant.
void pass_on(int number) {
  kill(mpiexec, received == 0 ? SIGUSR1 : SIGTERM);
  received = number;
}

/// What Open MPI wants to be told in containers, on laptops and on busy machines; a user's own settings win.
void prepare_environment() {
  for (const auto& [name, value] : {std::pair{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                                    {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                                    {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
                                    {"OMPI_MCA_mpi_yield_when_idle", "1"},
                                    {"OMPI_MCA_hwloc_base_binding_policy", "none"}})
    setenv(name, value, 0);
  setenv("CALOR_TERMINAL", isatty(STDERR_FILENO) ? "1" : "0", 0);  // the ranks themselves write to a pipe
}

}  // namespace

int launch(int ranks, const std::vector<std::string>& arguments) {
  prepare_environment();
  std::vector<std::string> words{"mpiexec", "--quiet", "-n", std::to_string(ranks),
                                 std::filesystem::read_symlink("/proc/self/exe").string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const auto refuse = [](int error) {
    throw Error(Fault::command, std::string("cannot start mpiexec: ") + std::strerror(error),
                "install Open MPI (package openmpi-bin), or run without -j");
  };
  constexpr int no_mpiexec = 127;
  const pid_t child = fork();
  if (child < 0) refuse(errno);
  if (child == 0) {
    setpgid(0, 0);  // Ctrl-C reaches us alone
    if (!std::freopen("/dev/null", "r", stdin)) _exit(no_mpiexec);
    execvp(argv[0], argv.data());
    _exit(no_mpiexec);
  }
  mpiexec = child;
  for (int signal : {SIGINT, SIGTERM}) std::signal(signal, pass_on);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (received) return 128 + received;
  if (WIFSIGNALED(status)) return 128 + WTERMSIG(status);
  if (WEXITSTATUS(status) == no_mpiexec) refuse(ENOENT);
  return WEXITSTATUS(status);
}

}  // namespace calor
