#include "output/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "surface/body.hpp"

namespace calor {
namespace {

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
    if (name == "time")
      section.refuse(name, "a probe named 'time' and the time itself would be one column", "give it another name");
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
  const std::vector<Candidate> near = nearest_points(cloud, obstacles, place);
  check_inside(cloud, place, near, name, in_case);
  if (near.front().rank == rank_of(comm_)) own_.push_back(static_cast<int>(names_.size()));
  bool on_contact = false;
  collective_try(comm_, [&] { on_contact = is_on_contact(cloud, obstacles, place, near.front()); });
  if (on_contact)
    notes_.push_back(
        fmt::format("{}: probe '{}' sits on a contact or crack, where the temperature jumps: move it a "
                    "little to the side that is meant",
                    in_case.text(), name));
  auto sum = interpolation(cloud, obstacles, place, near);
  if (!sum) {
    notes_.push_back(
        fmt::format("{}: probe '{}' lies in a part of the body that holds no point near it: what it shows comes from "
                    "points of other parts, without what lies between; put points there (on walls, or closer ones), or "
                    "expect the mean of the face",
                    in_case.text(), name));
    sum = interpolation(cloud, place, near);
  }
  int slot = first_slot_.back();
  for (const auto& [point, weight] : *sum) {
    if (point.rank == rank_of(comm_)) entries_.push_back({.slot = slot, .point = point.point, .weight = weight});
    ++slot;
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
