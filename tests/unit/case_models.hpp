#pragma once
// Cases as text, built up to their heat system, for the tests of what stands on it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <vector>

#include "app/model.hpp"
#include "app/run.hpp"
#include "app/schema.hpp"
#include "base/parallel.hpp"
#include "case/case.hpp"
#include "errors.hpp"
#include "solve/heat_system.hpp"
#include "solve/integrator.hpp"

namespace calor {

/// The first six lines of a case, on a box; what follows goes on with [cloud].
inline std::string box_case(const std::vector<std::string>& size, const std::vector<int>& points,
                            const std::string& method = "sph") {
  return fmt::format("title = \"test\"\nmethod = \"{}\"\n[cloud]\nshape = \"box\"\nsize = {}\npoints = {}\n", method,
                     size, points);
}

/// Conductivity, W/(m K), density, kg/m^3, and specific heat, J/(kg K): each a number or a formula, in SI units.
struct SimpleMaterial {
  std::string name = "m", k, rho = {}, c = {};  ///< rho and c: empty for steady cases
};

/// The lines of a case that give the material: [material.NAME] and one line a property.
inline std::string simple_material(const SimpleMaterial& m) {
  const auto line = [](const std::string& key, const std::string& value, const std::string& unit) {
    if (value.empty()) return std::string();
    const bool is_number = value.find_first_not_of("0123456789.") == value.npos;
    return is_number ? fmt::format("{} = \"{} {}\"\n", key, value, unit)
                     : fmt::format("{} = {{ formula = \"{}\", unit = \"{}\" }}\n", key, value, unit);
  };
  return "[material." + m.name + "]\n" + line("conductivity", m.k, "W/(m K)") + line("density", m.rho, "kg/m^3") +
         line("specific_heat", m.c, "J/(kg K)");
}

/// The text with its first `old` replaced.
inline std::string replaced(std::string text, const std::string& old, const std::string& by) {
  return text.replace(text.find(old), old.size(), by);
}

/// A case given as text; in messages it is "test.toml".
inline Case parse_case(const std::string& text) { return Case::parse(text, "test.toml", schema()); }

/// Heat rates of the owned points and powers of the accounts, W.
struct Rates {
  std::vector<double> F, power;
};

/// A case given as text, and its heat system.
class CaseModel {
 public:
  explicit CaseModel(const std::string& text, MPI_Comm comm = MPI_COMM_SELF)
      : case_(parse_case(text)), model_(build_model(case_, comm, phases_)) {}
  CaseModel(const CaseModel&) = delete;

  const Case& description() const { return case_; }
  HeatSystem& system() const { return *model_.system; }
  const Cloud& cloud() const { return *model_.cloud; }
  const Model& model() const { return model_; }
  /// The state at t = 0, walls imposed.
  State start() const {
    State state = start_without_walls();
    system().impose(0, state.T, state.E, state.cumulative_heat);
    return state;
  }
  State start_without_walls() const { return system().start(0, model_.T_start); }
  /// The steady state.
  State steady() const {
    State state = start();
    solve_steady(case_, system(), state);
    return state;
  }
  /// One temperature at all local points.
  std::vector<double> uniform(double T) const { return std::vector<double>(cloud().local(), T); }
  Rates rates(double t, std::vector<double> T) const {
    Rates rates{std::vector<double>(cloud().owned), std::vector<double>(system().accounts().size())};
    system().rate(t, T, rates.F, rates.power);
    return rates;
  }

 private:
  Case case_;
  Phases phases_;
  Model model_;
};

/// A number in [-1, 1] that jumps from one argument to the next, the same on every machine.
inline double scattered(double n) { return std::sin(1.7 + 12.9898 * n + 3.3 * n * n); }

/// mean + swing * scattered, one a local point.
inline std::vector<double> scattered_temperatures(const Cloud& cloud, double mean, double swing, double seed = 0) {
  std::vector<double> T(cloud.local());
  for (int i = 0; i < cloud.local(); ++i)
    T[i] = mean + swing * scattered(static_cast<double>(cloud.id[i]) + 0.37 * seed);
  return T;
}

/// That the case is refused while it is read or built, with a message that contains all of `words`.
inline void expect_refused(const std::string& text, const std::vector<std::string>& words,
                           Fault fault = Fault::bad_case) {
  expect_error([&] { CaseModel model(text); }, words, fault);
}

/// Runs a case; its results go to `folder`, nowhere where that is empty. Collective.
inline RunResult run_into(const std::string& folder, const std::string& text, MPI_Comm comm = MPI_COMM_SELF) {
  return run(parse_case(text), comm, {.folder = folder, .quiet = true});
}

/// Values of the owned points by id, on every rank. Collective.
inline std::vector<double> by_id(const Cloud& cloud, std::span<const double> values) {
  std::vector<double> all(cloud.count, 0);
  for (int i = 0; i < cloud.owned; ++i) all[cloud.id[i]] = values[i];
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, cloud.comm);
  return all;
}

}  // namespace calor
