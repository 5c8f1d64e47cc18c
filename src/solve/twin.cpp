#include "solve/twin.hpp"

#include <fmt/format.h>

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

/// Places of a quadrature that lie in one part, and the rows of the whole quadrature that they are of.
struct PlacesInPart {
  CellSamples places;
  std::vector<std::size_t> from;
};

/// Collective, as parts may refuse places on one rank alone.
std::vector<PlacesInPart> split(const CellSamples& all, const Cloud& cloud, const Parts& parts) {
  std::vector<PlacesInPart> split(parts.count());
  collective_try(cloud.comm, [&] {
    for (std::size_t k = 0; k + 1 < all.row.size(); ++k) {
      const auto begin = all.row[k], count = all.row[k + 1] - begin;
      const auto x = std::span(all.x).subspan(begin, count);
      const std::vector<int> part = parts.at(x, std::vector<int>(count, cloud.tag[all.point[k]]));
      for (int p = 0; p < parts.count(); ++p) {
        if (!std::ranges::count(part, p)) continue;
        auto& [places, from] = split[p];
        for (std::int64_t n = 0; n < count; ++n)
          if (part[n] == p) places.x.push_back(x[n]), places.weight.push_back(all.weight[begin + n]);
        places.point.push_back(all.point[k]);
        places.row.push_back(static_cast<std::int64_t>(places.x.size()));
        from.push_back(k);
      }
    }
  });
  return split;
}

/// The solution and the body at places in one part, and at these a step to either side along every axis, as if the part
/// went on there.
class Stencil {
 public:
  Stencil(const MaterialField& body, Function T, int part, const Cloud& cloud, const Vec3& step, PlacesInPart in_part)
      : T_(std::move(T)), dimension_(cloud.dimension), step_(step), in_part_(std::move(in_part)) {
    if (const Anisotropy* anisotropy = body.anisotropy(part)) anisotropy_ = *anisotropy;
    const CellSamples& places = in_part_.places;
    std::vector<int> tag;
    for (std::size_t k = 0; k + 1 < places.row.size(); ++k)
      tag.insert(tag.end(), places.row[k + 1] - places.row[k], cloud.tag[places.point[k]]);
    const std::vector<int> parts(tag.size(), part);
    shifted_.push_back(places.x);
    for (int axis = 0; axis < dimension_; ++axis)
      for (const int side : {1, -1}) {
        shifted_.push_back(places.x);
        for (Vec3& x : shifted_.back()) x[axis] += side * step[axis];
      }
    for (const std::vector<Vec3>& x : shifted_) bodies_.emplace_back(body, x, tag, parts);
  }

  const CellSamples& places() const { return in_part_.places; }
  /// Of the row k, the one of the whole quadrature.
  std::size_t from(std::size_t k) const { return in_part_.from[k]; }
  std::size_t size() const { return places().x.size(); }

  /// div (k R grad T), W/m^3, by differences of differences; of axisymmetric bodies with that of e_r.
  std::vector<double> divergence(double t, bool is_axisymmetric) const {
    std::vector<double> out(size(), 0);
    for (int axis = 0; axis < dimension_; ++axis)
      for (const int side : {1, -1}) {
        const std::vector<double> q = flux(axis, t, 1 + 2 * axis + (side < 0));
        for (std::size_t n = 0; n < size(); ++n) out[n] -= side * q[n] / (2 * step_[axis]);
      }
    if (is_axisymmetric) {
      const std::vector<double> q = flux(0, t);
      for (std::size_t n = 0; n < size(); ++n) out[n] -= q[n] / places().x[n].x;
    }
    return out;
  }
  /// -k R grad T along an axis, W/m^2, at the places after a shift.
  std::vector<double> flux(int axis, double t, int shift = 0) const {
    std::vector<Vec3> slope(size());
    for (int b = 0; b < dimension_; ++b) {
      if (b != axis && !anisotropy_) continue;
      std::vector<Vec3> up = shifted_[shift], down = up;
      for (std::size_t n = 0; n < size(); ++n) up[n][b] += step_[b], down[n][b] -= step_[b];
      const std::vector<double> above = at(t, up), below = at(t, down);
      for (std::size_t n = 0; n < size(); ++n) slope[n][b] = (above[n] - below[n]) / (2 * step_[b]);
    }
    std::vector<double> q(size());
    conductivity(shift, t, q);
    for (std::size_t n = 0; n < size(); ++n) {
      if (anisotropy_) slope[n] = anisotropy_->at(shifted_[shift][n]) * slope[n];
      q[n] *= -slope[n][axis];
    }
    return q;
  }
  /// rho c dT/dt, W/m^3.
  std::vector<double> heating(double t, double dt) const {
    const std::vector<Vec3>& x = places().x;
    const std::vector<double> now = at(t, x), after = at(t + dt, x), before = at(t - dt, x);
    std::vector<double> rho_c(size());
    bodies_[0].enthalpy(now, {}, rho_c);
    for (std::size_t n = 0; n < size(); ++n) rho_c[n] *= (after[n] - before[n]) / (2 * dt);
    return rho_c;
  }

