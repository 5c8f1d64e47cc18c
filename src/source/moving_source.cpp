#include "source/moving_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/cells.hpp"
#include "source/box_body.hpp"
#include "source/curved_face.hpp"
#include "source/path.hpp"
#include "source/posed_profile.hpp"
#include "source/stretches.hpp"

namespace calor {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// A source whose place has left the body still gives all of its heat while this part of it would fall inside.
constexpr double least_part_inside = 1e-3;

class MovingSource final : public Source {
 public:
  MovingSource(const std::string& name, const Table& table, const Cloud& cloud, const SourceProfile& profile, Path path)
      : Source(name),
        cloud_(cloud),
        profile_(profile),
        path_(std::move(path)),
        efficiency_(table.number("efficiency")),
        part_(table.flag("half") ? 0.5 : 1),
        normalise_(table.flag("normalise")),
        box_(box_body(cloud)) {
    if (box_) cells_ = lattice_cells(cloud, *box_);
    if (cells_) find_lines();
    double low = infinity, high = -infinity;
    for (const Vec3& x : cloud.owned_points())
      low = std::min(low, x[profile.axis]), high = std::max(high, x[profile.axis]);
    extent_ = max(cloud.comm, high) - min(cloud.comm, low);
  }

  void integrate_over(const CellSamples& subdomains) override { subdomains_ = &subdomains; }

  void prepare(double t) override {
    if (t == t_) return;
    t_ = t;
    const auto pose = path_.at(t);
    asked_ = pose ? efficiency_ * part_ * pose->power : 0;
    is_on_lattice_ = false;
    point_.clear(), share_.clear();
    if (asked_ == 0) return;
    const PosedProfile placed(profile_, *pose, cloud_.dimension);
    // Mirror images at the plane walls of a box give the walls no heat flux through them; elsewhere what falls beside
    // the body is made up for by a factor. Subdomains that overlap leave out or count twice what the images bring in,
    // too.
    const bool images =
        (normalise_ || subdomains_) && box_ && !profile_.is_curved && box_->holds(placed.location(), placed.varies());
    is_on_lattice_ = cells_ && !subdomains_ && !profile_.is_curved && placed.is_product();
    double inside = 0;  // the part of the heat that falls on the body
    if (is_on_lattice_) {
      inside = fill_factors(placed, images);
    } else {
      if (profile_.is_curved)
        fill_curved_face(placed);
      else
        profile_.face ? fill_facets(placed, images) : fill_samples(placed, images);
      inside = sum(cloud_.comm, share_);
    }
    if (!normalise_)
      power_ = images ? asked_ : asked_ / part_;  // without images, half of a half model's heat falls beside the body
    else
      power_ = asked_ / (images || inside / part_ >= least_part_inside ? inside : 1);
    if (normalise_ && images && !(inside > 0))
      throw Error(Fault::numbers,
                  fmt::format("source '{}' falls between the samples of the cells at t = {:g} s", name, t),
                  "give it a larger radius, or the cloud a smaller spacing");
  }

  double add_power(double, std::span<const double>, std::span<double> P) const override {
    if (asked_ == 0) return 0;
    double added = 0;
    if (is_on_lattice_) {
      const auto& [fx, fy, fz] = factor_;
      for (const Line& line : lines_) {
        const double of_line = power_ * fy[line.y] * fz[line.z];
        if (of_line == 0) continue;
        const std::int32_t from = std::max(line.x, first_), to = std::min(line.x + line.length, end_);
        for (std::int32_t x = from; x < to; ++x) {
          const double heat = of_line * fx[x];
          P[line.point + (x - line.x)] += heat;
          added += heat;
        }
      }
      return added;
    }
    for (std::size_t n = 0; n < point_.size(); ++n) {
      P[point_[n]] += power_ * share_[n];
      added += power_ * share_[n];
    }
    return added;
  }
  void add_derivative(double, std::span<const double>, std::span<double>) const override {}
  bool depends_on_temperature() const override { return false; }
  Changes changes() const override { return path_.changes(); }
  std::optional<double> asked(double t) const override {
    const auto pose = path_.at(t);
    return pose ? efficiency_ * part_ * pose->power : 0;
  }
  std::optional<double> energy_asked(double t) const override {
    const auto energy = path_.energy(t);
    return energy ? std::optional(efficiency_ * part_ * *energy) : std::nullopt;
  }
  double longest_step(double begin, double end) const override {
    const double speed = path_.fastest(begin, end);
    return speed > 0 ? 0.3 * profile_.sigma / speed : infinity;
  }

 private:
  /// Owned points that follow each other along x on a lattice: the first one, its indices, and how many there are.
  struct Line {
    std::int32_t point, x, y, z, length;
  };
  void find_lines() {
    for (std::size_t i = 0; i < cells_->index.size(); ++i) {
      const auto& [x, y, z] = cells_->index[i];
      if (Line* last = lines_.empty() ? nullptr : &lines_.back();
          last && last->y == y && last->z == z && last->x + last->length == x)
        ++last->length;
      else
        lines_.push_back({static_cast<std::int32_t>(i), x, y, z, 1});
    }
  }

