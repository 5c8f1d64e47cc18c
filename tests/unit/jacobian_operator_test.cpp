// Products with the Jacobian without its matrix, against the matrix itself, whose entries heat_system_test.cpp compares
// with differences of the residual.
#include "solve/jacobian_operator.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "case_models.hpp"

namespace calor {
namespace {

/// Walls of all kinds: some points are known, some exchange heat.
const std::string walls = R"toml(
[boundary.held]
on = "xmin"
temperature = "2 K"
[boundary.air]
on = "xmax"
convection = { h = { formula = "3 + T", unit = "W/(m^2 K)" }, ambient = "1 K" }
[boundary.sky]
on = "ymax"
radiation = { emissivity = 0.5, ambient = "300 K" }
[initial]
temperature = "1 K"
[steady]
)toml";

std::string cube(const std::string& more, const std::string& k, const std::string& body = "") {
  return box_case({"1 m", "1 m", "1 m"}, {7, 7, 7}) + more + simple_material({.k = k}) + body + walls;
}

std::vector<double> product(Mat A, std::span<const double> v) {
  const petsc::Vector x = petsc::create_vector(A), y = petsc::create_vector(A);
  petsc::copy(v, x);
  petsc::check(MatMult(A, x, y));
  std::vector<double> result(v.size());
  petsc::copy(y, result);
  return result;
}

void expect_equal(const CaseModel& model, std::span<const double> a, std::span<const double> b,
                  const std::string& what) {
  double largest = 0, off = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(a[i])), off = std::max(off, std::abs(a[i] - b[i]));
  const MPI_Comm comm = model.cloud().comm;
  EXPECT_LE(max(comm, off), 1e-12 * max(comm, largest)) << what;
}

void expect_products_of_the_matrix(const std::string& text) {
  const CaseModel model(text, MPI_COMM_WORLD);
  HeatSystem& system = model.system();
  JacobianOperator whole(system, false), by_products(system, true);
  for (const double seed : {1., 2.}) {  // anew, what was scaled is forgotten
    std::vector<double> T = scattered_temperatures(model.cloud(), 2, 0.5, seed);
    for (JacobianOperator* J : {&whole, &by_products}) J->evaluate(0, T, 0, 1);
    std::vector<double> v = scattered_temperatures(model.cloud(), 0, 1, 7);
    v.resize(model.cloud().owned);
    expect_equal(model, product(whole.products(), v), product(by_products.products(), v), text);
    const std::vector<double> of_whole = whole.row_sums(), of_products = by_products.row_sums();
    for (std::size_t i = 0; i < v.size(); ++i) {
      EXPECT_GE(of_products[i], of_whole[i] * (1 - 1e-12));
      EXPECT_LE(of_products[i], of_whole[i] * 1.5);
    }
    const petsc::Vector rows = petsc::create_vector(whole.matrix()), columns = petsc::create_vector(whole.matrix());
    std::vector<double> factors(v.size());
    for (std::size_t i = 0; i < v.size(); ++i) factors[i] = 2 + v[i];
    petsc::copy(factors, rows);
    petsc::copy(std::span<const double>(T).first(v.size()), columns);
    for (JacobianOperator* J : {&whole, &by_products}) {
      J->add_to_diagonal(factors);
      J->scale(rows, columns);
      J->add_to_diagonal(factors);
      J->scale(0.25);
    }
    expect_equal(model, product(whole.products(), v), product(by_products.products(), v), text + "\nscaled");
  }
}

TEST(JacobianOperatorParallel, MultipliesAsTheMatrixDoes) {
  for (const std::string jitter : {"", "jitter = 0.2\n"}) {
    expect_products_of_the_matrix(cube(jitter, "2"));
    for (const char* mean : {"integral", "arithmetic", "harmonic"})
      expect_products_of_the_matrix(cube(jitter, "1 + T", fmt::format("[body]\nconductivity_mean = \"{}\"\n", mean)));
    expect_products_of_the_matrix(cube(jitter, "(1 + x)*(1 + T^2)"));
  }
}

// Pairs across an interface, and points off the walls, whose walls are terms of their own.
TEST(JacobianOperatorParallel, MultipliesAcrossInterfacesAndByWalls) {
  const std::string layer = simple_material({.name = "n", .k = "8 + T"}) +
                            "[body]\nmaterial = \"m\"\n[[body.region]]\nmaterial = \"n\"\nwhere = \"x > 0.45\"\n";
  expect_products_of_the_matrix(cube("", "1 + T", layer));
  expect_products_of_the_matrix(cube("at = \"cells\"\n", "1 + T"));
}

/// A body without functions of temperature, with prescribed walls that MLPG's parameters meet by rows of their own.
std::string linear(const std::string& method) {
  return replaced(box_case({"1 m", "1 m"}, {9, 9}), "sph", method) + simple_material({.k = "2", .rho = "3", .c = "5"}) +
         "[boundary.held]\non = \"xmin\"\ntemperature = \"2 K\"\n"
         "[boundary.air]\non = \"xmax\"\nconvection = { h = \"3 W/(m^2 K)\", ambient = \"1 K\" }\n"
         "[initial]\ntemperature = \"1 K\"\n[time]\nend = \"1 s\"\n";
}

TEST(JacobianOperatorParallel, AddsUpThoseOfStagesWhereItIsConstant) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const CaseModel model(linear(method), MPI_COMM_WORLD);
    HeatSystem& system = model.system();
    model.start();  // sets the scale of the rows of walls
    ASSERT_TRUE(system.jacobian_is_constant());
    JacobianOperator J(system, false);
    const petsc::Matrix whole = system.create_jacobian();
    std::vector<double> T = scattered_temperatures(model.cloud(), 2, 0.5, 1);
    std::vector<double> v = scattered_temperatures(model.cloud(), 0, 1, 7);
    v.resize(model.cloud().owned);
    for (const double dt : {1e-3, 1e3, 0.1}) {
      J.evaluate(0, T, 1, dt);
      J.scale(2);
      system.jacobian(0, T, 1, dt, whole);
      std::vector<double> twice = product(whole, v);
      for (double& value : twice) value *= 2;
      expect_equal(model, product(J.products(), v), twice, method);
      if (dt == 1e3) J.forget();
    }
  }
}

}  // namespace
}  // namespace calor
