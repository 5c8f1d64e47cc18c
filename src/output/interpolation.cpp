#include "output/interpolation.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "base/parallel.hpp"
#include "surface/body.hpp"

namespace calor {
namespace {

bool nearer(const Candidate& a, const Candidate& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.id < b.id;
}

/// Exponents of the monomials up to the third degree, lowest degree first.
std::vector<std::array<int, 3>> monomials(int dimension) {
  std::vector<std::array<int, 3>> all;
  for (int degree = 0; degree <= 3; ++degree)
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b) {
        const int c = degree - a - b;
        if ((dimension > 1 || b == 0) && (dimension > 2 || c == 0)) all.push_back({a, b, c});
      }
  return all;
}

struct Weights {
  std::vector<double> of_points;
  bool is_linear = false;  ///< linear temperatures are exact
};

/// Weights a of the points such that sum a_i f(x_i) = f(p) for every polynomial f of the third degree, with the least
/// sum a_i^2 / w_i: moving least squares in dual form. Where the points do not determine a monomial (too few of them,
/// few layers), or only with large weights of both signs, it is left out.
Weights interpolation_weights(const Vec3& p, std::span<const Candidate> near, bool are_all, int dimension) {
  const int n = static_cast<int>(near.size());
  // The weight vanishes at the farthest point, so that of several at the same distance none is preferred; unless these
  // are all points that the probe sees. It is steep at the probe, so that a peak next to it is not flattened by the
  // points that a cubic needs in all.
  const double reach = (are_all ? 2 : 1) * near.back().distance, spacing = near.front().spacing;
  Eigen::VectorXd root_w(n);
  for (int i = 0; i < n; ++i)
    root_w[i] = std::pow(1 - std::pow(near[i].distance / reach, 2), 3) / std::hypot(near[i].distance / spacing, 0.1);
  if (n == 1) root_w[0] = 1;

  Eigen::VectorXd best;
  int linear = 0;              // monomials that are exact
  Eigen::MatrixXd rows(0, n);  // one per monomial: its values at the points
  for (const auto& power : monomials(dimension)) {
    Eigen::MatrixXd more(rows.rows() + 1, n);
    more.topRows(rows.rows()) = rows;
    for (int i = 0; i < n; ++i) {
      const Vec3 s = 1 / (reach > 0 ? reach : 1) * (near[i].x - p);
      double value = 1;
      for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < power[axis]; ++k) value *= s[axis];
      more(rows.rows(), i) = value;
    }
    // At p itself the constant is 1 and every other monomial 0.
    const Eigen::VectorXd at_p = Eigen::VectorXd::Unit(more.rows(), 0);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> system;
    system.setThreshold(1e-9);
    system.compute(more * root_w.asDiagonal());
    const Eigen::VectorXd a = root_w.cwiseProduct(system.solve(at_p));
    const bool is_exact = (more * a - at_p).lpNorm<Eigen::Infinity>() < 1e-12;
    constexpr double largest_gain = 8;  // of errors in the points' values; in clouds as they should be it is below 3
    if (!is_exact || a.lpNorm<1>() > largest_gain) continue;
    rows = more;
    best = a;
    linear += power[0] + power[1] + power[2] == 1;
  }
  return {{best.begin(), best.end()}, linear == dimension};
}

/// The points around a probe that one of the parts of the body shows it.
struct View {
  int part;
  std::vector<Candidate> points;
};

