// stress.csv: the extreme stresses over time; section.csv: the stress of the section at the end.
#include <fmt/format.h>

#include <array>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"
#include "output/thermal_stress.hpp"

namespace calor {
namespace {

class StressLog : public Observer {
 public:
  explicit StressLog(const RunSetup& run) : run_(run), stress_(*run.stress) {
    if (!run.folder.empty())
      log_ = CsvLog(run.comm(), run.folder + "/stress.csv", "time [s],lowest [Pa],highest [Pa],strain,curvature [1/m]");
  }

  void begin() override { log_.open(); }
  void exchange(Archive& archive) override {
    std::array<double, 2> so_far{extremes_.lowest, extremes_.highest};
    archive.values("extreme stresses", so_far);
    extremes_ = {.lowest = so_far[0], .highest = so_far[1]};
    log_.exchange(archive);
  }
  /// A shock is at its worst long before the next record.
  bool after_step(const Moment& m) override {
    observe(m);
    return true;
  }
  void record(const Moment& m) override {
    const Deformation d = observe(m);
    log_.row(std::array{m.state().t, d.lowest, d.highest, d.strain, d.curvature});
  }
  void finish(const Moment& m, RunResult& result) override {
    const std::vector<ReportNumber> listed = ExtremeStresses::listed();
    const std::vector<double> numbers = extremes_.numbers();
    for (std::size_t n = 0; n < numbers.size(); ++n) result.numbers[listed[n].name] = numbers[n];
    if (run_.folder.empty()) return;
    m.temperatures();
    write_section(stress_.deformation(m.u()));
  }
  std::vector<ReportNumber> numbers() const override { return ExtremeStresses::listed(); }

 private:
  Deformation observe(const Moment& m) {
    m.temperatures();  // for the ghosts
    Deformation d = stress_.deformation(m.u());
    extremes_.add(d);
    return d;
  }
  void write_section(const Deformation& d) const {
    const bool is_disc = stress_.components().size() > 1, is_written_here = rank_of(run_.comm()) == 0;
    std::string header = is_disc ? "s [m],r [m],T [K]" : "s [m],T [K]";
    for (const std::string& component : stress_.components()) header += "," + component + " [Pa]";
    write_in_turns(run_.comm(), run_.folder + "/section.csv", header, [&](std::FILE* file) {
      for (std::size_t i = 0; is_written_here && i < d.T.size(); ++i) {
        fmt::print(file, "{},", stress_.s()[i]);
        if (is_disc) fmt::print(file, "{},", stress_.r()[i]);
        fmt::print(file, "{}", d.T[i]);
        for (const std::vector<double>& component : d.stress) fmt::print(file, ",{}", component[i]);
        std::fputc('\n', file);
      }
    });
  }

  const RunSetup& run_;
  const ThermalStress& stress_;
  ExtremeStresses extremes_;
  CsvLog log_;
};

}  // namespace

std::unique_ptr<Observer> make_stress_log(const RunSetup& run) {
  return run.stress ? std::make_unique<StressLog>(run) : nullptr;
}

}  // namespace calor
