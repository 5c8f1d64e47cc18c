#include "conduction/series_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/contact_pairs.hpp"
#include "conduction/fibres.hpp"
#include "conduction/interface_points.hpp"
#include "conduction/pair_directions.hpp"
#include "conduction/pair_flux.hpp"

namespace calor {

namespace {

/// A piece shorter than this part of the way is round-off.
constexpr double shortest_piece = 1e-9;

}  // namespace

/// Finds the pairs and what they run through.
class SeriesPairs::Builder {
 public:
  Builder(SeriesPairs& out, const Cloud& cloud, const Parts& parts, const Neighbours& neighbours, std::span<double> G,
          std::span<const Symmetric3> R)
      : out_(out),
        cloud_(cloud),
        parts_(parts),
        neighbours_(neighbours),
        G_(G),
        R_(R),
        points_(cloud, parts, neighbours) {}

  void add_pairs(std::span<const CrackBond> bonds) {
    collect(bonds);
    on_lattice() ? add_in_fibres(bonds) : add_along_lines(bonds);
  }

 private:
  struct Candidate {
    std::int32_t a, b;
    std::int64_t entry;  // of the direction that is looked at
    bool may_be_inside;  // of one part, if nothing lies between its ends
  };

  /// Cells that are known as boxes tell how much of a pair's heat runs through which part.
  bool on_lattice() const { return cloud_.lattice && parts_.count() > 1; }

  void add_along_lines(std::span<const CrackBond> bonds) {
    std::vector<Parts::Segment> segments;
    std::vector<std::size_t> may_run_along;  // an interface, as both ends lie on one
    std::vector<Vec3> middle;
    std::vector<int> tags;
    std::vector<double> size;
    for (const Candidate& c : candidates_) {
      segments.push_back(
          {cloud_.x[c.a], cloud_.x[c.b], cloud_.tag[c.a], cloud_.tag[c.b], spacings_between(cloud_, c.a, c.b)});
      if (points_.count_of_parts(c.a) < 2 || points_.count_of_parts(c.b) < 2) continue;
      may_run_along.push_back(segments.size() - 1);
      middle.push_back(0.5 * (cloud_.x[c.a] + cloud_.x[c.b]));
      tags.push_back(cloud_.tag[c.a]);
      size.push_back(0.5 * (cloud_.spacing[c.a] + cloud_.spacing[c.b]));
    }
    const Parts::Pieces pieces = parts_.along(segments);
    std::vector<std::vector<std::pair<int, double>>> shares(candidates_.size());  // of the parts, where it runs between
    const auto of_part = parts_.shares(middle, tags, size);
    for (int part = 0; part < parts_.count(); ++part)
      for (std::size_t n = 0; n < of_part[part].place.size(); ++n)
        shares[may_run_along[of_part[part].place[n]]].emplace_back(part, of_part[part].share[n]);
    for (std::size_t n = 0; n < candidates_.size(); ++n) {
      const Candidate& c = candidates_[n];
      if (c.may_be_inside && (pieces.of(n).size() == 1 || goes_around(c, segments[n], pieces.of(n)))) continue;
      const double G = G_[c.entry];
      remove_weights(c);
      if (shares[n].size() > 1)
        for (const auto& [part, share] : shares[n]) split_by_cracks(c, bonds, along_interface(c, part, share * G));
      else
        split_by_cracks(c, bonds, across(c, segments[n], pieces.of(n), G));
    }
  }

  /// Where contacts end the cells: does a pair of one side cut off a bulge of the other, whose two walls look the same
  /// way? If they look apart, it jumps over what lies between.
  bool goes_around(const Candidate& c, const Parts::Segment& segment, std::span<const SegmentPiece> run) const {
    if (!contacts_end_cells(cloud_)) return false;
    const double size = 0.5 * (cloud_.spacing[c.a] + cloud_.spacing[c.b]);
    const Vec3 x_ba = segment.b - segment.a;
    const auto normal_along = [&](std::size_t n) {
      const Vec3 normal =
          parts_.interface_at(segment.a + run[n].end * x_ba, x_ba, segment.tag_a, run[n].part, run[n + 1].part, size)
              .normal;
      return dot(normal, x_ba) < 0 ? -normal : normal;
    };
    return dot(normal_along(0), normal_along(run.size() - 2)) < 0;
  }

  void add_in_fibres(std::span<const CrackBond> bonds) {
    std::vector<std::pair<std::int32_t, std::int32_t>> ends;
    for (const Candidate& c : candidates_) ends.emplace_back(c.a, c.b);
    const auto of_pair = fibres(cloud_, parts_, ends);
    for (std::size_t n = 0; n < candidates_.size(); ++n) {
      const Candidate& c = candidates_[n];
      if (c.may_be_inside && of_pair[n].size() == 1 && of_pair[n][0].run.size() == 1) continue;
      const double G = G_[c.entry];
      remove_weights(c);
      for (const Fibre& f : of_pair[n]) split_by_cracks(c, bonds, across(c, f.segment, f.run, f.share * G));
    }
  }

