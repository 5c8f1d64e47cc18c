#pragma once
// Cases as text, built up to their heat system, for the tests of what stands on it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "app/model.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "case/case.hpp"
#include "solve/heat_system.hpp"

namespace calor {

/// A case given as text; in messages it is "test.toml".
class CaseModel {
 public:
  explicit CaseModel(const std::string& text, MPI_Comm comm = MPI_COMM_SELF)
      : case_(Case::parse(text, "test.toml")), model_(build_model(case_, comm, phases_)) {}
  CaseModel(const CaseModel&) = delete;

  const Case& description() const { return case_; }
  const HeatSystem& system() const { return *model_.system; }
  const Cloud& cloud() const { return *model_.cloud; }
  const Model& model() const { return model_; }
  /// The state at t = 0, walls imposed.
  State start() const {
    State state = start_without_walls();
    system().impose(0, state.T, state.E, state.exchanged);
    return state;
  }
  State start_without_walls() const { return system().start(0, model_.T_start); }

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

/// The error that `work` throws; none is a failure.
inline Error error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    return e;
  }
  ADD_FAILURE() << "nothing was refused";
  return Error(Fault::command, "", "");
}

/// That the case is refused while it is read or built, with a message that contains all of `words`.
inline void expect_refused(const std::string& text, const std::vector<std::string>& words,
                           Fault fault = Fault::bad_case) {
  const Error error = error_of([&] { CaseModel model(text); });
  EXPECT_EQ(error.fault(), fault) << error.what();
  for (const std::string& word : words)
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << "'" << word << "' in: " << error.what();
}

/// Values of the owned points by id, on every rank. Collective.
inline std::vector<double> by_id(const Cloud& cloud, std::span<const double> values) {
  std::vector<double> all(cloud.count, 0);
  for (int i = 0; i < cloud.owned; ++i) all[cloud.id[i]] = values[i];
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, cloud.comm);
  return all;
}

}  // namespace calor
