#include "material/material_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "base/parallel.hpp"
#include "base/reduce.hpp"
#include "material/invert.hpp"
#include "material/materials.hpp"

namespace calor {
namespace {

constexpr std::size_t block = 1024;  // points at a time: scratch stays in the cache
using Scratch = std::array<double, block>;

/// One material and the places where it is.
struct Region {
  std::shared_ptr<const Material> material;
  std::vector<int> point;                 // ascending; the only part of a body has all and lists none
  std::vector<double> at_point, in_cell;  // its shares
  std::vector<Vec3> x;                    // of the points listed
  std::unique_ptr<PointProperties> at;
  SourceLocation conductivity_location, capacity_location;  // where the case writes them
};
using Shares = std::vector<double> Region::*;

/// Where the case writes a property of a material; where it names the material if that comes from the library.
SourceLocation place_of(const Case& c, const Part& part, const std::string& property) {
  for (const auto& [name, table] : c.section("material").children())
    if (name == part.material) return table.location(property);
  return part.location;
}

/// Lists the places that a part has a share in.
void list_places(const PlacesOfPart& at_point, const PlacesOfPart& in_cell, Region& region) {
  std::ranges::set_union(at_point.place, in_cell.place, std::back_inserter(region.point));
  const auto fill = [&](const PlacesOfPart& from, std::vector<double>& shares) {
    shares.assign(region.point.size(), 0);
    auto at = region.point.begin();
    for (std::size_t n = 0; n < from.place.size(); ++n) {
      at = std::lower_bound(at, region.point.end(), from.place[n]);
      shares[at - region.point.begin()] = from.share[n];
    }
  };
  fill(at_point, region.at_point);
  fill(in_cell, region.in_cell);
}

std::span<double> part(std::span<double> s, std::size_t first, std::size_t n) {
  return s.empty() ? s : s.subspan(first, n);
}

constexpr double positive = std::numeric_limits<double>::denorm_min();

bool all_from(double least, std::span<const double> values) {
  bool good = true;  // no early exit: this vectorises
  for (const double v : values) good &= v >= least && v <= std::numeric_limits<double>::max();
  return good;
}

}  // namespace

struct MaterialField::Impl {
  MPI_Comm comm;
  std::shared_ptr<const Parts> parts;
  std::vector<PlacesOfPart> cell_shares;
  TemperatureRange range;
  std::span<const Vec3> x;
  std::vector<Region> regions;  // one a part; those without places here have none in their lists
  double reference;
  Mean mean = Mean::arithmetic;
  bool k_depends_on_T = false, k_depends_on_time = false, k_is_layered = false, capacity_depends_on_T = false,
       has_capacity = true;
  mutable double safe_low = 0, safe_high = 0;  // k(T) was looked at between these
  mutable std::vector<double> per_rho_c;       // 1 / (rho c) of the first points, where it does not depend on T

  void bind(std::span<const PlacesOfPart> at_point, std::span<const PlacesOfPart> in_cell);

  /// Calls f(region, first point of the region, T, a, b) for the points first ... and adds up the results in a and b by
  /// the regions' shares; either may be empty.
  template <class F>
  void sweep(Shares shares, std::size_t first, std::span<const double> T, std::span<double> a, std::span<double> b,
             F&& f) const {
    if (regions.size() == 1) {
      for (std::size_t n = 0; n < T.size(); n += block) {
        const std::size_t size = std::min(block, T.size() - n);
        f(regions[0], first + n, T.subspan(n, size), part(a, n, size), part(b, n, size));
      }
      return;
    }
    std::ranges::fill(a, 0.0);
    std::ranges::fill(b, 0.0);
    Scratch T_here, a_here, b_here;
    for (const Region& r : regions) {
      const std::vector<double>& share = r.*shares;
      const auto begin = std::ranges::lower_bound(r.point, static_cast<int>(first)) - r.point.begin();
      const auto end = std::ranges::lower_bound(r.point, static_cast<int>(first + T.size())) - r.point.begin();
      for (std::size_t n = begin; n < static_cast<std::size_t>(end); n += block) {
        const std::size_t size = std::min(block, end - n);
        for (std::size_t i = 0; i < size; ++i) T_here[i] = T[r.point[n + i] - first];
        f(r, n, std::span<const double>(T_here.data(), size), part(a_here, 0, a.empty() ? 0 : size),
          part(b_here, 0, b.empty() ? 0 : size));
        for (std::size_t i = 0; i < size && !a.empty(); ++i) a[r.point[n + i] - first] += share[n + i] * a_here[i];
        for (std::size_t i = 0; i < size && !b.empty(); ++i) b[r.point[n + i] - first] += share[n + i] * b_here[i];
      }
    }
  }