/// What a probe at p sees: in the part that it lies in, or on an interface from every side. Nothing where that part has
/// no point near.
std::vector<View> views_of(const Cloud& cloud, const Obstacles& obstacles, const Vec3& p,
                           const std::vector<Candidate>& near) {
  const Parts* parts = obstacles.parts;
  const Cracks* cracks = obstacles.cracks;
  const int tag = near.front().tag;
  std::vector<View> views;
  if (!parts || parts->count() == 1) {
    views.push_back({0, near});
  } else {
    const auto shares = parts->shares({&p, 1}, {&tag, 1}, {&near.front().spacing, 1});
    for (int part = 0; part < parts->count(); ++part)
      if (!shares[part].place.empty()) views.push_back({part, near});
    std::vector<Parts::Segment> segments;
    for (const Candidate& c : near) {
      const double long_as = std::ceil(norm(c.x - p) / near.front().spacing);  // spacings
      segments.push_back({p, c.x, tag, c.tag, std::max(1, static_cast<int>(long_as))});
    }
    const Parts::Pieces pieces = parts->along(segments);
    std::vector<Vec3> x;
    std::vector<int> tags;
    for (const Candidate& c : near) x.push_back(c.x), tags.push_back(c.tag);
    const std::vector<int> own = parts->at(x, tags);
    for (View& view : views) {
      std::size_t n = 0;
      std::erase_if(view.points, [&](const Candidate&) {
        double begin = 0;
        // A point on a contact has the temperature of the side that it belongs to.
        bool hidden = own[n] != view.part && parts->contact(own[n], view.part);
        for (auto q = pieces.row[n]; q < pieces.row[n + 1]; ++q) {
          const auto& [part, end] = pieces.piece[q];
          hidden = hidden || (end - begin > 1e-6 && part != view.part);
          begin = end;
        }
        ++n;
        return hidden;
      });
    }
  }
  if (cloud.body) {
    const Vec3 eye = cloud.eye_at(p, near.front().spacing);
    for (View& view : views)
      std::erase_if(view.points, [&](const Candidate& c) { return !cloud.body->sees(eye, c.side); });
  }
  for (View& view : views)
    if (cracks) std::erase_if(view.points, [&](const Candidate& c) { return cracks->separate(p, c.side); });
  std::erase_if(views, [](const View& view) { return view.points.empty(); });
  return views;
}

/// What a view shows at p.
struct Sum {
  std::vector<WeightedPoint> points;
  bool is_linear = false;
};

Sum sum_of(const Cloud& cloud, const Vec3& p, std::vector<Candidate> points) {
  const std::size_t enough = enough_points(cloud.dimension);
  const bool are_all = points.size() < enough || std::ssize(points) == cloud.count;
  if (points.size() > enough) points.resize(enough);
  const Weights weights = interpolation_weights(p, points, are_all, cloud.dimension);
  Sum sum{{}, weights.is_linear};
  for (std::size_t i = 0; i < points.size(); ++i) sum.points.push_back({points[i], weights.of_points[i]});
  return sum;
}

void add_to(std::vector<WeightedPoint>& all, double share, const Sum& sum) {
  for (const auto& [point, weight] : sum.points) all.push_back({point, share * weight});
}

/// A way across a thin part through a place in it: places just beyond both ends, and the parts there.
struct Crossing {
  struct End {
    Vec3 place;
    int part;
    double distance;  ///< of the surface from the place, m
  };
  std::array<End, 2> ends;
};

/// The way from p to the surface next to it and straight on to the other side. None where one side is more than a few
/// spacings away, a wall of the body, or a contact.
std::optional<Crossing> crossing_at(const Cloud& cloud, const Parts& parts, const Vec3& p, const Candidate& next) {
  constexpr double reach = 2.5, beyond = 1e-6;  // spacings
  const double length = reach * next.spacing;
  std::vector<Parts::Segment> rays;
  const auto add_ray = [&](const Vec3& u) { rays.push_back({p, p + length / norm(u) * u, next.tag, next.tag, 3}); };
  for (int n = 0; n < 27; ++n) {
    const auto step = [n](int power) { return static_cast<double>(n / power % 3) - 1; };
    const Vec3 u{step(1), step(3), step(9)};
    if (u != Vec3{} && (cloud.dimension > 1 || u.y == 0) && (cloud.dimension > 2 || u.z == 0)) add_ray(u);
  }
  Parts::Pieces pieces = parts.along(rays);
  std::size_t nearest = 0;
  for (std::size_t n = 1; n < rays.size(); ++n)
    if (pieces.of(n)[0].end < pieces.of(nearest)[0].end) nearest = n;
  const auto first = pieces.of(nearest);
  if (first.size() < 2) return std::nullopt;
  const Vec3 ray = rays[nearest].b - p;
  const Vec3 normal =
      parts.interface_at(p + first[0].end * ray, ray, next.tag, first[0].part, first[1].part, next.spacing).normal;
  rays.clear();
  add_ray(normal), add_ray(-normal);
  pieces = parts.along(rays);
  Crossing crossing;
  for (std::size_t n = 0; n < 2; ++n) {
    const auto run = pieces.of(n);
    if (run.size() < 2 || parts.contact(run[0].part, run[1].part)) return std::nullopt;
    const Vec3 place = p + (run[0].end + beyond / reach) * (rays[n].b - p);
    if (!parts.is_inside(place)) return std::nullopt;
    crossing.ends[n] = {place, run[1].part, run[0].end * length};
  }
  return crossing;
}