 private:
  std::vector<double> at(double t, std::span<const Vec3> x) const {
    std::vector<double> out(x.size());
    T_.evaluate({.x = x, .t = t}, out);
    return out;
  }
  void conductivity(int shift, double t, std::span<double> k) const {
    bodies_[shift].conductivity(t, at(t, shifted_[shift]), k, {});
  }

  Function T_;
  int dimension_;
  Vec3 step_;
  PlacesInPart in_part_;
  std::optional<Anisotropy> anisotropy_;    ///< of the part, if it conducts differently by direction
  std::vector<std::vector<Vec3>> shifted_;  ///< the places, then a step up and down every axis
  std::vector<MaterialField> bodies_;       ///< at these
};

class TwinSource final : public Source {
 public:
  TwinSource(const Case& c, const Twin& twin, const Cloud& cloud, const Conditions& conditions,
             const MaterialField& body)
      : Source("twin"),
        T_(twin.T),
        of_part_(twin.of_part.empty() ? std::vector{twin.T} : twin.of_part),
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
    const Integrand part{.f =
                             [&](std::span<const Vec3> x, std::span<double> out) {
                               const std::vector<int> part = body.parts().at(x, std::vector<int>(x.size()));
                               std::ranges::copy(part, out.begin());
                             },
                         .may_jump = body.parts().count() > 1};
    collective_try(cloud.comm, [&] { cells_ = integrals.cells(part), of_facets_ = integrals.facets(facets, part); });
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
  Changes changes() const override { return T_.changes(); }

 private:
  /// Collective.
  void bind() {
    in_cells_.clear(), on_facets_.clear();
    std::vector<PlacesInPart> cells = split(cells_, cloud_, body_.parts()),
                              facets = split(of_facets_, cloud_, body_.parts());
    for (int part = 0; part < body_.parts().count(); ++part) {
      in_cells_.emplace_back(body_, of_part_[part], part, cloud_, step_, std::move(cells[part]));
      on_facets_.emplace_back(body_, of_part_[part], part, cloud_, step_, std::move(facets[part]));
    }
  }

  void add_up(double t) {
    std::ranges::fill(power_, 0.0);
    for (const Stencil& part : in_cells_) {
      std::vector<double> lacks = part.divergence(t, cloud_.axisymmetric);
      for (double& value : lacks) value = -value;
      if (end_ > 0) {
        const std::vector<double> heating = part.heating(t, step_part * end_);
        for (std::size_t n = 0; n < lacks.size(); ++n) lacks[n] += heating[n];
      }
      add(part.places(), [&](std::size_t, std::int64_t n) { return lacks[n]; });
    }
    for (const Stencil& part : on_facets_) {
      for (int axis = 0; axis < cloud_.dimension; ++axis) {
        const std::vector<double> q = part.flux(axis, t);
        add(part.places(),
            [&](std::size_t k, std::int64_t n) { return -q[n] * cloud_.facets[part.from(k)].normal[axis]; });
      }
    }
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
  std::vector<Function> of_part_;
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
  std::vector<Stencil> in_cells_, on_facets_;  // of every part
  double t_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> power_;  // of the owned points, at t_
};

/// Places on a piece of a crack, all over it.
std::vector<Vec3> places_on(const CrackPiece& piece) {
  constexpr int along = 8;
  Vec3 middle;
  for (const Vec3& corner : piece.corners) middle = middle + (1.0 / static_cast<double>(piece.corners.size())) * corner;
  std::vector<Vec3> places{middle};
  for (std::size_t n = 0; n < piece.corners.size(); ++n) {
    const Vec3 &a = piece.corners[n], &b = piece.corners[(n + 1) % piece.corners.size()];
    for (int k = 0; k < along; ++k) {
      const Vec3 on_edge = a + ((k + 0.5) / along) * (b - a);
      places.push_back(on_edge), places.push_back(0.5 * (on_edge + middle));
    }
  }
  return places;
}

/// Refuses a solution whose heat would cross a crack. Collective.
void require_no_heat_across_cracks(const Case& c, const Table& table, const Function& T, const Cloud& cloud) {
  constexpr double allowed = 1e-3;  // of the mean slope
  const Bounds bounds = bounds_of_all(cloud);
  const double size = norm(bounds.high - bounds.low), step = step_part * size;
  const Cracks cracks(cloud, read_cracks(c, cloud));
  const double t = c.root().has("time") ? 0.5 * c.section("time").number("end") : 0;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  collective_try(cloud.comm, [&] {
    for (const Vec3& x : cloud.owned_points()) low = std::min(low, T(x, t)), high = std::max(high, T(x, t));
  });
  const double span = max(cloud.comm, high) - min(cloud.comm, low);
  for (int crack = 0; crack < static_cast<int>(cracks.all().size()); ++crack)
    for (const CrackPiece& piece : cracks.segments(crack))
      for (const Vec3& x : places_on(piece))
        if (std::abs(T(x + step * piece.normal, t) - T(x - step * piece.normal, t)) / (2 * step) >
            allowed * span / size)
          table.refuse("temperature",
                       fmt::format("its heat would cross the crack at ({:.6g}, {:.6g}, {:.6g}) m", x.x, x.y, x.z),
                       "take a solution whose slope across the crack is 0 there");
}

}  // namespace

