#pragma once
// How long the phases of a run take.
#include <chrono>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

namespace calor {

struct Timing {
  double wall = 0, cpu = 0;  ///< s; cpu: of this process
};

/// Stopwatches by name, in the order of their first use.
class Phases {
 public:
  /// Runs `work` and adds its time to the phase, also when it throws. Phases may nest; each counts all of its time.
  template <class Work>
  void measure(const std::string& name, const Work& work) {
    struct Watch {
      Phases& phases;
      const std::string& name;
      Timing start = now();
      ~Watch() { phases.add(name, now(), start); }
    } watch{*this, name};
    work();
  }
  const std::vector<std::pair<std::string, Timing>>& timings() const { return timings_; }

 private:
  static Timing now() {
    const auto since = std::chrono::steady_clock::now().time_since_epoch();
    return {.wall = std::chrono::duration<double>(since).count(),
            .cpu = static_cast<double>(std::clock()) / CLOCKS_PER_SEC};
  }
  void add(const std::string& name, Timing end, Timing start) {
    Timing* timing = nullptr;
    for (auto& [known, value] : timings_)
      if (known == name) timing = &value;
    if (!timing) timing = &timings_.emplace_back(name, Timing{}).second;
    timing->wall += end.wall - start.wall;
    timing->cpu += end.cpu - start.cpu;
  }

  std::vector<std::pair<std::string, Timing>> timings_;
};

}  // namespace calor
