// probes.csv.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include "base/units.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"
#include "output/probes.hpp"

namespace calor {
namespace {

/// [output] probes = "every 1 s", in s; 0 where it is not given.
double read_probe_period(const Table& output) {
  if (!output.has("probes")) return 0;
  const std::string text = output.text("probes"), every = "every ", cure = "write probes = \"every 1 s\"";
  if (!text.starts_with(every)) output.refuse("probes", fmt::format("'probes' cannot be \"{}\"", text), cure);
  try {
    const auto [value, unit] = split_quantity(text.substr(every.size()));
    const double period = to_si(value, unit, "s");
    if (!(period > 0)) output.refuse("probes", fmt::format("a row every {} s", period), "give a time above 0 s");
    return period;
  } catch (const std::invalid_argument& e) {
    output.refuse("probes", fmt::format("'probes' = \"{}\": {}", text, e.what()), cure);
  }
}

/// probes.csv: a row of probe temperatures a time.
class ProbeLog : public Observer {
 public:
  explicit ProbeLog(const RunSetup& run) : run_(run) {
    if (!run.folder.empty() && !run.probes.names().empty()) {
      std::string header = "time [s]";
      for (const std::string& name : run.probes.names()) header += "," + name + " [K]";
      log_.emplace(run.comm(), run.folder + "/probes.csv", header);
    }
    if (run.is_steady()) return;
    const Table output = run.description.section("output");
    period_ = read_probe_period(output);
    end_ = run.description.section("time").number("end");
    constexpr double most = 1e6;
    if (period_ > 0 && end_ / period_ > most)
      output.refuse("probes", fmt::format("{:.3g} rows of probes.csv", end_ / period_), "give a longer time");
  }

  std::vector<double> times() const override {
    std::vector<double> all;
    for (long n = 1; period_ > 0 && n * period_ < end_; ++n) all.push_back(n * period_);
    return all;
  }

  void begin() override {
    if (log_) log_->open();
  }
  void exchange(Archive& archive) override {
    if (log_) log_->exchange(archive);
  }
  void record(const Moment& m) override {
    const double t = m.state().t;
    // What differs by round-off alone is one time.
    if (!log_ || (period_ > 0 && std::abs(t - std::round(t / period_) * period_) > 1e-12 * end_)) return;
    m.temperatures();  // for the ghosts
    std::vector<double> row = run_.probes.temperatures(m.u());
    row.insert(row.begin(), t);
    log_->row(row);
  }

 private:
  const RunSetup& run_;
  double period_ = 0, end_ = 0;  ///< s
  std::optional<CsvLog> log_;    ///< where there is something to write
};

}  // namespace

std::unique_ptr<Observer> make_probe_log(const RunSetup& run) { return std::make_unique<ProbeLog>(run); }

}  // namespace calor
