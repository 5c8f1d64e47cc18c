#include "cloud/cell_integrals.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "cloud/box_rule.hpp"
#include "cloud/lattice.hpp"
#include "cloud/ring_lattice.hpp"

namespace calor {
namespace {

/// Samples are this many times finer along every axis where a function jumps.
constexpr int finer = 4;
/// A function that changes by more than this part of its size among the samples of a cell is taken to jump there.
constexpr double jump = 0.2;
/// The same in a millionth of the way from a point to the middle of its cell.
constexpr double jump_at_edge = 1e-4;

/// Few places with the same mean, first and second moments as many, with weights that add up to 1.
void add_reduced(std::span<const Vec3> samples, std::span<const double> weight, int dimension, Places& out) {
  Vec3 mean;
  for (std::size_t n = 0; n < samples.size(); ++n) mean += weight[n] * samples[n];
  std::array<Vec3, 3> C;  // columns of the covariance
  for (std::size_t n = 0; n < samples.size(); ++n)
    for (int a = 0; a < dimension; ++a) C[a] += (samples[n] - mean)[a] * weight[n] * (samples[n] - mean);
  // Its Cholesky factors are the ways from the mean.
  std::vector<Vec3> ways;
  const double least = 1e-12 * (C[0].x + C[1].y + C[2].z);
  for (int a = 0; a < dimension; ++a) {
    const double pivot = C[a][a];
    if (!(pivot > least)) continue;
    const Vec3 way = 1 / std::sqrt(pivot) * C[a];
    for (int b = a; b < dimension; ++b) C[b] += -way[b] * way;
    ways.push_back(way);
  }
  if (ways.empty()) {
    out.x.push_back(mean), out.weight.push_back(1);
    return;
  }
  const auto r = static_cast<double>(ways.size());
  for (const Vec3& way : ways)
    for (const double sign : {-1., 1.})
      out.x.push_back(mean + sign * std::sqrt(r) * way), out.weight.push_back(0.5 / r);
}

/// Does the value at the point differ from those in its cell by more than these among themselves? Chords end the cells
/// along curved contacts, and the points may lie on the other side of a jump.
bool lies_beyond_jump(double value, const Places& places, const Integrand& f) {
  const auto [least, most] = std::ranges::minmax(places.value);
  const double size = std::max({f.scale, std::abs(least), std::abs(most)});
  return std::max(least - value, value - most) > most - least + jump_at_edge * size;
}

/// Values of a function that is integrated again and again at the corners of a lattice's cells, each evaluated once.
class Corners {
 public:
  Corners(const Cloud& cloud, const Integrand& f) : cloud_(cloud), least_(negligible * f.scale) {
    if (cloud.owned == 0) return;
    const Lattice& lattice = *cloud.lattice;
    LatticeIndex high = first_ = lattice.index(cloud.id[0]);
    for (int i = 1; i < cloud.owned; ++i) {
      const LatticeIndex index = lattice.index(cloud.id[i]);
      for (int a = 0; a < 3; ++a) first_[a] = std::min(first_[a], index[a]), high[a] = std::max(high[a], index[a]);
    }
    for (int a = 0; a < cloud.dimension; ++a) count_[a] = high[a] - first_[a] + 2;
    std::vector<Vec3> x(count_[0] * count_[1] * count_[2]);
    for (std::size_t n = 0; n < x.size(); ++n) {
      LatticeIndex k = {};
      k[0] = static_cast<std::int64_t>(n) % count_[0], k[1] = static_cast<std::int64_t>(n) / count_[0] % count_[1];
      k[2] = static_cast<std::int64_t>(n) / (count_[0] * count_[1]);
      for (int a = 0; a < cloud.dimension; ++a)
        x[n][a] = first_[a] + k[a] == 0 ? lattice.cell(a, 0).first : lattice.cell(a, first_[a] + k[a] - 1).second;
    }
    value_.resize(x.size());
    f.f(x, value_);
    at_points_.resize(cloud.owned);
    f.f(cloud.owned_points(), at_points_);
  }

