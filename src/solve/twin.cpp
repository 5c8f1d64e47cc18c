#include "solve/twin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/cell_integrals.hpp"
#include "cloud/cracks.hpp"
#include "cloud/points.hpp"

namespace calor {
namespace {

/// Differences along an axis are over this part of the body's extent, those in time over this part of the run: between
/// truncation (square) and rounding (reciprocal).
constexpr double step_part = 1e-4;

/// Places of a quadrature, and the body at these places and a step to either side along every axis.
class Stencil {
 public:
  Stencil(const MaterialField& body, int dimension, const Vec3& step, CellSamples places, std::span<const int> all_tags)
      : dimension_(dimension), step_(step), places_(std::move(places)) {
    std::vector<int> tag;
    for (std::size_t k = 0; k + 1 < places_.row.size(); ++k)
      tag.insert(tag.end(), places_.row[k + 1] - places_.row[k], all_tags[places_.point[k]]);
    const std::vector<int> part(tag.size(), 0);
    shifted_.push_back(places_.x);
    for (int axis = 0; axis < dimension; ++axis)
      for (const int side : {1, -1}) {
        shifted_.push_back(places_.x);
        for (Vec3& x : shifted_.back()) x[axis] += side * step[axis];
      }
    for (const std::vector<Vec3>& x : shifted_) bodies_.emplace_back(body, x, tag, part);
  }

  const CellSamples& places() const { return places_; }
  std::size_t size() const { return places_.x.size(); }
  /// T at time t, K.
  std::vector<double> temperature(const Function& T, double t) const { return at(T, t, places_.x); }

  /// div (k grad T), W/m^3, by differences of differences; of axisymmetric bodies with k/r dT/dr.
  std::vector<double> divergence(const Function& T, double t, bool is_axisymmetric) const {
    std::vector<double> out(size(), 0), k(size());
    const std::vector<double> here = temperature(T, t);
    for (int axis = 0; axis < dimension_; ++axis) {
      const double h = step_[axis];
      for (const int side : {1, -1}) {
        std::vector<Vec3> far = places_.x;
        for (Vec3& x : far) x[axis] += 2 * side * h;
        const std::vector<double> beyond = at(T, t, far);
        conductivity(1 + 2 * axis + (side < 0), T, t, k);
        for (std::size_t n = 0; n < size(); ++n) out[n] += k[n] * (beyond[n] - here[n]) / (4 * h * h);
      }
    }
    if (is_axisymmetric) {
      const std::vector<Vec3> q = flux(T, t);
      for (std::size_t n = 0; n < size(); ++n) out[n] -= q[n].x / places_.x[n].x;
    }
    return out;
  }
  /// -k grad T, W/m^2.
  std::vector<Vec3> flux(const Function& T, double t) const {
    std::vector<Vec3> q(size());
    std::vector<double> k(size());
    conductivity(0, T, t, k);
    for (int axis = 0; axis < dimension_; ++axis) {
      const std::vector<double> above = at(T, t, shifted_[1 + 2 * axis]), below = at(T, t, shifted_[2 + 2 * axis]);
      for (std::size_t n = 0; n < size(); ++n) q[n][axis] = -k[n] * (above[n] - below[n]) / (2 * step_[axis]);
    }
    return q;
  }
  /// rho c dT/dt, W/m^3.
  std::vector<double> heating(const Function& T, double t, double dt) const {
    const std::vector<double> now = temperature(T, t), after = temperature(T, t + dt), before = temperature(T, t - dt);
    std::vector<double> rho_c(size());
    bodies_[0].enthalpy(now, {}, rho_c);
    for (std::size_t n = 0; n < size(); ++n) rho_c[n] *= (after[n] - before[n]) / (2 * dt);
    return rho_c;
  }

 private:
  static std::vector<double> at(const Function& T, double t, std::span<const Vec3> x) {
    std::vector<double> out(x.size());
    T.evaluate({.x = x, .t = t}, out);
    return out;
  }
  void conductivity(int shift, const Function& T, double t, std::span<double> k) const {
    bodies_[shift].conductivity(t, at(T, t, shifted_[shift]), k, {});
  }

  int dimension_;
  Vec3 step_;
  CellSamples places_;
  std::vector<std::vector<Vec3>> shifted_;  ///< the places, then a step up and down every axis
  std::vector<MaterialField> bodies_;       ///< at these
};

class TwinSource final : public Source {
 public:
  TwinSource(const Case& c, const Function& T, const Cloud& cloud, const Conditions& conditions,
             const MaterialField& body)
      : Source("twin"),
        T_(T),
        cloud_(cloud),
        body_(body),
        end_(c.root().has("time") ? c.section("time").number("end") : 0),
        power_(cloud.owned) {
    const Bounds bounds = bounds_of_all(cloud);
    step_ = step_part * (bounds.high - bounds.low);
    for (const SurfaceTerm& term : conditions.fluxes)
      given_.push_back({term.flux.get(), term.point, term.area, term.x});
    const CellIntegrals integrals(cloud);
    std::vector<int> facets;
    for (std::size_t n = 0; n < cloud.facets.size(); ++n) facets.push_back(static_cast<int>(n));
    collective_try(cloud.comm, [&] { cells_ = integrals.cells(), of_facets_ = integrals.facets(facets); });
    bind();
  }

  void integrate_over(const CellSamples& subdomains) override {
    cells_ = subdomains;
    bind();
  }

