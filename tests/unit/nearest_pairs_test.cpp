// The thin matrix of the preconditioner: what it keeps of the whole one.
#include "solve/nearest_pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "case_models.hpp"

namespace calor {
namespace {

const std::string rest = R"toml(
[boundary.warm]
on = "xmax"
convection = { h = "3 W/(m^2 K)", ambient = "1 K" }
[initial]
temperature = "0.3 K"
[steady]
)toml";

petsc::Matrix jacobian(const CaseModel& model) {
  petsc::Matrix J = model.system().create_jacobian();
  std::vector<double> T = model.uniform(0.3);
  model.system().jacobian(0, T, 0, 1, J);
  return J;
}

/// u.A u of the temperatures u that `of` gives every owned point.
template <class Of>
double form(Mat A, const Cloud& cloud, const Of& of) {
  std::vector<double> values;
  for (const Vec3& x : cloud.owned_points()) values.push_back(of(x));
  const petsc::Vector u = petsc::create_vector(A), Au = petsc::create_vector(A);
  petsc::copy(values, u);
  petsc::check(MatMult(A, u, Au));
  double product = 0;
  petsc::check(VecDot(u, Au, &product));
  return product;
}

double entries(Mat A) {
  MatInfo info;
  petsc::check(MatGetInfo(A, MAT_GLOBAL_SUM, &info));
  return info.nz_used;
}

// u.A u of linear temperatures, over all axes, is half of sum a_ij |x_ji|^2 and what the sums of the rows have.
TEST(NearestPairsParallel, KeepTheSumsOfRowsAndWhatLinearTemperaturesConduct) {
  for (const std::string jitter : {"", "jitter = 0.2\n"}) {
    const CaseModel model(box_case({"1 m", "1 m", "1 m"}, {8, 8, 8}) + jitter + simple_material({.k = "2"}) + rest,
                          MPI_COMM_WORLD);
    const Cloud& cloud = model.cloud();
    const petsc::Matrix J = jacobian(model);
    NearestPairs near(cloud);
    ASSERT_TRUE(near.set(J));
    ASSERT_TRUE(near.set(J));  // once more, with the same values
    Mat thin = near.matrix();
    EXPECT_LT(entries(thin), 0.5 * entries(J)) << jitter;
    constexpr int n = 8;
    if (jitter.empty()) {  // along the axes alone
      EXPECT_EQ(entries(thin), 7 * n * n * n - 6 * n * n);
    }
    const auto one = [](const Vec3&) { return 1.0; };
    EXPECT_NEAR(form(thin, cloud, one), form(J, cloud, one), 1e-12);
    double of_thin = 0, of_all = 0;
    for (int a = 0; a < 3; ++a) {
      const auto coordinate = [a](const Vec3& x) { return x[a]; };
      of_thin += form(thin, cloud, coordinate), of_all += form(J, cloud, coordinate);
    }
    EXPECT_NEAR(of_thin, of_all, 1e-10 * std::abs(of_all)) << jitter;
  }
}

// On lattices of unequal spacings pairs lie along the axes alone.
TEST(NearestPairs, AreNoneWhereTheWholeMatrixIsThin) {
  const CaseModel model(box_case({"1 m", "2 m", "1 m"}, {6, 6, 6}) + simple_material({.k = "2"}) + rest);
  const petsc::Matrix J = jacobian(model);
  EXPECT_FALSE(NearestPairs(model.cloud()).set(J));
}

}  // namespace
}  // namespace calor