  /// Pairs, each once on a rank, that may not be left to the mean of two conductivities; by id a, then id b.
  void collect(std::span<const CrackBond> bonds) {
    std::vector<char> is_cracked(neighbours_.column.size(), 0);
    for (const CrackBond& b : bonds) is_cracked[b.entry] = 1;
    for (std::int32_t i = 0; i < cloud_.owned; ++i) {
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
        const std::int32_t j = neighbours_.column[n];
        if (j < cloud_.owned && cloud_.id[j] < cloud_.id[i]) continue;
        const bool ends_alike = points_.are_of_one_part(i, j) && !parts_.has_plane_between(cloud_.x[i], cloud_.x[j]);
        const bool inside = ends_alike && points_.have_nothing_between(i, j);
        if (inside && !is_cracked[n]) continue;
        const auto [a, b] = cloud_.id[i] < cloud_.id[j] ? std::pair(i, j) : std::pair(j, i);
        candidates_.push_back({a, b, n, ends_alike && !is_cracked[n]});
      }
    }
    std::ranges::sort(candidates_, {}, [&](const Candidate& c) { return std::pair(cloud_.id[c.a], cloud_.id[c.b]); });
  }

  void remove_weights(const Candidate& c) {
    G_[c.entry] = 0;
    if (c.a >= cloud_.owned || c.b >= cloud_.owned) return;
    const auto row = neighbours_.of(c.b);
    const auto back = std::ranges::lower_bound(row, cloud_.id[c.a], {}, [&](std::int32_t j) { return cloud_.id[j]; });
    G_[neighbours_.row[c.b] + (back - row.begin())] = 0;
  }

  /// Where the conductivity of a part is wanted for a point: at the point, or at a place of the part.
  std::int32_t end_at(std::int32_t point, int part, const Vec3* place = nullptr) {
    const auto next = static_cast<std::int32_t>(out_.ends_.x.size());
    if (!place) {
      const auto [known, is_new] = known_.try_emplace({point, part}, next);
      if (!is_new) return known->second;
    }
    QuadraturePoints& ends = out_.ends_;
    ends.x.push_back(place ? *place : cloud_.x[point]);
    ends.tag.push_back(cloud_.tag[point]);
    ends.part.push_back(part);
    ends.phi.column.push_back(point);
    ends.phi.value.push_back(1);
    ends.phi.close_row();
    return next;
  }

  Pair start_pair(const Candidate& c, double G) const {
    return {.a = c.a,
            .b = c.b,
            .G = G,
            .first = static_cast<std::int32_t>(out_.pieces_.size()),
            .end = 0,
            .one_part = false,
            .first_contact = static_cast<std::int32_t>(out_.contacts_.size())};
  }
  std::size_t add(Pair p) {
    p.end = static_cast<std::int32_t>(out_.pieces_.size());
    p.end_contact = static_cast<std::int32_t>(out_.contacts_.size());
    out_.pairs_.push_back(p);
    return out_.pairs_.size() - 1;
  }

  /// R of a part along a pair.
  double factor(const Candidate& c, int part) const {
    return R_.empty() ? 1 : along(R_[part], cloud_.x[c.b] - cloud_.x[c.a]);
  }

  void set_one_part(const Candidate& c, int part, Pair& p) {
    p.one_part = true;
    const double half = 0.5 / factor(c, part);
    out_.pieces_.push_back({end_at(c.a, part), half});
    out_.pieces_.push_back({end_at(c.b, part), half});
  }

  std::size_t along_interface(const Candidate& c, int part, double G) {
    Pair p = start_pair(c, G);
    set_one_part(c, part, p);
    return add(p);
  }

  std::size_t across(const Candidate& c, const Parts::Segment& segment, std::span<const SegmentPiece> run, double G) {
    Pair p = start_pair(c, G);
    const Vec3 x_ba = segment.b - segment.a;
    std::vector<SegmentPiece> kept;
    double begin = 0;
    for (std::size_t n = 0; n < run.size(); ++n) {
      if (n > 0) add_contact(segment, run[n - 1], run[n].part, c, static_cast<std::int32_t>(kept.size()));
      if (run[n].end - begin > shortest_piece) kept.push_back(run[n]);
      begin = run[n].end;
    }
    if (kept.size() == 1) {
      set_one_part(c, kept[0].part, p);
    } else {
      begin = 0;
      for (std::size_t n = 0; n < kept.size(); ++n) {
        const double middle = 0.5 * (begin + kept[n].end);
        const bool at_a = n == 0 || (n + 1 < kept.size() && middle <= 0.5), at_end = n == 0 || n + 1 == kept.size();
        const Vec3 place = segment.a + middle * x_ba;
        out_.pieces_.push_back({end_at(at_a ? c.a : c.b, kept[n].part, at_end ? nullptr : &place),
                                (kept[n].end - begin) / factor(c, kept[n].part)});
        begin = kept[n].end;
      }
    }
    return add(p);
  }

