#include "output/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <string_view>

#include "base/parallel.hpp"

namespace calor {
namespace {

std::string clock_text(double seconds) {
  const long s = static_cast<long>(seconds + 0.5);
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Does the line end up on a terminal? Ranks under mpiexec are told so.
bool on_terminal() {
  const char* told = std::getenv("CALOR_TERMINAL");
  return told ? std::string_view(told) == "1" : isatty(STDERR_FILENO);
}

}  // namespace

Progress::Progress(MPI_Comm comm, double end, bool quiet)
    : end_(end), speaks_(!quiet && rank_of(comm) == 0 && on_terminal()), start_(Clock::now()), shown_(start_) {}

void Progress::show(double t, long steps) {
  if (!speaks_) return;
  const auto now = Clock::now();
  if (now - shown_ < std::chrono::milliseconds(200)) return;
  shown_ = now;
  const double share = t / end_, spent = std::chrono::duration<double>(now - start_).count();
  fmt::print(stderr, "\r\033[K{:5.1f} %  t = {:.4g} s  step {}  {} left", 100 * share, t, steps,
             share > 0 ? clock_text(spent * (1 - share) / share) : "?");
  std::fflush(stderr);
}

void Progress::done() {
  if (!speaks_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  speaks_ = false;
}

}  // namespace calor
