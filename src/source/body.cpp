// Heat set free in the volume: P_i = Q(x_i, t, T_i) V_i, V_i the volume of the point's cell or subdomain.
#include <numeric>
#include <vector>

#include "base/function.hpp"
#include "source/path.hpp"
#include "source/source.hpp"

namespace calor {
namespace {

class BodySource final : public Source {
 public:
  BodySource(const std::string& name, const Function& density, const Cloud& cloud)
      : Source(name),
        density_(density, cloud.owned_points()),
        cloud_(cloud),
        volume_(cloud.volume.begin(), cloud.volume.begin() + cloud.owned),
        work_(cloud.owned) {}

  void integrate_over(const CellSamples& subdomains) override {
    for (std::size_t i = 0; i < volume_.size(); ++i)
      volume_[i] = std::accumulate(subdomains.weight.begin() + subdomains.row[i],
                                   subdomains.weight.begin() + subdomains.row[i + 1], 0.0);
  }

  void add_power(double t, std::span<const double> T, std::span<double> P) const override {
    density_.evaluate({.x = cloud_.owned_points(), .t = t, .T = T.first(work_.size())}, work_);
    for (std::size_t i = 0; i < work_.size(); ++i) P[i] += work_[i] * volume_[i];
  }
  void add_derivative(double t, std::span<const double> T, std::span<double> dP_dT) const override {
    if (!depends_on_temperature()) return;
    density_.derivative({.x = cloud_.owned_points(), .t = t, .T = T.first(work_.size())}, work_);
    for (std::size_t i = 0; i < work_.size(); ++i) dP_dT[i] += work_[i] * volume_[i];
  }
  bool depends_on_temperature() const override { return density_.function().depends_on_temperature(); }
  std::vector<double> events() const override { return density_.function().events(); }

 private:
  PointFunction density_;  // W/m^3
  const Cloud& cloud_;
  std::vector<double> volume_;  // m^3
  mutable std::vector<double> work_;
};

}  // namespace

SourceKind body_source() {
  return {.name = "power_density",
          .sentence = "A heat source in the body",
          .declare =
              [](Schema& schema) {
                schema.add({.path = "source.*",
                            .sentence = "A heat source in the body.",
                            .keys = {{"power_density", Kind::function, "W/m^3", optional,
                                      "Power per volume, of place, time and temperature; > 0 heats."}}});
              },
          .make = [](const std::string& name, const Table& table, const Cloud& cloud) -> std::unique_ptr<Source> {
            refuse_path(table);
            return std::make_unique<BodySource>(name, table.function("power_density"), cloud);
          }};
}

}  // namespace calor
