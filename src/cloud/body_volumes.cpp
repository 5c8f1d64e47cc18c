#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "cloud/body_measures.hpp"
#include "cloud/lattice.hpp"
#include "cloud/linear_shares.hpp"

namespace calor {
namespace {

struct Sample {
  Vec3 x;
  double weight;
};

/// Three Gauss points along every edge of a box.
std::vector<Sample> gauss_points(const Box& box, int D) {
  constexpr std::array<double, 3> place = {0.1127016653792583, 0.5, 0.8872983346207417};
  constexpr std::array<double, 3> weight = {5. / 18, 4. / 9, 5. / 18};
  std::vector<Sample> out;
  for (int n = 0; n < (D == 3 ? 27 : 9); ++n) {
    const std::array<int, 3> k = {n % 3, n / 3 % 3, n / 9};
    Sample s{.x = box.low, .weight = 1};
    for (int a = 0; a < D; ++a) s.x[a] += box.size * place[k[a]], s.weight *= box.size * weight[k[a]];
    out.push_back(s);
  }
  return out;
}

/// Tells places inside a body from those outside, by what is known of places around: a way that crosses no wall costs
/// a tenth of a winding number.
class InsideTest {
 public:
  explicit InsideTest(const SurfaceTree& tree) : tree_(tree) {}
  bool operator()(const Vec3& x) {
    for (const auto& [place, is_inside] : known_)
      if (!tree_.is_crossed(place, x)) return is_inside;
    return known_.emplace_back(x, tree_.is_inside(x)).second;
  }

 private:
  const SurfaceTree& tree_;
  std::vector<std::pair<Vec3, bool>> known_;
};

/// One place at random in each of many equal parts of a box that the surface cuts, where it lies in the body.
std::vector<Sample> random_places(const Body& body, const Box& box, std::uint64_t number) {
  const int D = body.surface().dimension, per = D == 3 ? 5 : 10, count = D == 3 ? per * per * per : per * per;
  InsideTest is_inside(body.tree());
  std::vector<Sample> out;
  for (int n = 0; n < count; ++n) {
    const std::array<int, 3> k = {n % per, n / per % per, n / (per * per)};
    const Vec3 random = hashed_uniform(number, n);
    Sample s{.x = box.low, .weight = std::pow(box.size / per, D)};
    for (int a = 0; a < D; ++a) s.x[a] += box.size * (k[a] + random[a]) / per;
    if (is_inside(s.x)) out.push_back(s);
  }
  return out;
}

/// What the points of a lattice have of a box between them: the same everywhere.
class LatticeStencil {
 public:
  explicit LatticeStencil(int dimension) : D_(dimension), reach_(LinearShares::radius + 0.5 * std::sqrt(dimension)) {
    LinearShares shares;
    std::vector<Vec3> nodes;
    for (int n = 0; n < entries; ++n)
      if (const Vec3 x = node(n); norm(x - middle()) < reach_) nodes.push_back(x), ++count_;
    for (const Sample& s : gauss_points({.low = {}, .size = 1, .is_cut = false}, D_)) {
      shares.clear();
      for (const Vec3& x : nodes) shares.add(entry(x), x - s.x, dot(x - s.x, x - s.x));
      shares.solve(D_);
      for (std::size_t k = 0; k < shares.ids.size(); ++k) share_[shares.ids[k]] += s.weight * shares.value[k];
    }
  }

  /// Adds the shares of a box in which all points around are those of the lattice; false where they are not.
  bool add(const Box& box, const BodyPoints& points, std::vector<double>& volume) {
    around_.clear();
    bool is_lattice = true;
    points.grid.for_each_within(box.low + box.size * middle(), reach_, [&](int j, double) {
      is_lattice = is_lattice && points.is_lattice[j];
      around_.push_back(j);
    });
    if (!is_lattice || static_cast<int>(around_.size()) != count_) return false;
    const double cell = D_ == 3 ? box.size * box.size * box.size : box.size * box.size;
    for (const int j : around_) volume[j] += cell * share_[entry((1 / box.size) * (points.grid.x(j) - box.low))];
    return true;
  }

 private:
  static constexpr int side = 8, lowest = -3, entries = side * side * side;

