// The line on a terminal that says how far a run has come.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "base/parallel.hpp"
#include "base/terminal.hpp"
#include "output/observer.hpp"

namespace calor {
namespace {

std::string clock_text(double seconds) {
  const long s = static_cast<long>(seconds + 0.5);
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Rewrites one line on stderr, at most every 0.2 s, and takes it away at the end, also when a run throws.
class Progress : public Observer {
 public:
  explicit Progress(double end) : end_(end), start_(Clock::now()), shown_(start_) {}
  ~Progress() override { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin() override { start_ = shown_ = Clock::now(); }
  bool after_step(const Moment& m) override {
    const auto now = Clock::now();
    if (now - shown_ < std::chrono::milliseconds(200)) return true;
    shown_ = now;
    is_there_ = true;
    const double t = m.state().t, share = t / end_, spent = std::chrono::duration<double>(now - start_).count();
    fmt::print(stderr, "\r\033[K{:5.1f} %  t = {:.4g} s  step {}  {} left", 100 * share, t, m.steps,
               share > 0 ? clock_text(spent * (1 - share) / share) : "?");
    std::fflush(stderr);
    return true;
  }
  void finish(const Moment&, RunResult&) override { clear(); }

 private:
  using Clock = std::chrono::steady_clock;
  void clear() {
    if (!is_there_) return;
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
    is_there_ = false;
  }

  double end_;
  Clock::time_point start_, shown_;
  bool is_there_ = false;
};

}  // namespace

std::unique_ptr<Observer> make_progress(const RunSetup& run) {
  if (run.is_quiet || run.is_steady() || rank_of(run.comm()) != 0 || !stderr_is_terminal()) return nullptr;
  return std::make_unique<Progress>(run.description.section("time").number("end"));
}

}  // namespace calor
