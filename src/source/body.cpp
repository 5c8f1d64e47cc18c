// Heat set free in the volume: P_i = integral of Q(x, t, T_i) over the cell of point i, or over its subdomain.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "base/function.hpp"
#include "base/parallel.hpp"
#include "base/ramped_function.hpp"
#include "cloud/cell_integrals.hpp"
#include "source/path.hpp"
#include "source/source.hpp"

namespace calor {
namespace {

/// What depends on place has a rule of places in every cell. Where it jumps, the rule follows the jumps: of a function
/// of place alone once, of one of time at every time.
class BodySource final : public Source {
 public:
  BodySource(const std::string& name, const Function& density, const Cloud& cloud)
      : Source(name), density_(density), ramped_(density), cloud_(cloud), cells_(cloud), power_(cloud.owned) {
    if (!density_.depends_on_place()) measure_ = {cloud.volume.begin(), cloud.volume.begin() + cloud.owned};
  }

  void integrate_over(const CellSamples& subdomains) override {
    rule_ = subdomains, rule_is_given_ = true;
    measure_.assign(cloud_.owned, 0);
    for (std::size_t i = 0; i < measure_.size(); ++i)
      for (auto n = rule_->row[i]; n < rule_->row[i + 1]; ++n) measure_[i] += rule_->weight[n];
  }

  void prepare(double t) override {
    if (depends_on_temperature() || t == t_) return;
    const bool first = std::isnan(t_);
    t_ = t;
    if (!first && !density_.depends_on_time()) return;
    if (!density_.depends_on_place() || rule_is_given_ || keeps_its_places())
      collective_try(cloud_.comm, [&] { add_up(t, {}, false); });
    else
      follow_jumps(t);
  }

  double add_power(double t, std::span<const double> T, std::span<double> P) const override {
    if (depends_on_temperature()) add_up(t, T, false);
    double added = 0;
    for (std::size_t i = 0; i < power_.size(); ++i) P[i] += power_[i], added += power_[i];
    return added;
  }
  void add_derivative(double t, std::span<const double> T, std::span<double> dP_dT) const override {
    if (!depends_on_temperature()) return;
    add_up(t, T, true);
    for (std::size_t i = 0; i < power_.size(); ++i) dP_dT[i] += power_[i];
  }
  bool depends_on_temperature() const override { return density_.depends_on_temperature(); }
  Changes changes() const override { return density_.changes(); }

 private:
  /// Does the rule stay while time goes on? That of a smooth function does; cells that are no boxes or sectors have all
  /// of their samples from the start.
  bool keeps_its_places() const {
    return density_.depends_on_time() && (!density_.may_jump() || !(cloud_.lattice || cloud_.rings));
  }

  /// For functions of place, perhaps of time. Collective.
  void follow_jumps(double t) {
    double scale = 0;  // heat that is tiny beside the largest needs no digits
    collective_try(cloud_.comm, [&] {
      values_.resize(cloud_.owned);
      density_.evaluate({.x = cloud_.owned_points(), .t = t}, values_);
      for (const double value : values_) scale = std::max(scale, std::abs(value));
    });
    scale = max(cloud_.comm, scale);
    collective_try(cloud_.comm, [&] {
      const auto f = [&](std::span<const Vec3> x, std::span<double> out) { density_.evaluate({.x = x, .t = t}, out); };
      power_ = cells_.over_cells(
          {.f = f, .may_jump = density_.may_jump(), .quick = density_.depends_on_time(), .scale = scale});
    });
  }

  /// power_: the integrals at time t of the density, or of its derivative by T.
  void add_up(double t, std::span<const double> T, bool derivative) const {
    const auto values_at = [&](std::span<const Vec3> x, std::span<const double> T) {
      values_.resize(x.size());
      const Arguments args{.x = x, .t = t, .T = T};
      derivative ? ramped_.derivative(args, values_) : ramped_.evaluate(args, values_);
    };
    if (!density_.depends_on_place()) {
      values_at(cloud_.owned_points(), T.empty() ? T : T.first(power_.size()));
      for (std::size_t i = 0; i < power_.size(); ++i) power_[i] = measure_[i] * values_[i];
      return;
    }
    find_rule(t, T);
    if (!T.empty()) {
      T_.resize(rule_->x.size());
      for (std::size_t i = 0; i < power_.size(); ++i)
        std::fill(T_.begin() + rule_->row[i], T_.begin() + rule_->row[i + 1], T[i]);
    }
    values_at(rule_->x, T.empty() ? T : std::span<const double>(T_));
    for (std::size_t i = 0; i < power_.size(); ++i) {
      power_[i] = 0;
      for (auto n = rule_->row[i]; n < rule_->row[i + 1]; ++n) power_[i] += rule_->weight[n] * values_[n];
    }
  }

  void find_rule(double t, std::span<const double> T) const {
    if (rule_is_given_ || (rule_ && (keeps_its_places() || !density_.depends_on_time() || t == rule_t_))) return;
    rule_t_ = t;
    if (!density_.may_jump() || keeps_its_places()) {
      rule_ = density_.may_jump() ? CellSampler(cloud_).all() : cells_.cells();
      return;
    }
    rule_.emplace();
    for (int i = 0; i < cloud_.owned; ++i) {
      const auto f = [&](std::span<const Vec3> x, std::span<double> out) {
        point_T_.assign(x.size(), T.empty() ? 0 : T[i]);
        density_.evaluate({.x = x, .t = t, .T = point_T_}, out);
      };
      cells_.add_cell(i, {.f = f}, *rule_);
    }
  }

  Function density_;  // W/m^3
  RampedFunction ramped_;
  const Cloud& cloud_;
  CellIntegrals cells_;
  std::vector<double> measure_;  // of functions that do not depend on place: volumes of the cells or subdomains, m^3
  bool rule_is_given_ = false;
  mutable std::optional<CellSamples> rule_;
  double t_ = std::numeric_limits<double>::quiet_NaN();
  mutable double rule_t_ = t_;
  mutable std::vector<double> power_, values_, T_, point_T_;
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
                                      "Power per volume, of place, time and temperature, integrated over the cells of "
                                      "the points; > 0 heats."}}});
              },
          .make = [](const std::string& name, const Table& table, const Cloud& cloud) -> std::unique_ptr<Source> {
            refuse_path(table);
            return std::make_unique<BodySource>(name, table.function("power_density"), cloud);
          }};
}

}  // namespace calor