  Vec3 middle() const { return {0.5, 0.5, D_ == 3 ? 0.5 : 0}; }
  Vec3 node(int n) const {
    const auto at = [](int k) { return static_cast<double>(k % side + lowest); };
    return {at(n), at(n / side), D_ == 3 ? at(n / (side * side)) : n < side * side ? 0 : 100.0};
  }
  int entry(const Vec3& x) const {
    const auto at = [](double c) { return static_cast<int>(std::lround(c)) - lowest; };
    return at(x.x) + side * (at(x.y) + (D_ == 3 ? side * at(x.z) : 0));
  }

  int D_, count_ = 0;
  double reach_;
  std::array<double, entries> share_ = {};
  std::vector<int> around_;
};

/// Shares samples of the body among the points that they see.
class VolumeShares {
 public:
  VolumeShares(const Body& body, const BodyPoints& points) : body_(body), grid_(points.grid) {
    for (int i = 0; i < grid_.count(); ++i) {
      const double d = grid_.spacing(i), sight = 2 * LinearShares::radius * d;
      const auto wall = body.tree().closest(grid_.x(i), sight);
      clearance_.push_back(wall ? wall->distance : sight);
      inside_.push_back(clearance_[i] < Body::skin * d ? body.moved_inside(grid_.x(i), Body::skin * d) : grid_.x(i));
    }
  }

  void add(const std::vector<Sample>& samples, std::vector<double>& volume) {
    places_.clear();
    for (const Sample& s : samples) {
      const auto place = std::ranges::find_if(places_, [&](const Place& p) { return body_.sees(p.x, s.x); });
      Place& from = place == places_.end() ? places_.emplace_back(Place{s.x, {}}) : *place;
      share(s, from, volume);
    }
  }

 private:
  /// A sample, and what is known of the points that it and those around it see.
  struct Place {
    Vec3 x;
    std::map<int, bool> sees;
  };

  bool is_seen(Place& from, int j, double square) {
    if (square < clearance_[j] * clearance_[j]) return true;
    const auto [found, is_new] = from.sees.try_emplace(j, false);
    if (is_new) found->second = body_.sees(from.x, inside_[j]);
    return found->second;
  }

  void share(const Sample& s, Place& from, std::vector<double>& volume) {
    const int D = body_.surface().dimension;
    double reach = LinearShares::radius;
    for (int step = 0; step < LinearShares::most_steps; ++step, reach *= LinearShares::farther) {
      shares_.clear();
      grid_.for_each_within(s.x, reach, [&](int j, double square) {
        if (!is_seen(from, j, square)) return;
        const double unit = LinearShares::radius / (reach * grid_.spacing(j));
        shares_.add(j, (1 / grid_.spacing(j)) * (grid_.x(j) - s.x), square * unit * unit);
      });
      if (!shares_.solve(D)) continue;
      for (std::size_t n = 0; n < shares_.ids.size(); ++n) volume[shares_.ids[n]] += s.weight * shares_.value[n];
      return;
    }
    volume[nearest(s.x)] += s.weight;
  }

  int nearest(const Vec3& x) const {
    std::pair<double, int> best{1e300, 0};
    for (double reach = 1; best.first == 1e300; reach *= 2)
      grid_.for_each_within(x, reach, [&](int j, double square) { best = std::min(best, {square, j}); });
    return best.second;
  }

  const Body& body_;
  const PointGrid& grid_;
  std::vector<double> clearance_;  // distance to the surface, as far as the points see
  std::vector<Vec3> inside_;
  std::vector<Place> places_;
  LinearShares shares_;
};

}  // namespace

std::vector<double> body_volumes(const Body& body, const BodyPoints& points, const std::vector<Box>& boxes) {
  const int D = body.surface().dimension;
  std::vector<double> volume(points.grid.count()), cut(points.grid.count());
  VolumeShares shares(body, points);
  LatticeStencil stencil(D);
  for (std::size_t n = 0; n < boxes.size(); ++n) {
    const Box& box = boxes[n];
    if (box.is_cut)
      shares.add(random_places(body, box, n), cut);
    else if (!stencil.add(box, points, volume))
      shares.add(gauss_points(box, D), volume);
  }
  const double whole = std::accumulate(volume.begin(), volume.end(), 0.0);
  const double in_cut = std::accumulate(cut.begin(), cut.end(), 0.0);
  const double scale = in_cut > 0 ? (enclosed_volume(body.surface()) - whole) / in_cut : 0;
  for (std::size_t i = 0; i < volume.size(); ++i) volume[i] += scale * cut[i];
  return volume;
}

}  // namespace calor
