// Prescribed heat flux: k dT/dn = q, n outward; q > 0 heats.
#include <algorithm>

#include "base/point_function.hpp"
#include "boundary/surface_fluxes.hpp"

namespace calor {
namespace {

class PrescribedFlux final : public SurfaceFlux {
 public:
  explicit PrescribedFlux(PointFunction q) : q_(std::move(q)) {}

  void evaluate(const Arguments& args, std::span<double> q, std::span<double> dq_dT) const override {
    q_.evaluate(args, q);
    if (!dq_dT.empty()) q_.derivative(args, dq_dT);
  }
  bool depends_on_temperature() const override { return q_.function().depends_on_temperature(); }
  bool linear_in_temperature() const override { return !depends_on_temperature(); }
  std::vector<double> events() const override { return q_.function().events(); }
  std::vector<double> ambient(std::span<const Vec3>, double) const override { return {}; }

 private:
  PointFunction q_;
};

}  // namespace

SurfaceFluxKind prescribed_flux() {
  return {
      .name = "flux",
      .sentence = "a prescribed heat flux",
      .declare =
          [](Schema& schema) {
            schema.add({.path = "boundary.*",
                        .sentence = "Prescribed heat flux.",
                        .keys = {{"flux", Kind::function, "W/m^2", optional, "Heat flux into the body; > 0 heats."}}});
          },
      .make = [](const Table& boundary, std::span<const Vec3> x) -> std::unique_ptr<SurfaceFlux> {
        return std::make_unique<PrescribedFlux>(PointFunction(boundary.function("flux"), x));
      }};
}

}  // namespace calor