  void prepare(double t) override {
    if (t == t_ || (!std::isnan(t_) && end_ == 0)) return;
    t_ = t;
    collective_try(cloud_.comm, [&] { add_up(t); });
  }
  double add_power(double, std::span<const double>, std::span<double> P) const override {
    double added = 0;
    for (std::size_t i = 0; i < power_.size(); ++i) P[i] += power_[i], added += power_[i];
    return added;
  }
  void add_derivative(double, std::span<const double>, std::span<double>) const override {}
  bool depends_on_temperature() const override { return false; }
  std::vector<double> events() const override { return T_.events(); }

 private:
  /// Collective.
  void bind() {
    in_cells_.emplace(body_, cloud_.dimension, step_, cells_, cloud_.tag);
    on_facets_.emplace(body_, cloud_.dimension, step_, of_facets_, cloud_.tag);
  }

  void add_up(double t) {
    std::ranges::fill(power_, 0.0);
    std::vector<double> lacks = in_cells_->divergence(T_, t, cloud_.axisymmetric);
    for (double& value : lacks) value = -value;
    if (end_ > 0) {
      const std::vector<double> heating = in_cells_->heating(T_, t, step_part * end_);
      for (std::size_t n = 0; n < lacks.size(); ++n) lacks[n] += heating[n];
    }
    add(in_cells_->places(), [&](std::size_t, std::int64_t n) { return lacks[n]; });
    const std::vector<Vec3> q = on_facets_->flux(T_, t);
    add(on_facets_->places(),
        [&](std::size_t facet, std::int64_t n) { return -dot(q[n], cloud_.facets[facet].normal); });
    for (const Given& given : given_) {
      std::vector<double> T(given.x.size()), inwards(given.x.size());
      T_.evaluate({.x = given.x, .t = t}, T);
      given.flux->evaluate({.x = given.x, .t = t, .T = T}, inwards, {});
      for (std::size_t n = 0; n < inwards.size(); ++n) power_[given.point[n]] -= given.area[n] * inwards[n];
    }
  }
  /// The integrals of f, of the row and the place.
  template <class Density>
  void add(const CellSamples& places, const Density& f) {
    for (std::size_t k = 0; k + 1 < places.row.size(); ++k)
      for (std::int64_t n = places.row[k]; n < places.row[k + 1]; ++n)
        power_[places.point[k]] += places.weight[n] * f(k, n);
  }

  Function T_;
  const Cloud& cloud_;
  const MaterialField& body_;  // while the model is built
  struct Given {
    const SurfaceFlux* flux;
    std::vector<int> point;
    std::vector<double> area;
    std::span<const Vec3> x;
  };
  std::vector<Given> given_;  // fluxes of the conditions
  double end_;                // s; 0 for a steady case
  Vec3 step_;
  CellSamples cells_, of_facets_;
  std::optional<Stencil> in_cells_, on_facets_;
  double t_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> power_;  // of the owned points, at t_
};

}  // namespace

std::optional<Function> read_twin(const Case& c, const Cloud& cloud) {
  if (!c.root().has("twin")) return std::nullopt;
  const Table table = c.section("twin");
  const Function T = table.function("temperature");
  if (T.depends_on_temperature()) table.refuse("temperature", "the solution depends on T", "write it in x, y, z and t");
  if (T.may_jump()) table.refuse("temperature", "the solution may jump or bend", "take a smooth one, of sin and cos");
  if (c.root().has("steady") && T.depends_on_time())
    table.refuse("temperature", "the solution of a steady case depends on t", "leave t out");
  if (has_cracks(c)) table.refuse("", "a cracked body has no smooth solution", "leave the cracks out");
  if (!cloud.points_on_walls || !cloud.has_areas)
    table.refuse("", "the points of the cloud lie off its walls", "take a cloud with points on the walls");
  return T;
}

void prescribe_twin(const Function& T, const Cloud& cloud, Conditions& conditions, std::vector<double>& T_start) {
  for (PrescribedTerm& term : conditions.temperatures) term.temperature = T;
  T_start.resize(cloud.owned);
  collective_try(cloud.comm, [&] { T.evaluate({.x = cloud.owned_points()}, T_start); });
}

std::unique_ptr<Source> make_twin_source(const Case& c, const Function& T, const Cloud& cloud,
                                         const Conditions& conditions, const MaterialField& body) {
  if (body.parts().count() > 1)
    c.section("twin").refuse("", "the flux of a smooth temperature jumps where the parts of the body meet",
                             "give the body one material");
  if (body.mean() == Mean::harmonic)
    c.section("twin").refuse("", "the conductivity jumps between layers",
                             "make it smooth, or take [[body.layer]] of one");
  if (!body.is_isotropic())
    c.section("twin").refuse("", "the body conducts differently by direction", "leave 'anisotropy' out");
  return std::make_unique<TwinSource>(c, T, cloud, conditions, body);
}

void declare_twin(Schema& schema) {
  schema.add({.path = "twin",
              .sentence =
                  "Replaces the solution by a formula: start and prescribed temperatures are its own, sources of "
                  "the case are left out, and what the heat equation lacks goes in. So the error of a run is "
                  "known (docs/certify.md).",
              .keys = {{"temperature", Kind::function, "K", required, "The solution, smooth, of place and time."}}});
}

}  // namespace calor