  void add_contact(const Parts::Segment& segment, const SegmentPiece& before, int after, const Candidate& c,
                   std::int32_t pieces_before) {
    const Function* h = parts_.contact(before.part, after);
    if (!h) return;
    const Vec3 x_ba = segment.b - segment.a, x = segment.a + before.end * x_ba;
    const double size = 0.5 * (cloud_.spacing[c.a] + cloud_.spacing[c.b]);
    const Parts::Interface found = parts_.interface_at(x, x_ba, segment.tag_a, before.part, after, size);
    out_.contacts_.push_back({.h = h,
                              .pair = static_cast<std::int32_t>(out_.pairs_.size()),  // the one that is on its way
                              .before = pieces_before,
                              .x = x,
                              .length = std::abs(dot(x_ba, found.normal)),
                              .piece = found.piece});
  }

  /// A crack leaves a pair the rest of its weight, and the fraction that it cuts a resistance from when it opens.
  void split_by_cracks(const Candidate& c, std::span<const CrackBond> bonds, std::size_t pair) {
    const auto begin = std::ranges::lower_bound(bonds, c.entry, {}, &CrackBond::entry);
    const auto end = std::ranges::upper_bound(bonds, c.entry, {}, &CrackBond::entry);
    if (begin == end) return;
    double whole = 1;
    const auto first = static_cast<std::int32_t>(out_.cracks_.size());
    for (auto bond = begin; bond != end; ++bond) {
      whole *= 1 - bond->fraction;
      out_.cracks_.push_back(
          {bond->opens, bond->contact > 0 ? 1 / bond->contact : std::numeric_limits<double>::infinity()});
    }
    Pair cut = out_.pairs_[pair];
    cut.G = (1 - whole) * out_.pairs_[pair].G;
    cut.first_crack = first, cut.end_crack = static_cast<std::int32_t>(out_.cracks_.size());
    out_.pairs_[pair].G *= whole;
    cut.first_contact = static_cast<std::int32_t>(out_.contacts_.size());
    for (auto n = out_.pairs_[pair].first_contact; n < out_.pairs_[pair].end_contact; ++n) {
      Contact contact = out_.contacts_[n];
      contact.pair = static_cast<std::int32_t>(out_.pairs_.size());
      out_.contacts_.push_back(contact);
    }
    cut.end_contact = static_cast<std::int32_t>(out_.contacts_.size());
    out_.pairs_.push_back(cut);
  }

  SeriesPairs& out_;
  const Cloud& cloud_;
  const Parts& parts_;
  const Neighbours& neighbours_;
  std::span<double> G_;
  std::span<const Symmetric3> R_;
  const InterfacePoints points_;
  std::vector<Candidate> candidates_;
  std::map<std::pair<std::int32_t, int>, std::int32_t> known_;
};

SeriesPairs::SeriesPairs(const Cloud& cloud, const Parts& parts, const Neighbours& neighbours, std::span<double> G,
                         CrackBonds cracks, std::span<const Symmetric3> R)
    : cloud_(&cloud), openings_(std::move(cracks.openings)) {
  std::ranges::stable_sort(cracks.bonds, {}, &CrackBond::entry);
  const bool has_bonds = any(cloud.comm, !cracks.bonds.empty());
  if (parts.count() == 1 && !has_bonds) return;
  exist_ = true;
  Builder builder(*this, cloud, parts, neighbours, G, R);
  collective_try(cloud.comm, [&] { builder.add_pairs(cracks.bonds); });
  fit_contacts_to_areas(parts);
  collective_try(cloud.comm, [&] { sort_contacts_into_laws(); });
  const auto of = [&](auto depends) {
    return any(cloud.comm, std::ranges::any_of(laws_, [&](const Law& law) { return depends(law.h.function()); }));
  };
  depends_on_T_ = of([](const Function& h) { return h.depends_on_temperature(); });
  depends_on_time_ = of([](const Function& h) { return h.depends_on_time(); });
  find_changes(parts);
  open(0);
}

void SeriesPairs::open(double t) {
  for (Pair& p : pairs_) {
    p.cracks = 0;
    for (std::int32_t n = p.first_crack; n < p.end_crack; ++n)
      if (cracks_[n].opens <= t) p.cracks += cracks_[n].resistance;
  }
}