  /// Is the function nothing beside its scale at the point and at all corners of its cell?
  bool have_nothing(int i) const {
    if (std::abs(at_points_[i]) > least_) return false;
    const LatticeIndex index = cloud_.lattice->index(cloud_.id[i]);
    for (int corner = 0; corner < 1 << cloud_.dimension; ++corner) {
      std::int64_t n = 0;
      for (int a = cloud_.dimension - 1; a >= 0; --a) n = n * count_[a] + index[a] - first_[a] + (corner >> a & 1);
      if (std::abs(value_[n]) > least_) return false;
    }
    return true;
  }

 private:
  const Cloud& cloud_;
  double least_;
  LatticeIndex first_ = {}, count_ = {1, 1, 1};
  std::vector<double> value_, at_points_;
};

}  // namespace

class CellIntegrals::Impl {
 public:
  explicit Impl(const Cloud& cloud) : cloud(cloud), axes_(cloud.dimension) {
    if (!cloud.lattice && !cloud.rings) sampler_.emplace(cloud);
  }

  /// Does f jump in the cell?
  bool add_cell(int i, const Integrand& f, Places& out) const {
    if (cloud.rings) {
      const auto [low, high] = cloud.rings->cell(cloud.id[i]);
      return add_sector(f, low, high, out);
    }
    if (!cloud.lattice)
      return add_samples(f, cloud.dimension, out, [&](int n, std::vector<Vec3>& x) { sampler_->of(i, n, x); });
    const auto [low, high] = box_of(i);
    return add_box(f, low, high, out);
  }

  void add_facet(int n, const Integrand& f, Places& out) const {
    const Facet& facet = cloud.facets[n];
    if (cloud.lattice) {
      auto [low, high] = box_of(facet.point);
      low[facet.face / 2] = high[facet.face / 2] = cloud.walls[facet.face];
      add_box(f, low, high, out);
    } else if (cloud.rings) {
      add_facet_of_rings(facet, f, out);
    } else if (cloud.dimension == 3) {
      add_samples(f, 3, out, [&](int finer, std::vector<Vec3>& x) { sampler_->of_facet(n, finer, x); });
    } else if (cloud.dimension == 2) {
      const auto ends = sampler_->ends_of_facet(n);
      std::array<double, 2> measure;
      for (const int k : {0, 1})
        measure[k] = norm(ends[k + 1] - ends[k]) * (cloud.axisymmetric ? 0.5 * (ends[k] + ends[k + 1]).x : 1);
      const double whole = measure[0] + measure[1];
      for (const int k : {0, 1})
        if (measure[k] > 0) add_line(f, ends[k], ends[k + 1], measure[k] / whole, out);
    } else {
      BoxRule(f).add(cloud.x[facet.point], cloud.x[facet.point], out);
    }
  }

  bool holds_on_curved(int n, const Integrand& indicator) const {
    if (!sampler_) return false;
    const Facet& facet = cloud.facets[n];
    const Vec3& centre = cloud.x[facet.point];
    std::vector<Vec3> x;
    sampler_->beside_facet(n, x);
    const bool is_plane = std::ranges::all_of(x, [&](const Vec3& other) {
      return std::abs(dot(other - centre, facet.normal)) <= 1e-6 * norm(other - centre);
    });
    if (is_plane) return false;
    x.push_back(centre);
    std::vector<double> value(x.size());
    indicator.f(x, value);
    return std::ranges::all_of(value, [](double v) { return v != 0; });
  }

  const Cloud& cloud;

 private:
  std::pair<Vec3, Vec3> box_of(int i) const {
    const LatticeIndex index = cloud.lattice->index(cloud.id[i]);
    Vec3 low, high;
    for (int a = 0; a < axes_; ++a) std::tie(low[a], high[a]) = cloud.lattice->cell(a, index[a]);
    return {low, high};
  }

