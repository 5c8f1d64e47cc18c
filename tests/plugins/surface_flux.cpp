// A surface flux: natural convection in air, q = C (T_ambient - T) |T_ambient - T|^(1/4).
#include "boundary/surface_fluxes.hpp"

#include <cmath>

#include "run_case.hpp"

namespace calor {
namespace {

class NaturalConvection final : public SurfaceFlux {
 public:
  NaturalConvection(double C, PointFunction ambient) : C_(C), ambient_(std::move(ambient)) {}

  void evaluate(const Arguments& args, std::span<double> q, std::span<double> dq_dT) const override {
    std::vector<double> ambient(q.size());
    ambient_.evaluate(args, ambient);
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double difference = ambient[i] - args.T[i], root = std::pow(std::abs(difference), 0.25);
      q[i] = C_ * difference * root;
      if (!dq_dT.empty()) dq_dT[i] = -1.25 * C_ * root;
    }
  }
  bool depends_on_temperature() const override { return true; }
  bool linear_in_temperature() const override { return false; }
  Changes changes() const override { return ambient_.function().changes(); }
  std::vector<double> ambient(std::span<const Vec3> x, double t) const override { return values_of(ambient_, x, t); }

 private:
  double C_;
  PointFunction ambient_;
};

void declare_natural_convection(Schema& schema) {
  schema.add({.path = "boundary.*.natural_convection",
              .sentence = "Natural convection in air.",
              .keys = {{"C", Kind::number, "", required, "C in q = C dT^(5/4), W/(m^2 K^1.25)."},
                       {"ambient", Kind::function, "K", required, "Temperature of the air."}}});
}

std::unique_ptr<SurfaceFlux> make_natural_convection(const Table& boundary, std::span<const Vec3> x) {
  const Table table = boundary.sub("natural_convection");
  return std::make_unique<NaturalConvection>(table.number("C"), PointFunction(table.function("ambient"), x));
}

TEST(Plugin, IsASurfaceFlux) {
  surface_fluxes().add({.name = "natural_convection",
                        .sentence = "natural convection in air",
                        .declare = declare_natural_convection,
                        .make = make_natural_convection});
  // Conduction of 9 W/(m K) over 1 m from 400 K to 310 K is 810 W/m^2: C = 810 / 10^1.25 lets it out at 310 K.
  expect_passes(bar + R"toml(
[material.m]
conductivity = "9 W/(m K)"
[steady]
[boundary.xmin]
temperature = "400 K"
[boundary.xmax]
natural_convection = { C = 45.54964734, ambient = "300 K" }
[[expect]]
field = true
value = { formula = "400 - 90*x", unit = "K" }
within = "1e-6 K"
)toml");
}

}  // namespace
}  // namespace calor
