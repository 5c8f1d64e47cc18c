#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "app/verbs.hpp"
#include "base/terminal.hpp"

namespace calor {
namespace {

constexpr const char* launched = "CALOR_LAUNCHED";  // by the process of this number
// What ranks tell their launcher by, so that it knows these from what mpiexec says by itself: codes, and signals that
// they have heeded.
constexpr int own_codes = 64, heeded_signals = 96;
constexpr int no_mpiexec = 60;

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
  setenv("HWLOC_COMPONENTS", "-opencl", 0);  // a compiler for graphics cards takes the signals of mpiexec
  setenv(launched, fmt::format("{}", getpid()).c_str(), 1);
}

[[noreturn]] void refuse(const std::string& reason) {
  throw MachineLacks(fmt::format(
      "mpiexec does not start the processes: {}: look whether Open MPI is there (package openmpi-bin) and has "
      "room for its files, or run without -j",
      reason));
}

[[noreturn]] void become_mpiexec(char** argv, const sigset_t& mask, pid_t parent) {
  setpgid(0, 0);  // Ctrl-C reaches the parent alone
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(no_mpiexec);  // which has died already
  sigprocmask(SIG_SETMASK, &mask, nullptr);
  if (!std::freopen("/dev/null", "r", stdin)) _exit(no_mpiexec);
  execvp(argv[0], argv);
  _exit(no_mpiexec);
}

/// Signals the ranks that this process has launched, and says how many there are. mpiexec passes hardly any signal on;
/// with some of its plug-ins none.
int signal_ranks(int number) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  const std::string mark = fmt::format("{}={}", launched, getpid());
  int count = 0;
  for (const auto& entry : fs::directory_iterator("/proc", error)) {
    const std::string name = entry.path().filename();
    if (!std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c); })) continue;
    if (fs::read_symlink(entry.path() / "exe", error) != self || error) continue;
    std::ifstream environment(entry.path() / "environ", std::ios::binary);
    for (std::string variable; std::getline(environment, variable, '\0');)
      if (variable == mark) count += kill(std::stoi(name), number) == 0;
  }
  return count;
}

/// Waits for mpiexec; a signal goes on to the ranks, and to `received`. The second time it is meant: mpiexec kills the
/// ranks; and who asks by another signal than Ctrl-C will not wait for long.
int wait_for(pid_t mpiexec, const sigset_t& watched, int& received) {
  constexpr int patience = 25, last_patience = 5;  // s
  constexpr int steps[] = {SIGTERM, SIGKILL};
  int next = 0, status = 0;
  timespec timeout{.tv_sec = 3600, .tv_nsec = 0};
  while (true) {
    int number = sigtimedwait(&watched, nullptr, &timeout);
    if (number == SIGUSR1) number = SIGINT;  // what batch systems send; ranks take it for the same
    if (waitpid(mpiexec, &status, WNOHANG) == mpiexec) return status;
    const bool is_signal = number > 0 && number != SIGCHLD;
    if (is_signal && !std::exchange(received, number) && signal_ranks(number) > 0) {
      timeout.tv_sec = patience;
      continue;
    }
    const bool has_waited = number < 0 && errno == EAGAIN && (next > 0 || (received && received != SIGINT));
    if (!is_signal && !has_waited) continue;
    if (next < 2) kill(mpiexec, steps[next++]);
    timeout.tv_sec = last_patience;
  }
}

}  // namespace

void end_with_launcher() {
  if (std::getenv(launched)) prctl(PR_SET_PDEATHSIG, SIGKILL);
}

int code_for_launcher(int code) {
  if (!std::getenv(launched) || code == 0 || code == out_of_time) return code;
  return code > 128 ? heeded_signals + code - 128 : own_codes + code;
}

Launched launch(int ranks, const std::vector<std::string>& arguments) {
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
  for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGCHLD}) sigaddset(&watched, signal);
  sigprocmask(SIG_BLOCK, &watched, &before);
  const pid_t self = getpid(), child = fork();
  if (child < 0) refuse(std::strerror(errno));
  if (child == 0) become_mpiexec(argv.data(), before, self);
  int received = 0;
  const int status = wait_for(child, watched, received);
  sigprocmask(SIG_SETMASK, &before, nullptr);
  const int code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  if (code == 0 || code == out_of_time) return {.code = code, .is_told = true};
  if (code > heeded_signals && code < 128) return {.code = 128 + code - heeded_signals, .is_told = true};
  if (code > own_codes && code < 128) return {.code = code - own_codes, .is_told = true};
  if (received) return {.code = 128 + received, .is_told = false};
  if (code > 128 && code < 160) return {.code = code, .is_told = false};
  refuse(code == no_mpiexec ? std::strerror(ENOENT) : fmt::format("it ended with code {}", code));
}

}  // namespace calor
