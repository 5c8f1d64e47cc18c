// Ends a run that has become steady: [time] steady_below.
#include <algorithm>
#include <cmath>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "output/observer.hpp"

namespace calor {
namespace {

class SteadyStop : public Observer {
 public:
  SteadyStop(MPI_Comm comm, double limit, double last_event, const State& start)
      : comm_(comm),
        limit_(limit),
        last_event_(last_event),
        owned_(start.E.size()),
        t_before_(start.t),
        T_before_(start.T) {}

  void exchange(Archive& archive) override {
    archive.value("time of the last step", t_before_);
    archive.points("temperatures of the last step", std::span(T_before_).first(owned_));
  }
  bool after_step(const Moment& m) override {
    const State& s = m.state();
    double change = 0;
    for (std::size_t i = 0; i < s.E.size(); ++i) change = std::max(change, std::abs(s.T[i] - T_before_[i]));
    // At rest before a table goes on or a source begins is not steady.
    const bool is_steady = max(comm_, change) < limit_ * (s.t - t_before_) && t_before_ >= last_event_ * (1 - 1e-12);
    T_before_ = s.T, t_before_ = s.t;
    return !is_steady;
  }

 private:
  MPI_Comm comm_;
  double limit_;       ///< K/s
  double last_event_;  ///< of the data within the run, s
  std::size_t owned_;
  double t_before_;
  std::vector<double> T_before_;
};

}  // namespace

std::unique_ptr<Observer> make_steady_stop(const RunSetup& run) {
  const Table time = run.description.section("time");
  if (run.is_steady() || !time.has("steady_below")) return nullptr;
  double last_event = 0;
  for (const double t : run.system.events())
    if (t < time.number("end")) last_event = t;
  return std::make_unique<SteadyStop>(run.comm(), time.number("steady_below"), last_event, run.start);
}

}  // namespace calor