  /// A box in other coordinates: `to_place` maps them, `density` is the measure of their volume, to any factor, and
  /// changes linearly at most. Does f jump?
  template <class ToPlace, class Density>
  bool add_mapped(const Integrand& f, const Vec3& low, const Vec3& high, double weight, Places& out,
                  const ToPlace& to_place, const Density& density) const {
    std::vector<Vec3> x;
    Integrand mapped{.f = {}, .may_jump = f.may_jump, .quick = f.quick, .scale = f.scale};
    if (f.f)
      mapped.f = [&](std::span<const Vec3> s, std::span<double> values) {
        x.clear();
        for (const Vec3& place : s) x.push_back(to_place(place));
        f.f(x, values);
      };
    Places places;
    const bool jumps = BoxRule(mapped).add(low, high, places);
    double whole = 0;
    for (std::size_t n = 0; n < places.x.size(); ++n) whole += places.weight[n] * density(places.x[n]);
    for (std::size_t n = 0; n < places.x.size(); ++n) {
      out.x.push_back(to_place(places.x[n]));
      out.weight.push_back(weight * places.weight[n] * density(places.x[n]) / whole);
      if (f.f) out.value.push_back(places.value[n]);
    }
    return jumps;
  }

  /// Of a lattice. The thickness of an axisymmetric body is that of the place.
  bool add_box(const Integrand& f, const Vec3& low, const Vec3& high, Places& out) const {
    if (!cloud.axisymmetric) return BoxRule(f).add(low, high, out);
    return add_mapped(
        f, low, high, 1, out, [](const Vec3& s) { return s; }, [](const Vec3& s) { return s.x; });
  }

  void add_line(const Integrand& f, const Vec3& from, const Vec3& to, double weight, Places& out) const {
    add_mapped(
        f, {0, 0, 0}, {1, 0, 0}, weight, out, [&](const Vec3& s) { return from + s.x * (to - from); },
        [&](const Vec3& s) { return cloud.axisymmetric ? (from + s.x * (to - from)).x : 1.; });
  }

  /// Between two corners in r, theta and z.
  bool add_sector(const Integrand& f, const Vec3& low, const Vec3& high, Places& out) const {
    return add_mapped(
        f, low, high, 1, out,
        [](const Vec3& s) {
          return Vec3{s.x * std::cos(s.y), s.x * std::sin(s.y), s.z};
        },
        [](const Vec3& s) { return s.x; });
  }

  void add_facet_of_rings(const Facet& facet, const Integrand& f, Places& out) const {
    auto [low, high] = cloud.rings->cell(cloud.id[facet.point]);
    const std::string& face = cloud.faces[facet.face];
    if (face == "side") low.x = high.x;
    if (face == "bottom") high.z = low.z;
    if (face == "top") low.z = high.z;
    if (face == "cut1" || face == "cut2") {
      // Along the radii: straight lines, of the centre two where the two cuts of a half meet.
      const bool is_centre = low.x == 0, is_half = is_centre && high.y > 3;
      const Vec3 inner{low.x, 0, low.z}, outer{high.x, 0, high.z};
      const auto cut = [&](double angle, double weight) {
        add_mapped(
            f, inner, outer, weight, out,
            [&](const Vec3& s) {
              return Vec3{s.x * std::cos(angle), s.x * std::sin(angle), s.z};
            },
            [](const Vec3&) { return 1.; });
      };
      const double own = face == "cut2" || (!is_centre && low.y > 0) ? high.y : 0;
      cut(own, is_half ? 0.5 : 1);
      if (is_half) cut(high.y, 0.5);
      return;
    }
    add_sector(f, low, high, out);
  }

