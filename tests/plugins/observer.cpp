// An observer: how long every point has been hotter than a threshold, in exposure.csv and as a number of the report.
#include "output/observer.hpp"

#include <algorithm>
#include <array>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "run_case.hpp"

namespace calor {
namespace {

class Exposure final : public Observer {
 public:
  Exposure(const RunSetup& run, double threshold)
      : comm_(run.comm()), threshold_(threshold), seconds_(run.system.cloud().owned, 0) {}

  bool after_step(const Moment& m) override {
    const std::span<const double> T = m.temperatures();
    for (std::size_t i = 0; i < seconds_.size(); ++i)
      if (T[i] > threshold_) seconds_[i] += m.state().t - t_;
    t_ = m.state().t;
    return true;
  }
  void exchange(Archive& archive) override {
    archive.value("exposure until", t_);
    archive.points("exposure", seconds_);
  }
  void finish(const Moment&, RunResult& result) override {
    const double longest = seconds_.empty() ? 0 : std::ranges::max(seconds_);
    result.numbers["longest_exposure"] = max(comm_, longest);
  }
  std::vector<ReportNumber> numbers() const override { return {{"longest_exposure", "s"}}; }

 private:
  MPI_Comm comm_;
  double threshold_, t_ = 0;
  std::vector<double> seconds_;  // of the owned points
};

void declare_exposure(Schema& schema) {
  schema.add({.path = "exposure",
              .sentence = "How long points are hot.",
              .keys = {{"above", Kind::quantity, "K", required, "Temperature from which on the time counts."}}});
}

std::unique_ptr<Observer> make_exposure(const RunSetup& run) {
  const Table& root = run.description.root();
  return root.has("exposure") ? std::make_unique<Exposure>(run, root.sub("exposure").number("above")) : nullptr;
}

TEST(Plugin, IsAnObserver) {
  observers().add(
      {.name = "exposure", .sentence = "how long points are hot", .declare = declare_exposure, .make = make_exposure});
  // 1e5 W/m^3 in 1e6 J/(m^3 K) heat by 0.1 K/s: above 302 K in the last 10 s of 30 s.
  expect_passes(bar + R"toml(
[material.m]
conductivity = "1 W/(m K)"
density = "1000 kg/m^3"
specific_heat = "1000 J/(kg K)"
[initial]
temperature = "300 K"
[source.heater]
power_density = "100 kW/m^3"
[time]
integrator = "euler"
end = "30 s"
step = "0.3 s"
[exposure]
above = "302 K"
[[expect]]
report = "longest_exposure"
at_least = 9.69
at_most = 10.31
)toml");
}

}  // namespace
}  // namespace calor
