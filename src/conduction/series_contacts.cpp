// Contacts of pairs: how much of an interface each pair stands for, and its resistance.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "conduction/series_pairs.hpp"

namespace calor {
namespace {

Error negative_contact(const Function& h, double value, double t, double T) {
  std::string when;
  if (h.depends_on_temperature()) when += fmt::format(", T = {:.6g} K", T);
  if (h.depends_on_time()) when += fmt::format(", t = {:.6g} s", t);
  return {when.empty() ? Fault::bad_case : Fault::numbers, h.location(),
          fmt::format("a contact of {:.6g} W/(m^2 K){} is negative", value, when), "give 0 (no heat crosses) or more"};
}

}  // namespace

/// On a plane the weights across it add up to its area, sum G |x_ba . n| = A. On a curved interface they miss it by the
/// ratio of the spacing to the radius, as the pairs lie on one side of it: lengths are scaled, piece by piece.
/// Collective.
void SeriesPairs::fit_contacts_to_areas(const Parts& parts) {
  const std::span<const double> area = parts.curved_areas();
  std::vector<std::vector<double>> terms(area.size());
  for (const Contact& c : contacts_) {
    const Pair& p = pairs_[c.pair];
    const int owned = (p.a < cloud_->owned) + (p.b < cloud_->owned);  // the other rank has the pair, too
    if (c.piece >= 0) terms[c.piece].push_back(0.5 * owned * p.G * c.length);
  }
  std::vector<double> scale(area.size(), 1);
  for (std::size_t q = 0; q < area.size(); ++q) {
    const double counted = sum(cloud_->comm, terms[q]);
    if (area[q] > 0 && counted > 0) scale[q] = cloud_->cross_section * area[q] / counted;
  }
  for (Contact& c : contacts_)
    if (c.piece >= 0) c.length *= scale[c.piece];
}

/// Gives the pairs the resistances of contacts that do not change, and makes laws of the others.
void SeriesPairs::sort_contacts_into_laws() {
  std::vector<const Function*> laws;
  std::vector<int> of_temperature(pairs_.size());
  for (std::size_t n = 0; n < contacts_.size(); ++n) {
    Contact& c = contacts_[n];
    if (!c.h->depends_on_time() && !c.h->depends_on_temperature()) {
      const double h = (*c.h)(c.x);
      if (!(h >= 0)) throw negative_contact(*c.h, h, 0, 0);
      c.R = resistance_of(h, c.length);
      pairs_[c.pair].contacts += c.R;
      continue;
    }
    of_temperature[c.pair] += c.h->depends_on_temperature();
    const auto law = static_cast<std::size_t>(std::ranges::find(laws, c.h) - laws.begin());
    if (law == laws.size()) {
      laws.push_back(c.h);
      laws_.push_back({.h = RampedFunction(*c.h), .contact = {}, .x = {}});
    }
    laws_[law].contact.push_back(static_cast<std::int32_t>(n));
    laws_[law].x.push_back(c.x);
  }
  for (const Contact& c : contacts_) shares_pair_.push_back(of_temperature[c.pair] > 1);
}

void SeriesPairs::find_changes(const Parts& parts) {
  changes_.events = openings_;
  std::vector<const Function*> known;
  for (int p = 0; p < parts.count(); ++p)
    for (int q = 0; q < p; ++q) {
      const Function* h = parts.contact(q, p);
      if (!h || std::ranges::count(known, h)) continue;
      known.push_back(h);
      changes_.add(h->changes());
    }
}

SeriesPairs::Resistances SeriesPairs::resistances(const Conductivity& at, std::span<const double> T,
                                                  bool derivative) const {
  Resistances r{.R = {}, .of_contact = {}, .slope = std::vector<double>(derivative ? contacts_.size() : 0)};
  for (const Pair& p : pairs_) r.R.push_back(p.contacts + p.cracks);
  if (laws_.empty()) return r;
  for (const Contact& c : contacts_) r.of_contact.push_back(c.R);
  for (const Law& law : laws_)
    if (!law.h.function().depends_on_temperature()) follow_time(law, at.t, r.of_contact);
  // Contacts of temperature in one pair hang on each other, by its flux: in turn until none changes.
  constexpr int most_rounds = 50;
  constexpr double alike = 1e-14;
  std::vector<char> is_wanted(contacts_.size(), 1);
  for (int round = 0; round < most_rounds && std::ranges::count(is_wanted, 1) > 0; ++round) {
    const std::vector<double> before = r.of_contact;
    for (const Law& law : laws_)
      if (law.h.function().depends_on_temperature()) solve_faces(law, at, T, is_wanted, r, derivative);
    std::vector<char> changes(pairs_.size());
    for (std::size_t n = 0; n < contacts_.size(); ++n) {
      const double now = r.of_contact[n];
      if (now != before[n] && !(std::abs(now - before[n]) <= alike * now)) changes[contacts_[n].pair] = 1;
    }
    for (std::size_t n = 0; n < contacts_.size(); ++n) is_wanted[n] = shares_pair_[n] && changes[contacts_[n].pair];
  }
  for (const Law& law : laws_)
    for (const std::int32_t c : law.contact) r.R[contacts_[c].pair] += r.of_contact[c];
  return r;
}

void SeriesPairs::follow_time(const Law& law, double t, std::vector<double>& R) const {
  std::vector<double> h(law.x.size());
  law.h.evaluate({.x = law.x, .t = t}, h);
  for (std::size_t n = 0; n < h.size(); ++n) {
    if (!(h[n] >= 0)) throw negative_contact(law.h.function(), h[n], t, 0);
    R[law.contact[n]] = resistance_of(h[n], contacts_[law.contact[n]].length);
  }
}

SeriesPairs::Faces SeriesPairs::faces(const Contact& c, const Conductivity& at, std::span<const double> T,
                                      std::span<const double> R) const {
  const Pair& p = pairs_[c.pair];
  const double K = flux(p, at, T[p.a], T[p.b], 0).K;
  Faces f{.T_a = T[p.a], .jump = T[p.b] - T[p.a], .before = 0.5 * p.cracks, .others = 1 / K + p.cracks};
  if (p.one_part) {
    f.before += c.before > 0 ? 1 / K : 0;
  } else {
    for (std::int32_t m = p.first; m < p.first + c.before; ++m)
      f.before += pieces_[m].fraction / at.ends->k[pieces_[m].end];
  }
  for (std::int32_t n = p.first_contact; n < p.end_contact; ++n) {
    if (&contacts_[n] == &c) continue;
    f.others += R[n];
    if (&contacts_[n] < &c) f.before += R[n];
  }
  // Where no heat flows, the mean of both points counts.
  if (!std::isfinite(f.others)) f.before = f.others = 0;
  return f;
}

/// Of a pair's difference of temperature the part s lies across the contact, 1 / (1 + h(T) |x_ba . n| R_others), at the
/// mean of its faces T = T_a + jump (w + s (1/2 - w)), w = R_before / R_others. Regula falsi between 0 and 1 (Illinois:
/// Dowell & Jarratt, BIT 11, 1971), then by halves, for functions that jump.
void SeriesPairs::solve_faces(const Law& law, const Conductivity& at, std::span<const double> T,
                              std::span<const char> is_wanted, Resistances& r, bool derivative) const {
  struct Search {
    std::int32_t contact;
    Faces faces;
    double low = 0, high = 1, at_low = 0, at_high = 0, s = 1;
    int side = 0;  // that moved last

    double T() const {
      const double w = faces.others > 0 ? faces.before / faces.others : 0.5;
      return faces.T_a + faces.jump * (w + s * (0.5 - w));
    }
  };
  constexpr int most_steps = 80, by_halves = 25;
  constexpr double alike = 1e-14;
  std::vector<Search> open, done;
  for (const std::int32_t c : law.contact)
    if (is_wanted[c]) open.push_back({.contact = c, .faces = faces(contacts_[c], at, T, r.of_contact)});
  std::vector<double> h, mean;
  std::vector<Vec3> x;
  const auto place = [&](const std::vector<Search>& searches) {
    x.clear(), mean.clear();
    for (const Search& one : searches) x.push_back(contacts_[one.contact].x), mean.push_back(one.T());
    h.resize(x.size());
  };
  for (int step = 0; !open.empty(); ++step) {
    place(open);
    law.h.evaluate({.x = x, .t = at.t, .T = mean}, h);
    std::vector<Search> still_open;
    for (std::size_t n = 0; n < open.size(); ++n) {
      Search one = open[n];
      const double length = contacts_[one.contact].length;
      const double share = 1 / (1 + std::max(h[n], 0.0) * length * one.faces.others), miss = one.s - share;
      if (step == 0) one.at_low = -share, one.at_high = 1 - share;
      if (step > 0 && miss < 0) one.low = one.s, one.at_low = miss, one.at_high *= one.side < 0 ? 0.5 : 1;
      if (step > 0 && miss > 0) one.high = one.s, one.at_high = miss, one.at_low *= one.side > 0 ? 0.5 : 1;
      if (step > 0) one.side = miss < 0 ? -1 : 1;
      if (std::abs(miss) <= alike || one.high - one.low <= alike || one.faces.jump == 0 || step == most_steps) {
        if (!(h[n] >= 0)) throw negative_contact(law.h.function(), h[n], at.t, mean[n]);
        r.of_contact[one.contact] = resistance_of(h[n], length);
        done.push_back(one);
        continue;
      }
      one.s = step > by_halves ? 0.5 * (one.low + one.high)
                               : (one.low * one.at_high - one.high * one.at_low) / (one.at_high - one.at_low);
      still_open.push_back(one);
    }
    open = std::move(still_open);
  }
  if (!derivative) return;
  place(done);
  law.h.derivative({.x = x, .t = at.t, .T = mean}, h);
  for (std::size_t n = 0; n < done.size(); ++n) r.slope[done[n].contact] = h[n] * contacts_[done[n].contact].length;
}

/// Temperatures along the way change by of_a dT_a + of_b dT_b + of_flux df. At b that is dT_b, which gives df.
SeriesPairs::Derivatives SeriesPairs::derivatives_by_faces(const Pair& p, const Conductivity& at, const Flux& f,
                                                           const Resistances& r) const {
  if (f.share == 0 || f.K == 0) return {.by_a = 0, .by_b = 0};
  const Conductivity& ends = *at.ends;
  double of_a = 1, of_b = 0, of_flux = 0.5 * p.cracks;
  std::int32_t piece = p.first;
  const auto pass_to = [&](std::int32_t end) {
    if (p.one_part && piece < end) of_flux += 1 / f.K;
    for (; piece < end; ++piece) {
      const std::int32_t e = pieces_[piece].end;
      if (!p.one_part) of_flux += pieces_[piece].fraction / ends.k[e];
      if (ends.dk_dT.empty()) continue;
      // dr = -dK / K^2
      const double change = -f.value * dK_dk(p, piece, f.K, ends) / (f.K * f.K) * ends.dk_dT[e];
      (ends_.phi.column[e] == p.a ? of_a : of_b) += change;
    }
  };
  for (std::int32_t n = p.first_contact; n < p.end_contact; ++n) {
    pass_to(p.one_part ? (contacts_[n].before > 0 ? p.end : p.first) : p.first + contacts_[n].before);
    // The jump D: D g(T_- + D/2) = flux, g = h |x_ba . n|, so (g + D g'/2) dD = df - D g' dT_-.
    const double g = 1 / r.of_contact[n], by_D = f.value * r.of_contact[n] * r.slope[n], whole = g + 0.5 * by_D;
    const double rest = (g - 0.5 * by_D) / whole;
    of_a *= rest, of_b *= rest, of_flux = of_flux * rest + 1 / whole;
  }
  pass_to(p.end);
  of_flux += 0.5 * p.cracks;
  return {.by_a = -of_a / of_flux, .by_b = (1 - of_b) / of_flux};
}

}  // namespace calor
