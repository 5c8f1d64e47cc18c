// The line on a terminal that says how far a run has come.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <string>

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
  explicit Progress(const RunSetup& run)
      : run_(run), end_(run.description.section("time").number("end")), start_(Clock::now()), shown_(start_) {}
  ~Progress() override { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin() override { start_ = shown_ = Clock::now(), begin_t_ = run_.start.t; }
  bool after_step(const Moment& m) override {
    const auto now = Clock::now();
    if (now - shown_ < std::chrono::milliseconds(200)) return true;
    shown_ = now;
    is_there_ = true;
    const double t = m.state().t, spent = std::chrono::duration<double>(now - start_).count();
    show(fmt::format("\r\033[K{:5.1f} %  t = {:.4g} s  step {}  {} left", 100 * t / end_, t, m.steps,
                     t > begin_t_ ? clock_text(spent * (end_ - t) / (t - begin_t_)) : "?"));
    return true;
  }
  void finish(const Moment&, RunResult&) override { clear(); }

 private:
  using Clock = std::chrono::steady_clock;
  void clear() {
    if (!is_there_) return;
    show("\r\033[K");
    is_there_ = false;
  }
  /// A terminal that is gone is no reason to end.
  static void show(const std::string& text) {
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
  }

  const RunSetup& run_;
  double end_, begin_t_ = 0;  ///< s; a run may go on from a checkpoint
  Clock::time_point start_, shown_;
  bool is_there_ = false;
};

}  // namespace

std::unique_ptr<Observer> make_progress(const RunSetup& run) {
  if (run.is_quiet || run.is_steady() || rank_of(run.comm()) != 0 || !stderr_is_terminal()) return nullptr;
  return std::make_unique<Progress>(run);
}

}  // namespace calor