/// Linear between what the parts on either side show at their surfaces.
std::optional<std::vector<WeightedPoint>> across_thin_part(const Cloud& cloud, const Obstacles& obstacles,
                                                           const Vec3& p, const Candidate& next) {
  std::optional<Crossing> crossing;
  collective_try(cloud.comm, [&] { crossing = crossing_at(cloud, *obstacles.parts, p, next); });
  if (!crossing) return std::nullopt;
  const auto& [one, other] = crossing->ends;
  std::vector<WeightedPoint> all;
  for (const auto& end : {one, other}) {
    const std::vector<Candidate> near = nearest_points(cloud, obstacles, end.place);
    std::vector<View> views;
    collective_try(cloud.comm, [&] { views = views_of(cloud, obstacles, end.place, near); });
    const auto view = std::ranges::find(views, end.part, &View::part);
    if (view == views.end()) return std::nullopt;
    const Sum sum = sum_of(cloud, end.place, view->points);
    if (!sum.is_linear) return std::nullopt;
    add_to(all, 1 - end.distance / (one.distance + other.distance), sum);
  }
  return all;
}

}  // namespace

int enough_points(int dimension) {
  constexpr int enough[] = {8, 30, 80};
  return enough[dimension - 1];
}

std::vector<Candidate> nearest_points(const Cloud& cloud, const Obstacles& obstacles, const Vec3& p) {
  const bool is_divided = obstacles.cracks || cloud.body || (obstacles.parts && obstacles.parts->count() > 1);
  const int most = (is_divided ? 3 : 1) * enough_points(cloud.dimension);
  std::vector<Candidate> mine;  // a heap with the farthest on top
  for (int i = 0; i < cloud.owned; ++i) {
    const Candidate c{.distance = norm(cloud.x[i] - p),
                      .id = cloud.id[i],
                      .x = cloud.x[i],
                      .side = obstacles.cracks ? obstacles.cracks->location(i)
                              : cloud.body     ? cloud.inside[i]
                                               : cloud.x[i],
                      .spacing = cloud.spacing[i],
                      .on_faces = cloud.on_faces[i],
                      .tag = cloud.tag[i],
                      .rank = rank_of(cloud.comm),
                      .point = i};
    if (static_cast<int>(mine.size()) == most && !nearer(c, mine.front())) continue;
    mine.push_back(c);
    std::ranges::push_heap(mine, nearer);
    if (static_cast<int>(mine.size()) <= most) continue;
    std::ranges::pop_heap(mine, nearer);
    mine.pop_back();
  }
  std::vector<Candidate> all = gather(cloud.comm, mine);
  std::ranges::sort(all, nearer);
  if (static_cast<int>(all.size()) > most) all.resize(most);
  return all;
}

std::vector<WeightedPoint> interpolation(const Cloud& cloud, const Vec3& p, std::vector<Candidate> near) {
  return sum_of(cloud, p, std::move(near)).points;
}

std::optional<std::vector<WeightedPoint>> interpolation(const Cloud& cloud, const Obstacles& obstacles, const Vec3& p,
                                                        const std::vector<Candidate>& near) {
  if (near.front().distance <= 1e-9 * near.front().spacing) return {{{near.front(), 1}}};
  std::vector<View> views;
  collective_try(cloud.comm, [&] { views = views_of(cloud, obstacles, p, near); });
  std::vector<Sum> sums;
  sums.reserve(views.size());
  for (const View& view : views) sums.push_back(sum_of(cloud, p, view.points));
  const auto is_linear = [](const Sum& sum) { return sum.is_linear; };
  if (obstacles.parts && obstacles.parts->count() > 1) {
    if (std::ranges::any_of(sums, is_linear))
      std::erase_if(sums, std::not_fn(is_linear));
    else if (auto across = across_thin_part(cloud, obstacles, p, near.front()))
      return across;
  }
  if (sums.empty()) return std::nullopt;
  std::vector<WeightedPoint> all;
  for (const Sum& sum : sums) add_to(all, 1.0 / static_cast<double>(sums.size()), sum);
  return all;
}

}  // namespace calor
