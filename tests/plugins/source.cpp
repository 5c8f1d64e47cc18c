// A source: the heat of an electric current, Q = rho j^2.
#include "source/source.hpp"

#include "run_case.hpp"

namespace calor {
namespace {

class JouleHeat final : public Source {
 public:
  JouleHeat(const std::string& name, double density, const Cloud& cloud)
      : Source(name), density_(density), volume_(cloud.volume.begin(), cloud.volume.begin() + cloud.owned) {}

  void integrate_over(const CellSamples& subdomains) override {
    for (std::size_t i = 0; i < volume_.size(); ++i) {
      volume_[i] = 0;
      for (auto s = subdomains.row[i]; s < subdomains.row[i + 1]; ++s) volume_[i] += subdomains.weight[s];
    }
  }
  double add_power(double /*t*/, std::span<const double> /*T*/, std::span<double> P) const override {
    double added = 0;
    for (std::size_t i = 0; i < volume_.size(); ++i) {
      P[i] += density_ * volume_[i];
      added += density_ * volume_[i];
    }
    return added;
  }
  void add_derivative(double, std::span<const double>, std::span<double>) const override {}
  bool depends_on_temperature() const override { return false; }
  Changes changes() const override { return {}; }

 private:
  double density_;              // W/m^3
  std::vector<double> volume_;  // m^3, of the owned points
};

void declare_joule_heat(Schema& schema) {
  schema.add({.path = "source.*.current",
              .sentence = "The heat of an electric current.",
              .keys = {{"density", Kind::quantity, "A/m^2", required, "Density of the current."},
                       {"resistivity", Kind::quantity, "ohm m", required, "Electrical resistivity."}}});
}

std::unique_ptr<Source> make_joule_heat(const std::string& name, const Table& table, const Cloud& cloud) {
  const Table current = table.sub("current");
  const double j = current.number("density");
  return std::make_unique<JouleHeat>(name, current.number("resistivity") * j * j, cloud);
}

TEST(Plugin, IsASource) {
  source_kinds().add({.name = "current",
                      .sentence = "the heat of an electric current",
                      .declare = declare_joule_heat,
                      .make = make_joule_heat});
  // 1e-7 ohm m * (1e6 A/m^2)^2 = 1e5 W/m^3 for 10 s in 1e6 J/(m^3 K): 1 K.
  expect_passes(bar + R"toml(
[material.m]
conductivity = "1 W/(m K)"
density = "1000 kg/m^3"
specific_heat = "1000 J/(kg K)"
[initial]
temperature = "300 K"
[source.wire]
current = { density = "1 A/mm^2", resistivity = "100 nohm m" }
[time]
end = "10 s"
[[expect]]
field = true
value = "301 K"
within = "1e-9 K"
)toml");
}

}  // namespace
}  // namespace calor