std::optional<Twin> read_twin(const Case& c, const Cloud& cloud) {
  if (!c.root().has("twin")) return std::nullopt;
  const Table table = c.section("twin");
  Twin twin{.T = table.function("temperature"), .of_part = {}};
  const auto require_smooth = [&](const Table& of, const Function& T, bool may_bend) {
    if (T.depends_on_temperature()) of.refuse("temperature", "the solution depends on T", "write it in x, y, z and t");
    if (T.may_jump() && !may_bend)
      of.refuse("temperature", "the solution may jump or bend", "take a smooth one, of sin and cos");
    if (c.root().has("steady") && T.depends_on_time())
      of.refuse("temperature", "the solution of a steady case depends on t", "leave t out");
  };
  for (const Table& part : table.list("part")) {
    twin.of_part.push_back(part.function("temperature"));
    require_smooth(part, twin.of_part.back(), false);
  }
  require_smooth(table, twin.T, !twin.of_part.empty());
  if (has_cracks(c)) require_no_heat_across_cracks(c, table, twin.T, cloud);
  if (!cloud.points_on_walls || !cloud.has_areas)
    table.refuse("", "the points of the cloud lie off its walls", "take a cloud with points on the walls");
  return twin;
}

void prescribe_twin(const Twin& twin, const Cloud& cloud, Conditions& conditions, std::vector<double>& T_start) {
  for (PrescribedTerm& term : conditions.temperatures) term.temperature = twin.T;
  T_start.resize(cloud.owned);
  collective_try(cloud.comm, [&] { twin.T.evaluate({.x = cloud.owned_points()}, T_start); });
}

std::unique_ptr<Source> make_twin_source(const Case& c, const Twin& twin, const Cloud& cloud,
                                         const Conditions& conditions, const MaterialField& body) {
  const Table table = c.section("twin");
  const int parts = body.parts().count(), given = static_cast<int>(twin.of_part.size());
  if (given != parts && (given > 0 || parts > 1))
    table.refuse("",
                 fmt::format("{} solutions for {} parts: the flux of one smooth temperature jumps where they meet",
                             given, parts),
                 "give [[twin.part]] a temperature for every part, in the order of [body], with fluxes that agree "
                 "where they meet");
  if (body.conductivity_is_layered())
    table.refuse("",
                 "the conductivity jumps between layers of one material, and the flux of a smooth temperature with it",
                 "make it smooth, or take a [[body.layer]] for each");
  return std::make_unique<TwinSource>(c, twin, cloud, conditions, body);
}

void declare_twin(Schema& schema) {
  schema.add({.path = "twin",
              .sentence =
                  "Replaces the solution by a formula: start and prescribed temperatures are its own, sources of "
                  "the case are left out, and what the heat equation lacks goes in. So the error of a run is "
                  "known (docs/certify.md).",
              .keys = {{"temperature", Kind::function, "K", required, "The solution, smooth, of place and time."}}});
  schema.add({.path = "twin.part[]",
              .sentence = "The solution in one part of the body, in the order of [body]: smooth, beyond the part too.",
              .keys = {{"temperature", Kind::function, "K", required, "Where parts meet it and its flux agree."}}});
}

}  // namespace calor
