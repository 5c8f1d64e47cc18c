#include "conduction/correction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "conduction/fingerprint.hpp"

namespace calor {

namespace {

constexpr double exactly = 1e-12;
constexpr double floor_of_clip = 0.02;
constexpr double round_off = 1e-9;

/// Faces with facets that have no images beyond them.
std::uint32_t truncated_faces(const Cloud& cloud, const Neighbours& neighbours) {
  if (neighbours.mirrors.empty()) return ~0u;
  std::uint32_t faces = 0;
  for (std::size_t p = 0; p < cloud.facets.size(); ++p)
    if (!neighbours.mirrored[p]) faces |= 1u << cloud.facets[p].face;
  return any_bit(cloud.comm, faces);
}

/// 2^-n for a pair that lies in n faces together.
double share_of_pair(std::uint32_t shared_faces) {
  return 1.0 / static_cast<double>(std::uint64_t{1} << std::popcount(shared_faces));
}

/// A pair along a wall would meet its mirror image there: both share the wall's other side, so n common faces leave it
/// 2^-n of its weight. The scaling and the fit start nearer to their goal.
void share_with_mirror_images(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g) {
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
      g[n] *= share_of_pair(cloud.on_faces[i] & cloud.on_faces[neighbours.column[n]]);
}

/// Volumes whose traces the scaling aims at. A point off the walls lacks the part of its second moment that its
/// boundary facets carry: V - 1/D integral of (x - x_i).n dS, the facets half a spacing away.
std::vector<double> volumes_to_scale(const Cloud& cloud, const Neighbours& neighbours) {
  std::vector<double> volume(cloud.volume.begin(), cloud.volume.begin() + cloud.owned);
  for (int i = 0; cloud.axisymmetric && i < cloud.owned; ++i) volume[i] += cloud.moment[i].x / cloud.dimension;
  if (cloud.points_on_walls) return volume;
  for (std::size_t p = 0; p < cloud.facets.size(); ++p) {
    const Facet& facet = cloud.facets[p];
    if (!neighbours.mirrored.empty() && neighbours.mirrored[p]) continue;
    const double across = spacing_along(cloud.metric[facet.point], facet.normal);
    volume[facet.point] -= facet.area * 0.5 * across / cloud.dimension;
  }
  for (int i = 0; i < cloud.owned; ++i) volume[i] = std::max(volume[i], 0.1 * cloud.volume[i]);
  return volume;
}

void count_negative(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G,
                    CorrectionReport& report) {
  std::vector<double> size(cloud.owned);
  std::int64_t negative = 0;
  double smallest = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      size[i] += std::abs(G[n]);
      smallest = std::min(smallest, G[n]);
      negative += G[n] < 0;
    }
  }
  report.negative = total(cloud.comm, negative);
  smallest = min(cloud.comm, smallest);
  report.most_negative = report.negative > 0 ? smallest * static_cast<double>(report.pairs) / sum(cloud.comm, size) : 0;
}

/// How far the weights are from those that conduct alike in all directions and keep temperatures within their data.
void measure(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G, CorrectionReport& report) {
  std::vector<double> below(cloud.owned), all(cloud.owned), squares(3 * static_cast<std::size_t>(cloud.owned));
  std::int64_t inside = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    // Off the walls, the facets of the wall cells carry a part of (M).
    bool near_wall = cloud.on_faces[i] != 0 || (cloud.axisymmetric && cloud.x[i].x == 0);
    Vec3 moment;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 r = neighbours.x_ji(cloud.x, i, n);
      moment += G[n] * product(r, r);
      all[i] += std::abs(G[n]) * dot(r, r);
      if (G[n] < 0) below[i] -= G[n] * dot(r, r);
      near_wall = near_wall || (!cloud.points_on_walls && cloud.on_faces[neighbours.column[n]] != 0);
    }
    if (near_wall) continue;
    ++inside;
    if (cloud.axisymmetric) moment.x -= 2 * cloud.moment[i].x;
    for (int a = 0; a < cloud.dimension; ++a) squares[3 * i + a] = std::pow(moment[a] / (2 * cloud.volume[i]) - 1, 2);
  }
  report.negative_share = sum(cloud.comm, below) / sum(cloud.comm, all);
  const auto axes = sums(cloud.comm, squares, 3);
  inside = total(cloud.comm, inside);
  if (inside > 0) report.moment_error = std::sqrt(std::max({axes[0], axes[1], axes[2]}) / static_cast<double>(inside));
}

