// Convergence of the shipped cases of welding.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/run.hpp"
#include "app/schema.hpp"

namespace calor {
namespace {

/// Mean over several times of the error of the liquidus, m, in a melting half-space.
double front_error(double spacing_mm, bool narrow) {
  const double front = narrow ? 5.793701e-3 : 5.358148e-3;  // at 60 s, cases/dan/reference/melting.py
  std::string text = fmt::format(R"toml(title = "melting"
method = "sph"
[cloud]
shape = "box"
size = ["200 mm"]
spacing = "{} mm"
[material.steel]
conductivity = "30 W/(m K)"
density = "7850 kg/m^3"
specific_heat = "650 J/(kg K)"
latent_heat = "270 kJ/kg"
solidus = "{} degC"
liquidus = "{} degC"
[boundary.xmin]
temperature = "1800 degC"
[initial]
temperature = "20 degC"
[time]
end = "60 s"
integrator = "crank-nicolson"
step = "0.05 s"
[weld.extent.liquid]
from = ["0 mm"]
to = ["100 mm"]
isotherm = "{} degC"
)toml",
                                 spacing_mm, narrow ? 1474 : 1450, narrow ? 1476 : 1500, narrow ? 1476 : 1500);
  constexpr int count = 24;
  for (int n = 1; n <= count; ++n) {
    const double t = 12 + 2 * n;  // fronts go as the root of time
    text += fmt::format(
        "[[expect]]\nquantity = \"extent\"\nextent = \"liquid\"\nat = \"{} s\"\nvalue = \"{} m\"\nwithin = \"1 m\"\n",
        t, front * std::sqrt(t / 60));
  }
  double error = 0;
  for (const Verdict& v :
       run(Case::parse(text, "melting.toml", schema()), MPI_COMM_SELF, {.folder = "", .quiet = true}).verdicts)
    error += v.error / count;
  return error;
}

TEST(Melting, FrontsConvergeWithTheSpacing) {
  // A front goes from point to point: the error at any one time is a part of a spacing.
  for (const bool narrow : {false, true}) {
    const double coarse = front_error(1, narrow), middle = front_error(0.5, narrow), fine = front_error(0.25, narrow);
    EXPECT_LE(fine, 0.5e-3);
    EXPECT_GE(std::log2(coarse / fine) / 2, 0.9) << coarse << ", " << middle << ", " << fine;
  }
}

}  // namespace
}  // namespace calor