  /// Values below `least` or not finite are refused.
  void check(const Region& r, std::size_t first, double t, std::span<const double> T, std::span<const double> value,
             double least, const SourceLocation& location, const char* what, const char* unit) const {
    if (all_from(least, value)) return;
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (all_from(least, value.subspan(i, 1))) continue;
      const Vec3& p = x[r.point.empty() ? first + i : r.point[first + i]];
      throw Error(Fault::numbers, location,
                  fmt::format("the {} of '{}' is {:.6g} {} at ({:.6g}, {:.6g}, {:.6g}) m, T = {:.6g} K, t = {:.6g} s",
                              what, r.material->name, value[i], unit, p.x, p.y, p.z, T[i], t),
                  std::isfinite(T[i]) ? "give a law that is positive at every temperature the run may see"
                                      : "the run has gone wrong before: try a smaller step");
    }
  }

  /// Refuses a body that conducts nowhere; insulators are parts of others.
  void refuse_without_conduction(MPI_Comm comm) const {
    if (k_depends_on_T || k_depends_on_time) return;
    const std::vector<double> T(x.size());
    std::vector<double> k(x.size());
    sweep(&Region::at_point, 0, T, k, {},
          [](const Region& r, std::size_t at, auto T, auto k, auto) { r.at->conductivity(at, 0, T, k, {}); });
    if (any(comm, std::ranges::any_of(k, [](double value) { return value > 0; }))) return;
    const Region& r = regions.front();
    throw Error(Fault::bad_case, r.conductivity_location,
                fmt::format("the conductivity of '{}' is 0 W/(m K)", r.material->name),
                "it must be positive everywhere");
  }

  void enthalpy(std::size_t first, std::span<const double> T, std::span<double> H, std::span<double> rho_c) const {
    if (!has_capacity) {
      for (std::size_t i = 0; i < H.size(); ++i) H[i] = T[i] - reference;
      std::ranges::fill(rho_c, 1.0);
      return;
    }
    sweep(&Region::in_cell, first, T, H, rho_c,
          [](const Region& r, std::size_t at, auto T, auto H, auto c) { r.at->enthalpy(at, T, H, c); });
  }
};

MaterialField::MaterialField(MaterialField&&) noexcept = default;
MaterialField::~MaterialField() = default;

void MaterialField::Impl::bind(std::span<const PlacesOfPart> at_point, std::span<const PlacesOfPart> in_cell) {
  reference = range.reference;
  safe_low = std::numeric_limits<double>::max(), safe_high = -safe_low;
  for (std::size_t p = 0; p < regions.size(); ++p) {
    Region& region = regions[p];
    if (regions.size() > 1) {
      list_places(at_point[p], in_cell[p], region);
      for (const int i : region.point) region.x.push_back(x[i]);
    }
    const bool whole = regions.size() == 1;
    collective_try(comm, [&] { region.at = region.material->at(whole ? x : std::span<const Vec3>(region.x), range); });
  }
}

MaterialField::MaterialField(const Case& c, const Cloud& cloud, const TemperatureRange& range)
    : impl_(std::make_unique<Impl>()) {
  Impl& p = *impl_;
  p.comm = cloud.comm, p.range = range, p.x = cloud.x;
  Materials materials(c);
  const Table body = c.section("body");
  const bool unnamed = !body.has("material") && body.list("layer").empty() && body.list("region").empty();
  p.parts = std::make_shared<const Parts>(c, cloud, unnamed ? materials.only_one() : "");
  bool of_T_alone = true;
  for (int n = 0; n < p.parts->count(); ++n) {
    const Part& part = (*p.parts)[n];
    Region& region = p.regions.emplace_back();
    region.material = materials.get(part.material, part.location);
    region.conductivity_location = place_of(c, part, "conductivity");
    region.capacity_location = place_of(c, part, "specific_heat");
    const Material& m = *region.material;
    if (m.anisotropy()) require_axes_in_body(*m.anisotropy(), cloud.dimension, place_of(c, part, "anisotropy"));
    p.k_depends_on_T |= m.conductivity_depends_on_T();
    p.k_depends_on_time |= m.conductivity_depends_on_time();
    p.capacity_depends_on_T |= m.capacity_depends_on_T();
    p.has_capacity &= m.has_capacity();
    p.k_is_layered |= m.conductivity_is_layered();
    of_T_alone &= m.conductivity_of_T_alone();
  }
  std::vector<PlacesOfPart> at_point;
  collective_try(cloud.comm, [&] {
    at_point = p.parts->shares(cloud.x, cloud.tag, cloud.spacing);
    p.cell_shares = p.parts->cell_shares();
  });
  p.bind(at_point, p.cell_shares);
  p.refuse_without_conduction(cloud.comm);
  const std::string mean = body.text("conductivity_mean");
  const bool one_of_T = p.regions.size() == 1 && of_T_alone;
  if (mean == "integral" && !one_of_T)
    body.refuse("conductivity_mean",
                p.regions.size() > 1 ? "the integral mean takes one material, this body has several"
                                     : "the integral mean takes a conductivity that depends on temperature alone",
                "write \"arithmetic\", \"harmonic\" or \"automatic\"");
  p.mean = mean == "integral"                     ? Mean::integral
           : mean == "arithmetic"                 ? Mean::arithmetic
           : mean == "harmonic" || p.k_is_layered ? Mean::harmonic
           : one_of_T                             ? Mean::integral
                                                  : Mean::arithmetic;
}

