#include "app/derivatives.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/derivative_log.hpp"
#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

/// A follower of nothing, to ask whether steps can be followed.
class Nobody final : public StepFollower {
  void impose(double, const State&) override {}
  void step(const ImplicitStep&) override {}
};

}  // namespace

void DerivativeLog::exchange(Archive& archive) {
  if (!archive.reads()) return;
  run_.description.section("output").refuse("derivatives", "derivatives of a run that goes on from a checkpoint",
                                            "run it anew, without --restart");
}

void DerivativeLog::add(double t, const Parameter& p, const std::vector<double>& derivatives) {
  rows_ += fmt::format("{},{}", t, csv_field(p.name()));
  for (const double value : derivatives) rows_ += fmt::format(",{}", value);
  rows_ += '\n';
}

void DerivativeLog::finish(const Moment&, RunResult&) {
  if (run_.folder.empty()) return;
  std::string header = "time [s],number";
  for (const std::string& reading : readings_.headings()) header += "," + csv_field(reading);
  write_in_turns(run_.comm(), run_.folder + "/derivatives.csv", header, [&](std::FILE* file) {
    if (rank_of(run_.comm()) == 0) fmt::print(file, "{}", rows_);
  });
}

void check_derivatives(const RunSetup& run, Integrator* integrator) {
  const Case& c = run.description;
  const Readings readings(c, run.probes, run.system, run.weld, run.stress);
  Nobody nobody;
  if (read_parameters(c).empty() || !integrator || integrator->tell(nobody)) return;
  c.section("output").refuse(
      "derivatives",
      fmt::format("derivatives of a run by {}, whose steps are no stages with a matrix", integrator->name()),
      "take [time] integrator = \"tr-bdf2\"");
}

std::unique_ptr<Observer> make_derivative_log(const RunSetup& run, const Model& model, Integrator* integrator) {
  check_derivatives(run, integrator);
  std::vector<Parameter> parameters = read_parameters(run.description);
  if (parameters.empty()) return nullptr;
  return integrator ? make_step_tangents(run, model, std::move(parameters), *integrator)
                    : make_steady_derivatives(run, model, std::move(parameters));
}

}  // namespace calor
