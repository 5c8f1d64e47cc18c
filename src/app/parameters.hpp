#pragma once
// The numbers of a case that [output] derivatives names.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/model.hpp"
#include "app/readings.hpp"
#include "case/numbers.hpp"
#include "output/probes.hpp"

namespace calor {

/// a + factor b, as far as b goes.
std::vector<double> sum(std::span<const double> a, double factor, std::span<const double> b);

struct Parameter {
  std::shared_ptr<const CaseNumbers> among;
  std::size_t entry;
  SourceLocation asked_at;
  bool is_conductivity;  ///< changes nothing else

  double value() const { return among->values()[entry]; }
  const std::string& name() const { return among->names()[entry]; }
  /// Half of the distance between two values whose difference is taken: its square is what is neglected, where anything
  /// bends at all, and rounding leaves 1e-16 over it.
  double step() const;
  /// The derivative by it of what is `more` at value() + step() and `less` at value() - step().
  std::vector<double> difference(std::span<const double> more, std::span<const double> less) const;
  /// The case with another value. Throws Error.
  Case with(double value) const;
};

/// Empty where nothing is asked for. Throws Error.
std::vector<Parameter> read_parameters(const Case& c);

/// The model of a case with another value of a parameter, as its run begins.
class ChangedModel {
 public:
  /// Throws Error, also where its points are not those of `model`. Collective.
  ChangedModel(const Model& model, const Parameter& p, double value);

  HeatSystem& system() const { return *model_.system; }
  const Cloud& cloud() const { return *model_.cloud; }
  const State& start() const { return start_.state; }
  const Readings& readings() const { return readings_; }
  /// Collective.
  void observe(State& state) { readings_.observe(state); }

 private:
  Case case_;
  Phases phases_;
  Model model_;
  Start start_;
  Probes probes_;
  Readings readings_;
};

}  // namespace calor