MaterialField::MaterialField(const MaterialField& body, std::span<const Vec3> x, std::span<const int> tag,
                             std::span<const int> part)
    : impl_(std::make_unique<Impl>()) {
  const Impl& from = *body.impl_;
  Impl& p = *impl_;
  p.comm = from.comm, p.parts = from.parts, p.range = from.range, p.x = x, p.mean = from.mean;
  p.k_depends_on_T = from.k_depends_on_T, p.k_depends_on_time = from.k_depends_on_time,
  p.k_is_layered = from.k_is_layered;
  p.capacity_depends_on_T = from.capacity_depends_on_T, p.has_capacity = from.has_capacity;
  for (const Region& r : from.regions) {
    Region& region = p.regions.emplace_back();
    region.material = r.material;
    region.conductivity_location = r.conductivity_location, region.capacity_location = r.capacity_location;
  }
  std::vector<PlacesOfPart> shares(p.regions.size());
  collective_try(p.comm, [&] {
    const std::vector<int> own = part.empty() ? p.parts->at(x, tag) : std::vector<int>(part.begin(), part.end());
    for (std::size_t q = 0; q < own.size(); ++q) {
      shares[own[q]].place.push_back(static_cast<int>(q));
      shares[own[q]].share.push_back(1);
    }
  });
  p.bind(shares, shares);
}

const Parts& MaterialField::parts() const { return *impl_->parts; }
const std::vector<PlacesOfPart>& MaterialField::cell_shares() const { return impl_->cell_shares; }
std::vector<char> MaterialField::lie_in(int part) const {
  const Region& region = impl_->regions[part];
  std::vector<char> lie(impl_->x.size(), impl_->regions.size() == 1);
  for (std::size_t n = 0; n < region.point.size(); ++n) lie[region.point[n]] = region.at_point[n] > 0;
  return lie;
}
Mean MaterialField::mean() const { return impl_->mean; }
const Anisotropy* MaterialField::anisotropy(int part) const { return impl_->regions[part].material->anisotropy(); }
bool MaterialField::is_isotropic() const {
  return std::ranges::none_of(impl_->regions, [](const Region& r) { return r.material->anisotropy(); });
}
bool MaterialField::conductivity_is_layered() const { return impl_->k_is_layered; }
bool MaterialField::conductivity_depends_on_T() const { return impl_->k_depends_on_T; }
bool MaterialField::conductivity_depends_on_time() const { return impl_->k_depends_on_time; }
bool MaterialField::capacity_depends_on_T() const { return impl_->has_capacity && impl_->capacity_depends_on_T; }
bool MaterialField::has_capacity() const { return impl_->has_capacity; }

std::vector<std::string> MaterialField::ingredients() const {
  std::vector<std::string> names;
  for (const Region& r : impl_->regions)
    for (const std::string& name : r.material->ingredients())
      if (!std::ranges::count(names, name)) names.push_back(name);
  return names;
}

void MaterialField::volume_fraction(const std::string& ingredient, std::span<double> v) const {
  // Only its size counts: fractions do not depend on temperature.
  const std::vector<double> T(v.size());
  Scratch part;
  impl_->sweep(&Region::in_cell, 0, T, v, {}, [&](const Region& r, std::size_t at, auto T, auto v, auto) {
    std::ranges::fill(v, 0.0);
    const std::vector<std::string> names = r.material->ingredients();
    for (std::size_t n = 0; n < names.size(); ++n) {
      if (names[n] != ingredient) continue;
      r.at->volume_fraction(n, at, {part.data(), T.size()});
      for (std::size_t i = 0; i < v.size(); ++i) v[i] += part[i];
    }
  });
}

