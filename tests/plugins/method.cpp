// A method: heat goes between pairs of points by weights that fall with the fourth power of their distance, corrected
// so that linear temperatures are exact.
#include "conduction/method.hpp"

#include "conduction/correction.hpp"
#include "conduction/pair_conduction.hpp"
#include "run_case.hpp"

namespace calor {
namespace {

constexpr double support = 1.9;  // spacings

Support pair_support(const Case& /*c*/) { return support; }

Discretisation build_pairs(const Case& /*c*/, const Cloud& cloud, const Conditions& conditions,
                           const MaterialField& /*material*/, MethodReport& report) {
  Neighbours neighbours = find_neighbours(cloud, support);
  count_pairs(cloud, neighbours, report);
  const auto base_weights = [&] {
    std::vector<double> g(neighbours.column.size());
    for (int i = 0; i < cloud.owned; ++i)
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const Vec3 r = neighbours.x_ji(cloud.x, i, n);
        g[n] = cloud.volume[i] * cloud.volume[neighbours.column[n]] / (dot(r, r) * dot(r, r)) / cloud.cross_section;
      }
    return g;
  };
  CorrectionReport done;
  std::vector<double> G = consistent_weights(cloud, neighbours, base_weights, {}, done);
  return nodal_discretisation(cloud, conditions,
                              std::make_unique<PairConduction>(cloud, std::move(neighbours), std::move(G)));
}

TEST(Plugin, IsAMethod) {
  methods().add({.name = "pairs",
                 .sentence = "weights that fall with the fourth power of the distance",
                 .support = pair_support,
                 .build = build_pairs});
  expect_passes(R"toml(title = "plate"
method = "pairs"
[cloud]
shape = "box"
size = ["1 m", "1 m"]
points = [9, 9]
jitter = 0.2
[material.m]
conductivity = "1 W/(m K)"
[steady]
[boundary.all]
on = ["xmin", "xmax", "ymin", "ymax"]
temperature = { formula = "300 + 10*x - 20*y", unit = "K" }
[[expect]]
field = true
value = { formula = "300 + 10*x - 20*y", unit = "K" }
within = "1e-7 K"
)toml");
}

}  // namespace
}  // namespace calor
