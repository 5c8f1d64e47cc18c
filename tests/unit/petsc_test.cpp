#include "base/petsc.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "case_models.hpp"
#include "errors.hpp"
#include "solve/newton.hpp"

namespace calor {
namespace {

/// Newton's equations of a rod between 0 K and 1 K with k = 1 + T, which can be told to throw.
class Trouble {
 public:
  enum class Where { nowhere, residual, jacobian, tolerance, bend };

  explicit Trouble(MPI_Comm comm = MPI_COMM_SELF)
      : model_(box_case({"1 m"}, {11}) + simple_material({.k = "1 + T"}) +
                   "[boundary.xmin]\ntemperature = \"0 K\"\n[boundary.xmax]\ntemperature = \"1 K\"\n[steady]\n",
               comm) {}

  /// Throws `what` in the callback, in the call of that number.
  template <class What>
  Newton::Result solve(Where where, int call, const What& what) {
    int left = call;
    const auto here = [&, where](Where place) {
      if (place == where && left-- == 0) throw what;
    };
    HeatSystem& system = model_.system();
    Newton newton(
        system,
        {.residual = [&](auto T, auto R) { here(Where::residual), system.residual(0, T, 1, {}, R); },
         .jacobian = [&](auto T, JacobianOperator& J) { here(Where::jacobian), J.evaluate(0, T, 0, 1); },
         .tolerance = [&](auto, auto tolerance, auto) { here(Where::tolerance), std::ranges::fill(tolerance, 1e-12); },
         .correct_step = [&](auto, auto) { here(Where::bend); },
         .residual_may_grow = true},
        true);
    State state = model_.start();
    const Newton::Result result = newton.solve(state.T, 30, 1);
    for (int i = 0; result.converged && i < model_.cloud().owned; ++i)
      EXPECT_NEAR(state.T[i], std::sqrt(1 + 3 * model_.cloud().x[i].x) - 1, 1e-11);
    return result;
  }

 private:
  CaseModel model_;
};

const Error numbers(Fault::numbers, "no such number", "");

TEST(Petsc, SaysWhatItRefuses) {
  petsc::Vector vector;
  petsc::check(VecCreate(MPI_COMM_SELF, vector.out()));
  expect_error([&] { petsc::check(VecSetType(vector, "nonsense")); }, {"PETSc failed", "petsc_test.cpp", "nonsense"},
               Fault::numbers);
}

TEST(Petsc, CarriesExceptionsAcrossItself) {
  for (const auto where :
       {Trouble::Where::residual, Trouble::Where::jacobian, Trouble::Where::tolerance, Trouble::Where::bend})
    for (const int call : {0, 1})
      EXPECT_THROW(Trouble().solve(where, call, std::runtime_error("x")), std::runtime_error);
}

TEST(Newton, PassesOnErrorsAtTheFirstGuess) {
  for (const auto where : {Trouble::Where::residual, Trouble::Where::tolerance})
    expect_error([&] { Trouble().solve(where, 0, numbers); }, {"no such number"}, Fault::numbers);
}

TEST(Newton, KeepsTheReasonWhereItFails) {
  for (const auto where : {Trouble::Where::jacobian, Trouble::Where::bend}) {
    Trouble trouble;
    const auto result = trouble.solve(where, 0, numbers);
    EXPECT_FALSE(result.converged);
    ASSERT_TRUE(result.reason);
    expect_error([&] { std::rethrow_exception(result.reason); }, {"no such number"}, Fault::numbers);
    EXPECT_TRUE(trouble.solve(Trouble::Where::nowhere, 0, numbers).converged);  // nothing is left behind
  }
}

TEST(NewtonParallel, CarriesExceptionsAcrossPetsc) {
  Trouble trouble(MPI_COMM_WORLD);
  EXPECT_THROW(trouble.solve(Trouble::Where::jacobian, 1, std::runtime_error("x")), std::runtime_error);
  EXPECT_FALSE(trouble.solve(Trouble::Where::jacobian, 1, numbers).converged);
  EXPECT_TRUE(trouble.solve(Trouble::Where::nowhere, 0, numbers).converged);
}

}  // namespace
}  // namespace calor
