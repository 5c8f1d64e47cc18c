// A profile of a moving source: a beam of even strength over a square, through the thickness of a plate.
#include "source/source_profile.hpp"

#include "run_case.hpp"

namespace calor {
namespace {

SourceProfile make_beam(const Table& beam, const Cloud& /*cloud*/) {
  const double width = positive_length(beam, "width");
  return {.along = AxisProfile::box(width),
          .across = AxisProfile::box(width),
          .axis = 2,
          .radius = width,
          .sigma = width / 4};
}

TEST(Plugin, IsASourceProfile) {
  source_profiles().add({.name = "beam",
                         .sentence = "A beam of even strength over a square, through the thickness of a plate",
                         .keys = {{"width", Kind::quantity, "m", required, "Side of the square."}},
                         .make = make_beam});
  // A quarter of a plate of 1 m x 1 m x 1 m: 1000 W there for 10 s in 1e6 J/(m^3 K) is 0.04 K, elsewhere nothing.
  expect_passes(R"toml(title = "plate"
method = "sph"
[cloud]
shape = "box"
size = ["1 m", "1 m"]
points = [8, 8]
at = "cells"
[material.m]
conductivity = "1e-9 W/(m K)"
density = "1000 kg/m^3"
specific_heat = "1000 J/(kg K)"
[initial]
temperature = "300 K"
[source.laser]
beam = { width = "0.5 m" }
at = ["0.5 m", "0.5 m"]
power = "1 kW"
[time]
end = "10 s"
[[expect]]
field = true
value = { formula = "300 + (abs(x - 0.5) < 0.25 && abs(y - 0.5) < 0.25 ? 0.04 : 0)", unit = "K" }
within = "1e-6 K"
)toml");
}

}  // namespace
}  // namespace calor