  /// Exact integrals over the boxes of a lattice, as factors along its axes, 0 beyond the reach of the source; returns
  /// their sum.
  double fill_factors(const PosedProfile& placed, bool images) {
    double inside = 1;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double>& f = factor_[axis];
      f.assign(1, 1.0);
      if (axis >= cloud_.dimension) continue;
      const std::vector<double>& planes = cells_->planes[axis];
      const double low = planes.front(), length = planes.back() - low;
      f.assign(planes.size() - 1, 0.0);
      if (placed.varies(axis)) {
        const double x0 = placed.location()[axis], reach = placed.reach(axis);
        for_each_image(placed, axis, images, [&](double sign, double shift) {
          for (std::size_t i = 0; i < f.size(); ++i) {
            const auto [a, b] = std::minmax({sign * planes[i] + shift, sign * planes[i + 1] + shift});
            if (b > x0 - reach && a < x0 + reach) f[i] += placed.between(axis, a, b);
          }
        });
      } else if (profile_.face) {
        (*profile_.face % 2 ? f.back() : f.front()) = 1;
      } else {
        for (std::size_t i = 0; i < f.size(); ++i) f[i] = (planes[i + 1] - planes[i]) / length;
      }
      inside *= std::accumulate(f.begin(), f.end(), 0.0);
    }
    const auto is_heated = [](double f) { return f != 0; };
    const std::vector<double>& f = factor_[0];
    first_ = static_cast<std::int32_t>(std::ranges::find_if(f, is_heated) - f.begin());
    end_ = static_cast<std::int32_t>(f.rend() - std::find_if(f.rbegin(), f.rend(), is_heated));
    return inside;
  }

  /// The mirror images sign x + shift of a coordinate x of the body in both walls, repeated as far as the source
  /// reaches; without `images` only x itself.
  template <class Use>
  void for_each_image(const PosedProfile& placed, int axis, bool images, const Use& use) const {
    use(1, 0);
    if (!images || !placed.varies(axis)) return;
    const double low = box_->low[axis], high = box_->high[axis], period = 2 * (high - low);
    const double from = placed.location()[axis] - placed.reach(axis), to = placed.location()[axis] + placed.reach(axis);
    const int most = 1 + static_cast<int>(placed.reach(axis) / period);
    for (int n = -most; n <= most; ++n) {
      const double shift = n * period;
      if (n != 0 && low + shift < to && high + shift > from) use(1, shift);
      if (2 * low - high + shift < to && low + shift > from) use(-1, 2 * low + shift);
    }
  }

  /// Of places: each coordinate turned by its sign, then shifted.
  struct Image {
    Vec3 sign, shift;
    Vec3 of(const Vec3& x) const { return product(sign, x) + shift; }
  };
  std::vector<Image> all_images(const PosedProfile& placed, bool images) const {
    std::vector<Image> all;
    Image image;
    const auto add_along = [&](int axis, const auto& next) {
      for_each_image(placed, axis, images, [&](double sign, double shift) {
        image.sign[axis] = sign, image.shift[axis] = shift;
        next();
      });
    };
    add_along(0, [&] { add_along(1, [&] { add_along(2, [&] { all.push_back(image); }); }); });
    return all;
  }

  void fill_samples(const PosedProfile& placed, bool images) {
    // A column has the same density along its axis, over the length of the body.
    const double scale = 1 / cloud_.cross_section / (cloud_.dimension == 3 && profile_.depth.is_even() ? extent_ : 1);
    constexpr double around = 1.5;  // spacings: how far samples lie from their point
    const std::vector<Image> all = all_images(placed, images);
    std::vector<Image> near;
    for (int i = 0; i < cloud_.owned; ++i) {
      near.clear();
      for (const Image& image : all)
        if (!placed.is_far(image.of(cloud_.x[i]), around * cloud_.spacing[i])) near.push_back(image);
      if (near.empty()) continue;
      const auto [begin, end] = samples_of(i);
      const CellSamples& samples = subdomains_ ? *subdomains_ : samples_;
      double share = 0;
      for (auto s = begin; s < end; ++s) share += samples.weight[s] * scale * density(placed, samples.x[s], near);
      if (share == 0) continue;
      point_.push_back(i);
      share_.push_back(share);
    }
  }

  /// Where the samples of a point's subdomain or cell are. Those of cells are made when first asked for: a source that
  /// moves comes by a part of the cloud only, but by that in many steps.
  std::pair<std::int64_t, std::int64_t> samples_of(int i) {
    if (subdomains_) return {subdomains_->row[i], subdomains_->row[i + 1]};
    if (!sampler_) sampler_.emplace(cloud_), row_.assign(cloud_.owned, -1);
    if (row_[i] < 0) {
      CellSamples own;
      sampler_->near(cloud_.x[i], 1e-6 * cloud_.spacing[i], own);
      row_[i] = static_cast<std::int64_t>(samples_.point.size());
      samples_.point.push_back(i);
      samples_.x.insert(samples_.x.end(), own.x.begin(), own.x.end());
      samples_.weight.insert(samples_.weight.end(), own.weight.begin(), own.weight.end());
      samples_.row.push_back(static_cast<std::int64_t>(samples_.x.size()));
    }
    return {samples_.row[row_[i]], samples_.row[row_[i] + 1]};
  }

