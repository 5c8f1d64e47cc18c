#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "app/verbs.hpp"
#include "base/terminal.hpp"

namespace calor {
namespace {

constexpr const char* launched = "CALOR_LAUNCHED";

/// What Open MPI wants to be told in containers, on laptops and on busy machines; a user's own settings win.
void prepare_environment() {
  for (const auto& [name, value] : {std::pair{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                                    {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                                    {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
                                    {"OMPI_MCA_mpi_yield_when_idle", "1"},
                                    {"OMPI_MCA_hwloc_base_binding_policy", "none"}})
    setenv(name, value, 0);
  // The ranks themselves write to a pipe.
  setenv("CALOR_TERMINAL", stderr_is_terminal() ? "1" : "0", 1);
  setenv("CALOR_COLOUR", stdout_takes_colour() ? "1" : "0", 1);
  setenv(launched, "1", 1);
}

[[noreturn]] void refuse(int error) {
  throw Error(Fault::command, std::string("cannot start mpiexec: ") + std::strerror(error),
              "install Open MPI (package openmpi-bin), or run without -j");
}

constexpr int no_mpiexec = 127;

[[noreturn]] void become_mpiexec(char** argv, const sigset_t& mask, pid_t parent) {
  setpgid(0, 0);  // Ctrl-C reaches the parent alone
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(no_mpiexec);  // which has died already
  sigprocmask(SIG_SETMASK, &mask, nullptr);
  if (!std::freopen("/dev/null", "r", stdin)) _exit(no_mpiexec);
  execvp(argv[0], argv);
  _exit(no_mpiexec);
}

/// Waits for mpiexec and hands on the signals in `watched`, which are blocked; the last of them goes to `received`.
/// SIGINT and SIGTERM would let mpiexec kill the ranks within a second; SIGUSR1 it passes on to them. The second time
/// it is meant; and who asks by another signal than Ctrl-C will not wait for long.
int wait_for(pid_t mpiexec, const sigset_t& watched, int& received) {
  constexpr int patience = 25, last_patience = 5;  // s
  constexpr int steps[] = {SIGUSR1, SIGTERM, SIGKILL};
  int next = 0, status = 0;
  timespec timeout{.tv_sec = 3600, .tv_nsec = 0};
  while (true) {
    const int number = sigtimedwait(&watched, nullptr, &timeout);
    if (waitpid(mpiexec, &status, WNOHANG) == mpiexec) return status;
    const bool has_waited = number < 0 && errno == EAGAIN && (next > 1 || (next == 1 && received != SIGINT));
    if (number > 0 && number != SIGCHLD) received = number;
    if ((number <= 0 || number == SIGCHLD) && !has_waited) continue;
    if (next < 3) kill(mpiexec, steps[next++]);
    timeout.tv_sec = next == 1 ? patience : last_patience;
  }
}

}  // namespace

void end_with_launcher() {
  if (std::getenv(launched)) prctl(PR_SET_PDEATHSIG, SIGKILL);
}

int launch(int ranks, const std::vector<std::string>& arguments) {
  prepare_environment();
  std::vector<std::string> words{"mpiexec", "--quiet", "-n", std::to_string(ranks),
                                 std::filesystem::read_symlink("/proc/self/exe").string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  sigset_t watched, before;
  sigemptyset(&watched);
  for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) sigaddset(&watched, signal);
  sigprocmask(SIG_BLOCK, &watched, &before);
  const pid_t self = getpid(), child = fork();
  if (child < 0) refuse(errno);
  if (child == 0) become_mpiexec(argv.data(), before, self);
  int received = 0;
  const int status = wait_for(child, watched, received);
  sigprocmask(SIG_SETMASK, &before, nullptr);
  if (received) return 128 + received;
  if (WIFSIGNALED(status)) return 128 + WTERMSIG(status);
  if (WEXITSTATUS(status) == no_mpiexec) refuse(ENOENT);
  return WEXITSTATUS(status);
}

}  // namespace calor
