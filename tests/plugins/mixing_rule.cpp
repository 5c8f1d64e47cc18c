// A mixing rule: the mean of the bounds of Voigt and Reuss (Hill, Proc. Phys. Soc. A 65 (1952) 349).
#include "material/mixing_rules.hpp"

#include "run_case.hpp"

namespace calor {
namespace {

void hill(std::span<const double> v, std::span<const double> k, std::span<double> mixed, std::span<double> dmixed_dk) {
  const std::size_t n = mixed.size();
  for (std::size_t i = 0; i < n; ++i) {
    double voigt = 0, resistance = 0;
    for (std::size_t p = i; p < v.size(); p += n) voigt += v[p] * k[p], resistance += v[p] / k[p];
    mixed[i] = 0.5 * (voigt + 1 / resistance);
    for (std::size_t p = i; p < v.size(); p += n)
      dmixed_dk[p] = 0.5 * v[p] * (1 + 1 / (k[p] * resistance * k[p] * resistance));
  }
}

TEST(Plugin, IsAMixingRule) {
  mixing_rules().add({.name = "hill",
                      .sentence = "the mean of voigt and reuss",
                      .source = "Hill, Proc. Phys. Soc. A 65 (1952) 349",
                      .mix = hill});
  // Half and half of 1 and 4 W/(m K): Voigt 2.5, Reuss 1.6.
  expect_passes(bar + R"toml(
[material.first]
conductivity = "1 W/(m K)"
[material.second]
conductivity = "4 W/(m K)"
[material.both]
mix = "hill"
phases = ["first", "second"]
fraction = 0.5
basis = "volume"
[steady]
[boundary.ends]
on = ["xmin", "xmax"]
temperature = "300 K"
[[expect]]
quantity = "conductivity"
field = true
value = "2.05 W/(m K)"
within = "1e-12 W/(m K)"
)toml");
}

}  // namespace
}  // namespace calor