  void fill_facets(const PosedProfile& placed, bool images) {
    const std::vector<Image> all = all_images(placed, images);
    for (const Facet& facet : cloud_.facets) {
      if (facet.face != *profile_.face) continue;
      const double share = facet.area / cloud_.cross_section * density(placed, cloud_.x[facet.point], all);
      if (share == 0) continue;
      point_.push_back(facet.point);
      share_.push_back(share);
    }
  }

  /// Facets that look away from the source, as those of the far side of a thin plate, get nothing.
  void fill_curved_face(const PosedProfile& placed) {
    const Foot foot = foot_on_face(cloud_, *profile_.face, placed.location());
    for (const Facet& facet : cloud_.facets) {
      if (facet.face != *profile_.face || dot(facet.normal, foot.normal) <= 0) continue;
      const double distance = norm(place_on_wall(cloud_, facet) - foot.x);
      double density = profile_.along.peak(distance) * std::exp(-profile_.along.fall(distance));
      if (density == 0) continue;
      if (cloud_.dimension > 2) density *= profile_.across.peak(0);
      point_.push_back(facet.point);
      share_.push_back(facet.area / cloud_.cross_section * density);
    }
  }

  static double density(const PosedProfile& placed, const Vec3& x, std::span<const Image> images) {
    double density = 0;
    for (const Image& image : images) density += placed.density(image.of(x));
    return density;
  }

  const Cloud& cloud_;
  SourceProfile profile_;
  Path path_;
  double efficiency_, part_;
  bool normalise_;
  std::optional<BoxBody> box_;
  const CellSamples* subdomains_ = nullptr;
  std::optional<CellSampler> sampler_;
  CellSamples samples_;            ///< of the points that the source has come by
  std::vector<std::int64_t> row_;  ///< of every owned point: its place in samples_, or -1
  std::optional<LatticeCells> cells_;
  std::vector<Line> lines_;
  double extent_;  ///< of the body along the axis, m

  // At the time prepared for.
  double t_ = std::numeric_limits<double>::quiet_NaN();
  double asked_ = 0, power_ = 0;
  bool is_on_lattice_ = false;
  std::array<std::vector<double>, 3> factor_;
  std::int32_t first_ = 0, end_ = 0;  ///< along x, where factors are not 0
  std::vector<int> point_;
  std::vector<double> share_;
};

}  // namespace

std::unique_ptr<Source> make_moving_source(const std::string& name, const Table& table, const Cloud& cloud,
                                           const SourceProfile& profile, double end) {
  const double efficiency = table.number("efficiency");
  if (!(efficiency > 0 && efficiency <= 1))
    table.refuse("efficiency", fmt::format("an efficiency of {:g} does not lie between 0 and 1", efficiency),
                 "give the part of the power that reaches the body");
  if (cloud.axisymmetric)
    table.refuse("", fmt::format("[{}] has a place in an axisymmetric body, in which it would be a ring", table.path()),
                 "give power_density by a formula, or a power that is spread by relative_density");
  Path path = Path::read(table, cloud.dimension);
  std::array<bool, 3> varies{};
  for (int axis = 0; axis < cloud.dimension; ++axis) varies[axis] = profile.varies(axis);
  const std::vector<Stretch> lines = stretches_of(path, cloud, profile.radius, varies);
  double spacing = 0;
  for (const Stretch& line : lines) spacing = std::max(spacing, line.spacing);
  spacing = max(cloud.comm, spacing);
  if (spacing == 0)
    table.refuse(table.has("at")     ? "at"
                 : table.has("path") ? "path"
                                     : "pass",
                 fmt::format("the source '{}' never touches the body", name), "move it onto the body");
  SourceProfile resolved = profile;
  if (profile.radius == 0) {
    resolved.along = resolved.across = AxisProfile::box(spacing);
    resolved.sigma = spacing;
  }
  auto source = std::make_unique<MovingSource>(name, table, cloud, resolved, std::move(path));
  for (const std::string& note : notes_on_path(lines, name, end, cloud.comm))
    source->notes.push_back(table.location().text() + ": " + note);
  if (profile.radius > 0 && profile.radius < 2 * spacing)
    source->notes.push_back(fmt::format(
        "{}: the source '{}' has a radius of {:.3g} mm, less than two spacings of {:.3g} mm: its power is right, "
        "temperatures near it are not resolved",
        table.location().text(), name, 1e3 * profile.radius, 1e3 * spacing));
  return source;
}

}  // namespace calor