SeriesPairs::Flux SeriesPairs::flux(const Pair& p, const Conductivity& at, double T_a, double T_b, double R) const {
  Flux f{};
  const Conductivity& k = *at.ends;
  if (p.one_part) {
    const std::int32_t a = pieces_[p.first].end, b = pieces_[p.first + 1].end;
    f.K = mean_conductivity(k.mean, k.k[a], k.k[b]).value * (0.5 / pieces_[p.first].fraction);
  } else {
    double r = 0;
    for (std::int32_t n = p.first; n < p.end; ++n) r += pieces_[n].fraction / k.k[pieces_[n].end];
    f.K = 1 / r;
  }
  f.intact = f.K * (T_b - T_a);
  f.share = 1 / (1 + f.K * R);
  f.value = f.intact * f.share;
  return f;
}

void SeriesPairs::add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const {
  const Resistances r = resistances(k, T, false);
  for (std::size_t n = 0; n < pairs_.size(); ++n) {
    const Pair& p = pairs_[n];
    const double flow = p.G * flux(p, k, T[p.a], T[p.b], r.R[n]).value;
    if (p.a < cloud_->owned) F[p.a] += flow;
    if (p.b < cloud_->owned) F[p.b] -= flow;
  }
}

SeriesPairs::Derivatives SeriesPairs::derivatives(const Pair& p, const Conductivity& at, const Flux& f,
                                                  double jump) const {
  const Conductivity& ends = *at.ends;
  double by_a = -f.K, by_b = f.K;  // of the intact flux
  if (!ends.dk_dT.empty()) {
    for (std::int32_t m = p.first; m < p.end; ++m) {
      const std::int32_t e = pieces_[m].end;
      (ends_.phi.column[e] == p.a ? by_a : by_b) += dK_dk(p, m, f.K, ends) * ends.dk_dT[e] * jump;
    }
  }
  // d[K dT / (1 + K R)] = (d[K dT] - K d[dT]) / (1 + K R)^2 + K d[dT] / (1 + K R).
  return {.by_a = f.share * (f.share * (by_a + f.K) - f.K), .by_b = f.share * (f.share * (by_b - f.K) + f.K)};
}

double SeriesPairs::dK_dk(const Pair& p, std::int32_t piece, double K, const Conductivity& ends) const {
  const double fraction = pieces_[piece].fraction, k = ends.k[pieces_[piece].end];
  if (p.one_part && ends.mean != Mean::harmonic) return 0.25 / fraction;
  return k > 0 ? K * K * fraction / (k * k) : 0;
}

void SeriesPairs::add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const {
  if (pairs_.empty()) return;
  const Resistances r = resistances(k, T, true);
  for (std::size_t n = 0; n < pairs_.size(); ++n) {
    const Pair& p = pairs_[n];
    const Flux f = flux(p, k, T[p.a], T[p.b], r.R[n]);
    const auto slopes = std::span(r.slope).subspan(p.first_contact, p.end_contact - p.first_contact);
    const bool by_faces = std::ranges::any_of(slopes, [](double slope) { return slope != 0; });
    const auto [by_a, by_b] = by_faces ? derivatives_by_faces(p, k, f, r) : derivatives(p, k, f, T[p.b] - T[p.a]);
    const std::int32_t columns[] = {p.a, p.b};
    const double into_a[] = {p.G * by_a, p.G * by_b}, into_b[] = {-p.G * by_a, -p.G * by_b};
    if (p.a < cloud_->owned) J.add(p.a, columns, into_a);
    if (p.b < cloud_->owned) J.add(p.b, columns, into_b);
  }
}

void SeriesPairs::add_row_sums(const Conductivity& k, std::span<double> sums) const {
  // Contacts that change are left out: without them the sums are larger.
  for (const Pair& p : pairs_) {
    const Flux f = flux(p, k, 0, 0, p.contacts + p.cracks);
    const double sum = 2 * std::abs(p.G) * f.K * f.share;
    if (p.a < cloud_->owned) sums[p.a] += sum;
    if (p.b < cloud_->owned) sums[p.b] += sum;
  }
}

void SeriesPairs::add_moments(const Conductivity& k, std::span<const double> T, std::span<Symmetric3> M,
                              std::span<Vec3> b) const {
  const Resistances r = resistances(k, T, false);
  for (std::size_t n = 0; n < pairs_.size(); ++n) {
    const Pair& p = pairs_[n];
    const Vec3 x = cloud_->x[p.b] - cloud_->x[p.a];
    const double flow = p.G * flux(p, k, T[p.a], T[p.b], r.R[n]).value;
    if (p.a < cloud_->owned) M[p.a].add(p.G, x), b[p.a] += flow * x;
    if (p.b < cloud_->owned) M[p.b].add(p.G, x), b[p.b] += flow * x;
  }
}

}  // namespace calor
