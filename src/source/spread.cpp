// A power that is spread over the body, a region or faces, evenly or by a relative density: what goes in is exactly the
// power.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "base/parallel.hpp"
#include "boundary/segments.hpp"
#include "cloud/cell_integrals.hpp"
#include "source/source.hpp"

namespace calor {
namespace {

class SpreadSource final : public Source {
 public:
  SpreadSource(const Case& c, const std::string& name, const Table& table, const Cloud& cloud)
      : Source(name),
        table_(table),
        cloud_(cloud),
        power_(table.function("power")),
        efficiency_(table.number("efficiency")),
        density_(table.function("relative_density")),
        is_even_(!table.has("relative_density")) {
    if (power_.depends_on_place() || power_.depends_on_temperature())
      table.refuse("power", "the power depends on more than time", "spread it by 'relative_density', of place");
    if (density_.depends_on_time() || density_.depends_on_temperature())
      table.refuse("relative_density", "the relative density depends on more than place",
                   "let 'power' depend on time; or take power_density");
    if (!(efficiency_ > 0 && efficiency_ <= 1))
      table.refuse("efficiency", fmt::format("an efficiency of {:g} does not lie between 0 and 1", efficiency_),
                   "give a number above 0 and not above 1");
    if (table.has("where")) where_ = where_function(c, table);
    collective_try(cloud.comm, [&] { table.has("on") ? spread_over_faces() : spread_over_cells(); });
    normalise();
  }

  void integrate_over(const CellSamples& subdomains) override {
    if (table_.has("on")) return;
    std::vector<double> value(subdomains.x.size());
    collective_try(cloud_.comm, [&] { relative(subdomains.x, value); });
    for (std::size_t i = 0; i < share_.size(); ++i) {
      share_[i] = 0;
      for (auto n = subdomains.row[i]; n < subdomains.row[i + 1]; ++n) share_[i] += subdomains.weight[n] * value[n];
    }
    normalise();
  }
  double add_power(double t, std::span<const double>, std::span<double> P) const override {
    const double power = *asked(t);
    double added = 0;
    for (std::size_t i = 0; i < share_.size(); ++i) {
      P[i] += power * share_[i];
      added += power * share_[i];
    }
    return added;
  }
  void add_derivative(double, std::span<const double>, std::span<double>) const override {}
  bool depends_on_temperature() const override { return false; }
  Changes changes() const override { return power_.changes(); }
  std::optional<double> asked(double t) const override { return efficiency_ * power_({}, t); }
  std::optional<double> energy_asked(double t) const override {
    if (!power_.is_constant()) return {};
    return t * *asked(0);
  }

 private:
  void relative_density(std::span<const Vec3> x, std::span<double> out) const {
    std::ranges::fill(out, 1.0);
    if (!is_even_) density_.evaluate({.x = x}, out);
    for (std::size_t n = 0; n < out.size(); ++n)
      if (out[n] < 0)
        table_.refuse(
            "relative_density",
            fmt::format("the relative density is {:g} at ({:.6g}, {:.6g}, {:.6g}) m", out[n], x[n].x, x[n].y, x[n].z),
            "it cannot be negative");
  }
  /// Heat goes in as this, times a number.
  void relative(std::span<const Vec3> x, std::span<double> out) const {
    relative_density(x, out);
    if (!where_) return;
    std::vector<double> in(x.size());
    where_->evaluate({.x = x}, in);
    for (std::size_t n = 0; n < out.size(); ++n)
      if (in[n] == 0) out[n] = 0;
  }
  Integrand integrand() const {
    return {.f = [this](std::span<const Vec3> x, std::span<double> out) { relative(x, out); },
            .may_jump = where_.has_value() || density_.may_jump()};
  }

  void spread_over_cells() { share_ = CellIntegrals(cloud_).over_cells(integrand()); }

  void spread_over_faces() {
    std::uint32_t faces = 0;
    for (const std::string& name : table_.texts("on")) {
      const auto face = std::ranges::find(cloud_.faces, name);
      if (face == cloud_.faces.end())
        table_.refuse("on", fmt::format("there is no face '{}'", name),
                      cloud_.faces.empty() ? "the cloud has none"
                                           : fmt::format("the faces are {}", fmt::join(cloud_.faces, ", ")));
      faces |= 1u << (face - cloud_.faces.begin());
    }
    if (!cloud_.has_areas) table_.refuse("on", "the cloud has no boundary areas", "add them to its file");
    Selection selection{.facets = {}, .where = where_};
    for (std::size_t n = 0; n < cloud_.facets.size(); ++n)
      if (faces >> cloud_.facets[n].face & 1) selection.facets.push_back(static_cast<int>(n));
    const CellIntegrals integrals(cloud_);
    const Segments parts = is_even_ ? selected_facets(integrals, cloud_, selection)
                                    : selected_places(integrals, cloud_, selection, integrand());
    std::vector<double> density(parts.x.size());
    relative_density(parts.x, density);
    share_.assign(cloud_.owned, 0);
    for (std::size_t n = 0; n < parts.x.size(); ++n) share_[parts.point[n]] += parts.area[n] * density[n];
  }

  void normalise() {
    const double whole = sum(cloud_.comm, share_);
    if (!(whole > 0))
      table_.refuse(where_     ? "where"
                    : is_even_ ? ""
                               : "relative_density",
                    fmt::format("[{}] heats nothing of the body", table_.path()),
                    "change the selection; lengths in 'where' are in 'length', by default m");
    for (double& share : share_) share /= whole;
  }

  Table table_;
  const Cloud& cloud_;
  Function power_;  // W
  double efficiency_;
  Function density_;
  bool is_even_;
  std::optional<Function> where_;
  std::vector<double> share_;  // of the owned points; they add up to 1
};

}  // namespace

std::unique_ptr<Source> make_spread_source(const Case& c, const std::string& name, const Table& table,
                                           const Cloud& cloud) {
  for (const char* key : {"half", "normalise"})
    if (table.has(key)) table.refuse(key, fmt::format("'{}' goes with a source that moves", key), "leave it out");
  return std::make_unique<SpreadSource>(c, name, table, cloud);
}

void declare_spread_source(Schema& schema) {
  std::vector<Key> keys = where_keys(
      "Of a source that has only a power: formula in x, y, z, r that is true where it is spread; default: all over the "
      "body or the faces.");
  keys.push_back({"on", Kind::texts, "", optional, "Face or faces over which the power is spread, not the body."});
  keys.push_back({"relative_density", Kind::function, "", "1",
                  "How the power is spread, of place, times any number; default: evenly."});
  schema.add({.path = "source.*",
              .sentence = "A power that is spread over the body, a region or faces: exactly the power goes in.",
              .keys = keys});
}

}  // namespace calor