/// What the rounding of the coordinates may leave of a residual: far from the origin, much.
double rounding_of_places(const Cloud& cloud) {
  double farthest = 0, least = std::numeric_limits<double>::max();
  for (int i = 0; i < cloud.owned; ++i) {
    farthest = std::max(farthest, norm(cloud.x[i]));
    for (int a = 0; a < cloud.dimension; ++a) least = std::min(least, cloud.metric[i][a]);
  }
  constexpr double few = 16;  // of the pairs of a point
  return few * std::numeric_limits<double>::epsilon() * max(cloud.comm, farthest) / min(cloud.comm, least);
}

/// Weights and what the report says of them, from the cloud's cache or by `correct`; `from`: all that they follow from.
void keep_weights(const Cloud& cloud, const Fingerprint& from, std::vector<double>& g, CorrectionReport& report,
                  const std::function<void()>& correct) {
  const auto entries =
      std::tie(report.moment_iterations, report.lambda_solves, report.lambda_iterations, report.residual, report.change,
               report.negative, report.most_negative, report.negative_share, report.moment_error);
  std::vector<double> numbers;
  cloud.cache->get(cloud.comm, "weights", Cache::Owner::rank, from, {&g, &numbers}, [&] {
    correct();
    std::apply([&](const auto&... entry) { numbers = {static_cast<double>(entry)...}; }, entries);
  });
  auto number = numbers.begin();
  const auto take = [&]<class Number>(Number& entry) { entry = static_cast<Number>(*number++); };
  std::apply([&](auto&... entry) { (take(entry), ...); }, entries);
}

}  // namespace

Vec3 face_size(const Cloud& cloud, int i) {
  Vec3 face;
  for (int a = 0; a < cloud.dimension; ++a) {
    face[a] = cloud.section(i);
    for (int b = 0; b < cloud.dimension; ++b)
      if (b != a) face[a] *= cloud.metric[i][b];
  }
  return face;
}

double square_in_spacings(const Cloud& cloud, const Neighbours& neighbours, int i, std::int64_t n) {
  const Vec3 xi = quotient(neighbours.x_ji(cloud.x, i, n), cloud.mean_metric(i, neighbours.column[n]));
  return dot(xi, xi);
}

double cell_size(const Cloud& cloud, int i, int j) {
  const Vec3 s = cloud.mean_metric(i, j);
  return cloud.dimension == 1 ? s.x : cloud.dimension == 2 ? s.x * s.y : s.x * s.y * s.z;
}

double largest_residual(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G) {
  const auto R = linear_residual(cloud, neighbours, G);
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 face = face_size(cloud, i);
    Vec3 off;
    for (int a = 0; a < cloud.dimension; ++a) off[a] = R[i][a] / face[a];
    largest = std::max(largest, norm(off));
  }
  return max(cloud.comm, largest);
}

void add_to_report(const CorrectionReport& done, std::map<std::string, double>& report) {
  report["lattice_shortcut"] = done.lattice_shortcut;
  report["moment_iterations"] = done.moment_iterations;
  report["lambda_solves"] = done.lambda_solves;
  report["lambda_iterations"] = done.lambda_iterations;
  report["weight_residual"] = done.residual;
  report["weight_change"] = done.change;
  report["negative_weights"] = static_cast<double>(done.negative);
  report["most_negative_weight"] = done.most_negative;
  report["negative_share"] = done.negative_share;
  report["moment_error"] = done.moment_error;
}

