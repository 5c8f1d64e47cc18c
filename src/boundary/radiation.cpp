// Radiation to large surroundings: k dT/dn = eps sigma (T_ambient^4 - T^4), n outward, T absolute.
#include <limits>

#include "boundary/surface_fluxes.hpp"

namespace calor {
namespace {

constexpr double sigma = 5.670374419e-8;  // W/(m^2 K^4), CODATA 2018

class Radiation final : public SurfaceFlux {
 public:
  Radiation(PointFunction emissivity, PointFunction ambient)
      : emissivity_(std::move(emissivity)), ambient_(std::move(ambient)) {}

  void evaluate(const Arguments& args, std::span<double> q, std::span<double> dq_dT) const override {
    const std::size_t n = q.size();
    std::vector<double> eps(n), ambient(n), slope(dq_dT.empty() ? 0 : n);
    emissivity_.evaluate(args, eps);
    check_range(eps, 0, 1, emissivity_.function(), args, "emissivity", "", "it lies between 0 and 1");
    ambient_.evaluate(args, ambient);
    check_range(ambient, 0, std::numeric_limits<double>::max(), ambient_.function(), args,
                "ambient temperature of the radiation", "K", "it is absolute and cannot be negative");
    const auto driving = [&](std::size_t i) {  // T_a^4 - T^4 without cancellation
      const double T = args.T[i], T_a = ambient[i];
      return (T_a - T) * (T_a + T) * (T_a * T_a + T * T);
    };
    for (std::size_t i = 0; i < n; ++i) q[i] = eps[i] * sigma * driving(i);
    if (dq_dT.empty()) return;
    emissivity_.derivative(args, slope);
    for (std::size_t i = 0; i < n; ++i) {
      const double T = args.T[i];
      dq_dT[i] = sigma * (slope[i] * driving(i) - 4 * eps[i] * T * T * T);
    }
  }
  bool depends_on_temperature() const override { return true; }
  bool depends_on_place() const override {
    return emissivity_.function().depends_on_place() || ambient_.function().depends_on_place();
  }
  bool draws_to_ambient() const override { return true; }
  bool linear_in_temperature() const override { return false; }
  Changes changes() const override { return changes_of(emissivity_.function(), ambient_.function()); }
  std::vector<double> ambient(std::span<const Vec3> x, double t) const override { return values_of(ambient_, x, t); }

 private:
  PointFunction emissivity_, ambient_;
};

}  // namespace

SurfaceFluxKind radiation() {
  return {.name = "radiation",
          .sentence = "radiation to large surroundings",
          .declare =
              [](Schema& schema) {
                schema.add({.path = "boundary.*.radiation",
                            .sentence = "Radiation: the heat flux into the body is emissivity sigma (ambient^4 - T^4).",
                            .keys = {{"emissivity", Kind::function, "", required, "Emissivity of the surface, 0 to 1."},
                                     {"ambient", Kind::function, "K", required,
                                      "Temperature of the surroundings, absolute."}}});
              },
          .make = [](const Table& boundary, std::span<const Vec3> x) -> std::unique_ptr<SurfaceFlux> {
            const Table table = boundary.sub("radiation");
            return std::make_unique<Radiation>(PointFunction(table.function("emissivity"), x),
                                               PointFunction(ambient_of(table), x));
          }};
}

}  // namespace calor
