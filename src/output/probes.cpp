#include "output/probes.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "surface/body.hpp"

namespace calor {
namespace {

/// A cloud point near a probe, as it travels between ranks.
struct Candidate {
  double distance;
  std::int64_t id;
  Vec3 x;
  Vec3 side;  ///< where it lies for all questions about sides: beside a crack that it is on
  double spacing;
  std::uint32_t on_faces;
  int tag, rank, point;
};

bool nearer(const Candidate& a, const Candidate& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.id < b.id;
}

/// The `most` points of the whole cloud next to p, nearest first, the same on every rank.
std::vector<Candidate> nearest_points(const Cloud& cloud, const Cracks* cracks, const Vec3& p, int most) {
  std::vector<Candidate> mine;  // a heap with the farthest on top
  for (int i = 0; i < cloud.owned; ++i) {
    const Candidate c{.distance = norm(cloud.x[i] - p),
                      .id = cloud.id[i],
                      .x = cloud.x[i],
                      .side = cracks       ? cracks->location(i)
                              : cloud.body ? cloud.inside[i]
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

/// Does p lie behind the wall at the point next to it? A plane counts for as far as the points around that lie on the
/// same face stay behind it (walls that curve inwards); p is outside when it lies beyond all planes of the point, or
/// beyond one that no point around exceeds (not so at an inner edge). Collective.
bool is_behind_wall(const Cloud& cloud, const Vec3& p, std::span<const Candidate> near) {
  const Candidate& next = near.front();
  bool outside = false;
  if (next.rank == rank_of(cloud.comm)) {
    int planes = 0, beyond = 0;
    for (const Facet& facet : cloud.facets) {
      if (facet.point != next.point) continue;
      // Off the walls of clouds that are no boxes, the distance of the wall is known roughly.
      const double wall = (cloud.walls.empty() ? 1.1 : 1) * wall_distance(cloud, facet);
      double of_face = 0, of_any = 0;
      for (const Candidate& c : near) {
        if (norm(c.x - next.x) > 1.5 * next.spacing) continue;
        const double excess = dot(c.x - next.x, facet.normal);
        of_any = std::max(of_any, excess);
        if (c.on_faces >> facet.face & 1) of_face = std::max(of_face, excess);
      }
      const double excess = dot(p - next.x, facet.normal) - wall;
      ++planes;
      if (excess <= 0.01 * next.spacing + 0.5 * of_face) continue;
      ++beyond;
      if (of_any < 0.5 * excess) outside = true;
    }
    if (planes > 0 && beyond == planes) outside = true;
  }
  return any(cloud.comm, outside);
}

/// Refuses a place outside the body. Collective.
void check_inside(const Cloud& cloud, const Vec3& p, std::span<const Candidate> near, const std::string& name,
                  const SourceLocation& in_case) {
  const double d = near.front().spacing;
  const bool beyond_axis = cloud.axisymmetric && p.x < 0;
  if (cloud.body) {
    constexpr double off_chords = 0.1;  // in spacings: facets of curved faces lie off them
    const bool is_inside = cloud.body->tree().is_inside(p) || cloud.body->tree().closest(p, off_chords * d);
    if (is_inside && !beyond_axis) return;
  } else {
    const bool is_far = near.front().distance > 0.75 * std::sqrt(cloud.dimension) * d;
    if (!is_far && !beyond_axis && !is_behind_wall(cloud, p, near)) return;
  }
  std::string bounds;
  for (int axis = 0; axis < cloud.dimension; ++axis) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3& x : cloud.owned_points()) low = std::min(low, x[axis]), high = std::max(high, x[axis]);
    bounds += fmt::format("{}{} from {:g} to {:g} m", axis ? ", " : "", "xyz"[axis], min(cloud.comm, low),
                          max(cloud.comm, high));
  }
  throw Error(Fault::bad_case, in_case,
              fmt::format("probe '{}' at ({:g}, {:g}, {:g}) m lies outside the body", name, p.x, p.y, p.z),
              "move it inside; the points of the body have " + bounds);
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

/// Weights a of the points such that sum a_i f(x_i) = f(p) for every polynomial f of the third degree, with the least
/// sum a_i^2 / w_i: moving least squares in dual form. Where the points do not determine a monomial (too few of them,
/// few layers), or only with large weights of both signs, it is left out.
std::vector<double> interpolation_weights(const Vec3& p, std::span<const Candidate> near, bool are_all, int dimension) {
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
  }
  return {best.begin(), best.end()};
}

/// The points around a probe that one of the parts of the body shows it.
struct View {
  int part;
  double share;  ///< in the probe's temperature
  std::vector<Candidate> points;
};

/// What a probe at p sees: in the part that it lies in, or on an interface from every side. Nothing where that part has
/// no point near.
std::vector<View> views_of(const Cloud& cloud, const Obstacles& obstacles, const Vec3& p,
                           const std::vector<Candidate>& near) {
  const auto [parts, cracks] = obstacles;
  const int tag = near.front().tag;
  std::vector<View> views;
  if (!parts || parts->count() == 1) {
    views.push_back({0, 1, near});
  } else {
    const auto shares = parts->shares({&p, 1}, {&tag, 1}, {&near.front().spacing, 1});
    for (int part = 0; part < parts->count(); ++part)
      if (!shares[part].place.empty()) views.push_back({part, 0, near});
    std::vector<Parts::Segment> segments;
    for (const Candidate& c : near) segments.push_back({p, c.x, tag, c.tag});
    const Parts::Pieces pieces = parts->along(segments);
    for (View& view : views) {
      std::size_t n = 0;
      std::erase_if(view.points, [&](const Candidate&) {
        double begin = 0;
        bool hidden = false;
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
  for (View& view : views) view.share = 1.0 / static_cast<double>(views.size());
  return views;
}

/// Is p on a contact or on a crack?
bool is_on_contact(const Cloud& cloud, const Obstacles& obstacles, const Vec3& p, const Candidate& next) {
  const double step = 1e-6 * next.spacing;
  for (int axis = 0; axis < cloud.dimension; ++axis) {
    Vec3 aside;
    aside[axis] = step;
    const Parts::Segment across{p - aside, p + aside, next.tag, next.tag};
    if (obstacles.cracks && obstacles.cracks->separate(across.a, across.b)) return true;
    if (!obstacles.parts || !obstacles.parts->has_contacts()) continue;
    const Parts::Pieces pieces = obstacles.parts->along({&across, 1});
    for (std::size_t q = 1; q < pieces.piece.size(); ++q)
      if (obstacles.parts->contact(pieces.piece[q - 1].part, pieces.piece[q].part)) return true;
  }
  return false;
}

}  // namespace

Probes::Probes(const Case& c, const Cloud& cloud, const Dofs* dofs, const Parts* parts)
    : comm_(cloud.comm), first_slot_{0} {
  std::unique_ptr<Cracks> cracks;
  if (has_cracks(c)) cracks = std::make_unique<Cracks>(cloud, read_cracks(c, cloud));
  const Table section = c.section("probe");
  for (const std::string& name : section.keys()) {
    const std::vector<double> at = section.numbers(name);
    if (name.find_first_of(",[]\"\n") != name.npos)
      section.refuse(name, fmt::format("'{}' cannot be the name of a column", name), "leave out commas and brackets");
    const bool fits = static_cast<int>(at.size()) >= cloud.dimension && at.size() <= 3;
    if (!fits || std::any_of(at.begin() + cloud.dimension, at.end(), [](double x) { return x != 0; }))
      section.refuse(
          name,
          fmt::format("probe '{}' has {} coordinates in a body of {} dimensions", name, at.size(), cloud.dimension),
          fmt::format("give {} lengths; any further ones are 0", cloud.dimension));
    Vec3 place;
    for (std::size_t axis = 0; axis < at.size(); ++axis) place[static_cast<int>(axis)] = at[axis];
    add(cloud, {parts, cracks.get()}, place, name, section.location(name));
  }
  ask(dofs);
}

Probes::Probes(const Cloud& cloud, std::vector<std::string> names, std::vector<Vec3> places, const Dofs* dofs,
               const Parts* parts)
    : comm_(cloud.comm), first_slot_{0} {
  for (std::size_t p = 0; p < places.size(); ++p) add(cloud, {parts, nullptr}, places[p], names[p], {});
  ask(dofs);
}

void Probes::ask(const Dofs* dofs) {
  if (!dofs || places_.empty()) return;
  std::vector<Vec3> own;
  for (const int p : own_) own.push_back(places_[p]);
  value_rows_ = dofs->interpolation(own);
}

void Probes::add(const Cloud& cloud, const Obstacles& obstacles, const Vec3& place, const std::string& name,
                 const SourceLocation& in_case) {
  constexpr int most[] = {8, 30, 80};  // about three times the number of cubic monomials
  const bool is_divided = obstacles.cracks || cloud.body || (obstacles.parts && obstacles.parts->count() > 1);
  // Where a part of the points is out of sight, enough are left.
  std::vector<Candidate> near =
      nearest_points(cloud, obstacles.cracks, place, (is_divided ? 3 : 1) * most[cloud.dimension - 1]);
  check_inside(cloud, place, near, name, in_case);
  if (near.front().rank == rank_of(comm_)) own_.push_back(static_cast<int>(names_.size()));
  bool on_contact = false;
  if (is_divided) collective_try(comm_, [&] { on_contact = is_on_contact(cloud, obstacles, place, near.front()); });
  if (on_contact)
    notes_.push_back(
        fmt::format("{}: probe '{}' sits on a contact or crack, where the temperature jumps: move it a "
                    "little to the side that is meant",
                    in_case.text(), name));
  std::vector<View> views;
  collective_try(comm_, [&] {
    if (near.front().distance <= 1e-9 * near.front().spacing)
      views.push_back({0, 1, {near.front()}});
    else
      views = views_of(cloud, obstacles, place, near);
  });
  if (views.empty()) {
    notes_.push_back(
        fmt::format("{}: probe '{}' lies in a part of the body that holds no point near it: what it shows comes from "
                    "points of other parts, without what lies between; put points there (on walls, or closer ones), or "
                    "expect the mean of the face",
                    in_case.text(), name));
    views.push_back({0, 1, near});
  }
  int slot = first_slot_.back();
  for (View& view : views) {
    const std::size_t enough = most[cloud.dimension - 1];
    const bool are_all = view.points.size() < enough || std::ssize(view.points) == cloud.count;
    if (view.points.size() > enough) view.points.resize(enough);
    const std::vector<double> weight = view.points.size() == 1
                                           ? std::vector<double>{1}
                                           : interpolation_weights(place, view.points, are_all, cloud.dimension);
    for (std::size_t i = 0; i < view.points.size(); ++i, ++slot)
      if (view.points[i].rank == rank_of(comm_))
        entries_.push_back({.slot = slot, .point = view.points[i].point, .weight = view.share * weight[i]});
  }
  first_slot_.push_back(slot);
  names_.push_back(name);
  places_.push_back(place);
}

std::vector<double> Probes::sample(std::span<const double> field) const {
  std::vector<double> products(first_slot_.back(), 0);
  for (const Entry& e : entries_) products[e.slot] = e.weight * field[e.point];
  // Every product comes from one rank, all others add zero: nothing is rounded here.
  add_up(comm_, products);
  std::vector<double> values(names_.size(), 0);
  for (std::size_t p = 0; p < values.size(); ++p)
    for (int s = first_slot_[p]; s < first_slot_[p + 1]; ++s) values[p] += products[s];
  return values;
}

std::vector<double> Probes::temperatures(std::span<const double> T) const {
  if (!value_rows_) return sample(T);
  std::vector<double> values(names_.size(), 0);
  for (std::size_t n = 0; n < own_.size(); ++n) values[own_[n]] = value_rows_->times(n, T);
  add_up(comm_, values);
  return values;
}

void Probes::add_weights(int probe, std::span<double> w) const {
  if (!value_rows_) {
    for (const Entry& e : entries_)
      if (e.slot >= first_slot_[probe] && e.slot < first_slot_[probe + 1]) w[e.point] += e.weight;
    return;
  }
  const auto own = std::ranges::find(own_, probe);
  if (own == own_.end()) return;
  const auto columns = value_rows_->columns(own - own_.begin());
  const auto values = value_rows_->values(own - own_.begin());
  for (std::size_t n = 0; n < columns.size(); ++n) w[columns[n]] += values[n];
}

Vec3 place_of(const Table& table, const std::string& key, const Cloud& cloud) {
  const std::vector<double> x = table.numbers(key);
  if (static_cast<int>(x.size()) != cloud.dimension)
    table.refuse(key, fmt::format("{} coordinates in a body of {} dimensions", x.size(), cloud.dimension),
                 fmt::format("give {}", cloud.dimension));
  Vec3 place;
  for (int axis = 0; axis < cloud.dimension; ++axis) place[axis] = x[axis];
  return place;
}

double finest_spacing(const Cloud& cloud) {
  double finest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < cloud.owned; ++i) finest = std::min(finest, cloud.spacing[i]);
  return min(cloud.comm, finest);
}

void declare_probes(Schema& schema) {
  schema.add({.path = "probe",
              .sentence = "Places whose temperature is written to probes.csv, any names.",
              .keys = {{.name = "*",
                        .kind = Kind::quantities,
                        .unit = "m",
                        .fallback = optional,
                        .sentence = "Where the probe is; it need not sit on a point of the cloud."}}});
}

}  // namespace calor