void require_sound(const Cloud& cloud, const CorrectionReport& done, bool anisotropic) {
  // On jittered lattices (displaced by 0.1, 0.2 and 0.4 spacings, of one spacing to ten to one) errors stay below a
  // tenth of the span up to a moment error of 0.33, and temperatures leave the range of their data from 0.35 on. A few
  // cubes an edge are off as much in their corners, but need no such change of weights: below 4, against 19 and more.
  // Where no weight is negative temperatures stay within their data, and a body of few points is served as well as it
  // can be.
  constexpr double largest_moment_error = 0.3, largest_change = 10, largest_negative_share = 0.1;
  const bool unlike = done.moment_error > largest_moment_error && done.change > largest_change && done.negative > 0;
  if (!unlike && done.negative_share <= largest_negative_share) return;
  const std::string moments = fmt::format(
      "along an axis they conduct {:.2g} of the conductivity more or less, as a root mean square over the points (at "
      "most {:g} is taken)",
      done.moment_error, largest_moment_error);
  const std::string negative =
      fmt::format("a share of {:.2g} of them is negative (at most {:g})", done.negative_share, largest_negative_share);
  const bool many_negative = done.negative_share > largest_negative_share;
  throw Error(
      Fault::bad_case,
      fmt::format("no good weights of pairs for this cloud: {}{}{}", unlike ? moments : "",
                  unlike && many_negative ? ", and " : "", many_negative ? negative : ""),
      anisotropic ? cure_of_anisotropy
      : cloud.body
          ? "take a smaller spacing, so that thin walls hold three points and more; method = \"mlpg\" needs no "
            "such weights in a body of one part without cracks"
          : "use points that lie in lines (no jitter) or spacings that are more alike; method = \"mlpg\" needs no such "
            "weights in a body of one part without cracks");
}

void enforce_with_positive_weights(const Cloud& cloud, const Neighbours& neighbours, std::vector<double>& g,
                                   CorrectionReport& report, int most) {
  int solves = 0;
  for (bool negative = true; negative && solves < most; ++solves) {
    const auto solve = enforce_linear_consistency(cloud, neighbours, g, exactly, solves + 1 < most ? floor_of_clip : 0);
    if (solves == 0) report.change = solve.change;
    report.lambda_iterations += solve.iterations;
    negative = solve.negative;
  }
  report.lambda_solves += solves;
  report.residual = largest_residual(cloud, neighbours, g);
  count_negative(cloud, neighbours, g, report);
}

std::vector<double> consistent_weights(const Cloud& cloud, const Neighbours& neighbours,
                                       const BaseWeights& base_weights, const LatticeWeight& lattice_weight,
                                       CorrectionReport& report, int solves) {
  report = {};
  report.pairs = total(cloud.comm, static_cast<std::int64_t>(neighbours.column.size()));

  if (is_even_lattice(cloud) && lattice_weight) {
    if (auto G = mirrored_lattice_weights(cloud, neighbours, lattice_weight, truncated_faces(cloud, neighbours))) {
      report.residual = largest_residual(cloud, neighbours, *G);
      report.lattice_shortcut = report.residual < 1e-10 + rounding_of_places(cloud);
      if (report.lattice_shortcut) return std::move(*G);
    }
  }

  std::vector<double> g;
  const auto fit = [&] {
    g = base_weights();
    if (cloud.points_on_walls) share_with_mirror_images(cloud, neighbours, g);
    scale_traces(cloud, neighbours, volumes_to_scale(cloud, neighbours), g);
    report.moment_iterations = fit_moments(cloud, neighbours, g);
  };
  const auto correct = [&] {
    fit();
    try {
      enforce_with_positive_weights(cloud, neighbours, g, report, solves);
    } catch (const Error& e) {  // all ranks throw alike
      if (e.fault() != Fault::numbers) throw;
      // At sharp edges and tips, where all neighbours lie in a narrow wedge, no positive weights may balance the area:
      // those that were lifted again and again hold nothing any more. The nearest to the fit have few negative ones,
      // which do no harm as long as the others make up for them.
      fit();
      enforce_with_positive_weights(cloud, neighbours, g, report, 1);
      if (lowest_eigenvalue(cloud, neighbours, g) < -round_off) throw;
    }
    measure(cloud, neighbours, g, report);
  };
  if (!cloud.cache) {
    correct();
    return g;
  }
  Fingerprint from = fingerprint(cloud, neighbours);
  from.add(solves).add(base_weights());
  keep_weights(cloud, from, g, report, correct);
  return g;
}

}  // namespace calor
