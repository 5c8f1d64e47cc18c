// Convection: k dT/dn = h (T_ambient - T), n outward.
#include <limits>

#include "base/ramped_function.hpp"
#include "boundary/surface_fluxes.hpp"

namespace calor {
namespace {

class Convection final : public SurfaceFlux {
 public:
  Convection(RampedFunction h, PointFunction ambient) : h_(std::move(h)), ambient_(std::move(ambient)) {}

  void evaluate(const Arguments& args, std::span<double> q, std::span<double> dq_dT) const override {
    const std::size_t n = q.size();
    std::vector<double> h(n), ambient(n), slope(dq_dT.empty() ? 0 : n);
    h_.evaluate(args, h);
    check_range(h, 0, std::numeric_limits<double>::max(), h_.function(), args, "heat transfer coefficient h",
                "W/(m^2 K)", "it cannot be negative");
    ambient_.evaluate(args, ambient);
    for (std::size_t i = 0; i < n; ++i) q[i] = h[i] * (ambient[i] - args.T[i]);
    if (dq_dT.empty()) return;
    h_.derivative(args, slope);
    for (std::size_t i = 0; i < n; ++i) dq_dT[i] = slope[i] * (ambient[i] - args.T[i]) - h[i];
  }
  bool depends_on_temperature() const override { return true; }
  bool depends_on_place() const override {
    return h_.function().depends_on_place() || ambient_.function().depends_on_place();
  }
  bool draws_to_ambient() const override { return true; }
  bool linear_in_temperature() const override { return !h_.function().depends_on_temperature(); }
  bool derivative_depends_on_time() const override { return h_.function().depends_on_time(); }
  Changes changes() const override { return changes_of(h_.function(), ambient_.function()); }
  std::vector<double> ambient(std::span<const Vec3> x, double t) const override { return values_of(ambient_, x, t); }

 private:
  RampedFunction h_;
  PointFunction ambient_;
};

}  // namespace

SurfaceFluxKind convection() {
  return {.name = "convection",
          .sentence = "heat transfer by convection",
          .declare =
              [](Schema& schema) {
                schema.add({.path = "boundary.*.convection",
                            .sentence = "Convection: the heat flux into the body is h (ambient - T).",
                            .keys = {{"h", Kind::function, "W/(m^2 K)", required, "Heat transfer coefficient."},
                                     {"ambient", Kind::function, "K", required, "Temperature of the surroundings."}}});
              },
          .make = [](const Table& boundary, std::span<const Vec3> x) -> std::unique_ptr<SurfaceFlux> {
            const Table table = boundary.sub("convection");
            return std::make_unique<Convection>(RampedFunction(table.function("h"), x),
                                                PointFunction(ambient_of(table), x));
          }};
}

}  // namespace calor