  /// Does f jump among the samples?
  template <class Sample>
  bool add_samples(const Integrand& f, int dimension, Places& out, const Sample& sample) const {
    std::vector<Vec3> x;
    sample(1, x);
    std::vector<double> value(x.size());
    if (f.f) f.f(x, value);
    const auto [least, most] = std::ranges::minmax(value);
    if (least == most) {
      add_reduced(x, weights_of(cloud, x), dimension, out);
      if (f.f) out.value.resize(out.x.size(), least);
      return false;
    }
    const bool jumps = f.may_jump && most - least > jump * std::max({f.scale, std::abs(least), std::abs(most)});
    if (jumps) {
      sample(finer, x);
      value.resize(x.size());
      f.f(x, value);
    }
    out.x.insert(out.x.end(), x.begin(), x.end());
    std::ranges::copy(weights_of(cloud, x), std::back_inserter(out.weight));
    out.value.insert(out.value.end(), value.begin(), value.end());
    return jumps;
  }

  int axes_;
  std::optional<CellSampler> sampler_;
};

CellIntegrals::CellIntegrals(const Cloud& cloud) : impl_(std::make_unique<Impl>(cloud)) {}
CellIntegrals::~CellIntegrals() = default;

std::vector<double> CellIntegrals::over_cells(const Integrand& f) const {
  const Cloud& cloud = impl_->cloud;
  std::vector<double> integral(cloud.owned);
  std::optional<Corners> corners;
  if (f.quick && cloud.lattice) corners.emplace(cloud, f);
  Places places;
  for (int i = 0; i < cloud.owned; ++i) {
    if (corners && corners->have_nothing(i)) continue;
    places.clear();
    impl_->add_cell(i, f, places);
    integral[i] = cloud.volume[i] * places.mean();
  }
  return integral;
}

std::vector<double> CellIntegrals::values(const Integrand& f) const {
  const Cloud& cloud = impl_->cloud;
  std::vector<double> value(cloud.owned);
  f.f(cloud.owned_points(), value);
  if (!f.may_jump) return value;
  Places places;
  std::vector<int> whole;  // points in whose cells f does not jump
  std::vector<Vec3> inside;
  for (int i = 0; i < cloud.owned; ++i) {
    places.clear();
    if (impl_->add_cell(i, f, places) || lies_beyond_jump(value[i], places, f)) {
      value[i] = places.mean();
      continue;
    }
    Vec3 centre;
    for (std::size_t n = 0; n < places.x.size(); ++n) centre += places.weight[n] * places.x[n];
    constexpr double little = 1e-6;
    whole.push_back(i), inside.push_back(cloud.x[i] + little * (centre - cloud.x[i]));
  }
  // Points on the edges of their cells, as on walls and contacts, may lie on a jump.
  std::vector<double> seen(whole.size());
  f.f(inside, seen);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    double& own = value[whole[n]];
    if (std::abs(seen[n] - own) > jump_at_edge * std::max({f.scale, std::abs(seen[n]), std::abs(own)})) own = seen[n];
  }
  return value;
}

namespace {

void append(const Places& places, int point, double measure, CellSamples& out) {
  out.point.push_back(point);
  out.x.insert(out.x.end(), places.x.begin(), places.x.end());
  for (const double w : places.weight) out.weight.push_back(measure * w);
  out.row.push_back(static_cast<std::int64_t>(out.x.size()));
}

}  // namespace

CellSamples CellIntegrals::cells(const Integrand& f) const {
  CellSamples out;
  for (int i = 0; i < impl_->cloud.owned; ++i) add_cell(i, f, out);
  return out;
}

void CellIntegrals::add_cell(int i, const Integrand& f, CellSamples& out) const {
  Places places;
  impl_->add_cell(i, f, places);
  append(places, i, impl_->cloud.volume[i], out);
}

CellSamples CellIntegrals::facets(std::span<const int> facets, const Integrand& f) const {
  CellSamples out;
  Places places;
  for (const int n : facets) {
    places.clear();
    impl_->add_facet(n, f, places);
    append(places, impl_->cloud.facets[n].point, impl_->cloud.facets[n].area, out);
  }
  return out;
}

std::vector<char> CellIntegrals::hold_on_curved(std::span<const int> facets, const Integrand& indicator) const {
  std::vector<char> holds;
  for (const int n : facets) holds.push_back(impl_->holds_on_curved(n, indicator));
  return holds;
}

}  // namespace calor