const TemperatureRange& MaterialField::expected_range() const { return impl_->range; }

void MaterialField::conductivity(double t, std::span<const double> T, std::span<double> k,
                                 std::span<double> dk_dT) const {
  const Impl& p = *impl_;
  p.sweep(&Region::at_point, 0, T, k, dk_dT, [&](const Region& r, std::size_t at, auto T, auto k, auto dk_dT) {
    r.at->conductivity(at, t, T, k, dk_dT);
    if (r.material->conductivity_depends_on_T() || r.material->conductivity_depends_on_time())
      p.check(r, at, t, T, k, 0, r.conductivity_location, "conductivity", "W/(m K)");
  });
}

void MaterialField::theta(std::span<const double> T, std::span<double> theta) const {
  const Impl& p = *impl_;
  const Region& r = p.regions[0];
  // theta alone would not show a k that is not positive. k is looked at only when temperatures leave what was seen.
  auto [low, high] = p.k_depends_on_T ? range_of(T) : ValueRange{};
  if (!T.empty() && p.k_depends_on_T && (low < p.safe_low || high > p.safe_high || !all_finite(T))) {
    Scratch k, samples;
    const auto look = [&](std::span<const double> T, std::size_t first) {
      for (std::size_t n = 0; n < T.size(); n += block) {
        const std::size_t size = std::min(block, T.size() - n);
        r.at->conductivity(first + n, 0, T.subspan(n, size), {k.data(), size}, {});
        p.check(r, first + n, 0, T.subspan(n, size), {k.data(), size}, 0, r.conductivity_location, "conductivity",
                "W/(m K)");
      }
    };
    look(T, 0);
    // All points share k(T), so any of them can stand for the samples in between. Where the law ends within the margin
    // nothing is remembered, and k is looked at every time.
    const double margin = 0.1 * (high - low);
    low = std::min(low - margin, p.safe_low), high = std::max(high + margin, p.safe_high);
    for (std::size_t i = 0; i < block; ++i) samples[i] = low + (high - low) * static_cast<double>(i) / (block - 1);
    try {
      r.at->conductivity(0, 0, samples, k, {});
      if (all_from(0, k)) p.safe_low = low, p.safe_high = high;
    } catch (const Error&) {
    }
  }
  r.at->theta(T, theta);
}

void MaterialField::enthalpy(std::span<const double> T, std::span<double> H, std::span<double> rho_c) const {
  const Impl& p = *impl_;
  if (!capacity_depends_on_T() || rho_c.empty()) {
    p.enthalpy(0, T, H, rho_c);
    return;
  }
  p.sweep(&Region::in_cell, 0, T, H, rho_c, [&](const Region& r, std::size_t at, auto T, auto H, auto rho_c) {
    r.at->enthalpy(at, T, H, rho_c);
    p.check(r, at, 0, T, rho_c, positive, r.capacity_location, "volumetric heat capacity", "J/(m^3 K)");
  });
}

void MaterialField::temperature(std::span<const double> H, std::span<double> T) const {
  const Impl& p = *impl_;
  const std::span<double> all = T.first(H.size());
  if (!capacity_depends_on_T()) {
    if (p.per_rho_c.size() < H.size()) {
      p.per_rho_c.resize(H.size());
      p.enthalpy(0, all, {}, p.per_rho_c);
      for (double& value : p.per_rho_c) value = 1 / value;
    }
    for (std::size_t i = 0; i < H.size(); ++i) all[i] = p.reference + H[i] * p.per_rho_c[i];
    return;
  }
  for (std::size_t first = 0; first < H.size(); first += block) {
    const std::size_t n = std::min(block, H.size() - first);
    const auto H_here = H.subspan(first, n);
    const auto T_here = all.subspan(first, n);
    const auto evaluate = [&](std::span<const double> T, std::span<double> H, std::span<double> c) {
      p.enthalpy(first, T, H, c);
    };
    if (const int bad = invert_increasing(evaluate, H_here, T_here); bad >= 0) {
      const Vec3& at = p.x[first + bad];
      throw Error(
          Fault::numbers,
          fmt::format("no temperature holds the enthalpy {:.6g} J/m^3 at ({:.6g}, {:.6g}, {:.6g}) m; the search "
                      "ended at T = {:.6g} K",
                      H_here[bad], at.x, at.y, at.z, T_here[bad]),
          "give density and specific heat that are positive at every temperature, or try a smaller step");
    }
  }
}

}  // namespace calor
