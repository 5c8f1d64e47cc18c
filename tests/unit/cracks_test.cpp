#include "cloud/cracks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>

#include "base/parallel.hpp"
#include "conduction/correction.hpp"
#include "conduction/cracked_pairs.hpp"
#include "conduction/peridynamics.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

constexpr double not_fixed = std::numeric_limits<double>::quiet_NaN();

std::vector<double> ones(const Cloud& cloud) { return std::vector<double>(cloud.local(), 1); }

Crack line(const Vec3& a, const Vec3& b, double contact = 0, double opens = 0) {
  return {.vertices = {a, b}, .contact = contact, .opens = opens};
}

/// The square [-1, 1]^2 (a plate of it in 3D: `thick` points over its height) with n^2 points.
Cloud square(std::int64_t n, double jitter = 0, std::int64_t thick = 0, MPI_Comm comm = MPI_COMM_SELF) {
  const double d = 2.0 / static_cast<double>(n - 1);
  const BoxLattice box{.dimension = thick ? 3 : 2,
                       .size = {2, 2, d * static_cast<double>(std::max<std::int64_t>(thick - 1, 0))},
                       .points = {n, n, std::max<std::int64_t>(thick, 1)},
                       .origin = {-1, -1, 0},
                       .jitter = jitter};
  return distribute(comm, make_box(comm, box), Support{4});
}

struct Cracked {
  Neighbours neighbours;
  std::vector<double> G;  ///< of the intact body
  CorrectionReport report;
};

Cracked intact(const Cloud& cloud, double smoothing) {
  Cracked c;
  c.neighbours = find_neighbours(cloud, sph_support(smoothing));
  c.G = sph_consistent_weights(cloud, c.neighbours, smoothing, c.report);
  return c;
}

Cracked intact_by_bonds(const Cloud& cloud, double horizon) {
  const Peridynamics options{.n = 2, .horizon = horizon};
  Cracked c;
  c.neighbours = find_neighbours(cloud, options.support());
  c.G = consistent_weights(
      cloud, c.neighbours, [&] { return base_weights(cloud, c.neighbours, options); }, {}, c.report);
  return c;
}

PairConduction with_crack(const Cloud& cloud, std::vector<Crack> cracks, double smoothing,
                          CorrectionReport* report = {}) {
  Cracked c = intact(cloud, smoothing);
  PairConduction pairs =
      cracked_pairs(cloud, Parts(cloud), Cracks(cloud, std::move(cracks)), c.neighbours, c.G, ones(cloud), c.report);
  if (report) *report = c.report;
  return pairs;
}

/// Conductivity 1 everywhere.
struct Unit {
  explicit Unit(const Cloud& cloud, const PairConduction& pairs)
      : k(cloud.local(), 1.0),
        k_ends(pairs.ends() ? pairs.ends()->x.size() : 0, 1.0),
        ends{.mean = Mean::arithmetic, .k = k_ends, .dk_dT = {}, .theta = {}} {}
  Conductivity at() const { return {.mean = Mean::arithmetic, .k = k, .dk_dT = {}, .theta = {}, .ends = &ends}; }
  std::vector<double> k, k_ends;
  Conductivity ends;
};

std::vector<double> steady(const Cloud& cloud, const PairConduction& pairs, const std::vector<double>& fixed) {
  const std::vector<double> T(cloud.local(), 0.0);
  const Unit unit(cloud, pairs);
  SparseJacobian J;
  pairs.add_jacobian(unit.at(), T, J);
  return solve_with_fixed(J.matrix(cloud.owned), std::vector<double>(cloud.owned, 0.0), fixed);
}

constexpr double a = 0.5;
const Crack crack_of_the_plate = line({-a, 0, 0}, {a, 0, 0});

/// Im( sqrt(z - a) sqrt(z + a) ): conducts around the insulated crack |x| < a on y = 0 and jumps by 2a at its centre.
double exact_at(const Vec3& x) {
  const std::complex<double> z(x.x, x.y);
  return (std::sqrt(z - a) * std::sqrt(z + a)).imag();
}

struct PlateErrors {
  double rms;   ///< farther than 0.2 from the tips
  double jump;  ///< at the centre, by the points beside it
};

PlateErrors plate_errors(const Cloud& cloud, const PairConduction& pairs) {
  std::vector<double> fixed;
  for (int i = 0; i < cloud.owned; ++i)
    fixed.push_back((cloud.on_faces[i] & 0b1111) ? exact_at(cloud.x[i]) : not_fixed);
  const auto T = steady(cloud, pairs, fixed);
  double squares = 0, volume = 0, up = 0, down = 0, nearest_up = 9, nearest_down = 9;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 x{cloud.x[i].x, cloud.x[i].y, 0};
    const double error = T[i] - exact_at(x);
    if (std::min(norm(x - Vec3{a, 0, 0}), norm(x + Vec3{a, 0, 0})) > 0.2) {
      squares += cloud.volume[i] * error * error;
      volume += cloud.volume[i];
    }
    if (x.y > 0 && norm(x) < nearest_up) nearest_up = norm(x), up = error;
    if (x.y < 0 && norm(x) < nearest_down) nearest_down = norm(x), down = error;
  }
  return {std::sqrt(squares / volume), std::abs(up - down)};
}

TEST(Cracks, HoldUpTheHeatOfTheExactCrackInALattice) {
  const double rms[] = {3e-4, 1e-4, 3e-5}, jump[] = {6e-4, 1.5e-4, 8e-5};
  for (int n = 0; n < 3; ++n) {
    const Cloud cloud = square(20 << n);
    CorrectionReport report;
    const auto pairs = with_crack(cloud, {crack_of_the_plate}, 1, &report);
    const PlateErrors e = plate_errors(cloud, pairs);
    std::printf("lattice %d^2: rms %.2e, jump %.2e, %d negative\n", 20 << n, e.rms, e.jump, int(report.negative));
    EXPECT_LE(e.rms, rms[n]);
    EXPECT_LE(e.jump, jump[n]);
    EXPECT_LE(report.residual, 1e-11);
    EXPECT_EQ(report.negative, 0);
  }
}

TEST(Cracks, HoldUpTheHeatOfTheExactCrackHoweverFarThePairsReach) {
  const double rms[] = {1.2e-3, 4.5e-4}, jump[] = {3.5e-3, 1.2e-3};
  for (int n = 0; n < 2; ++n) {
    const Cloud cloud = square(20 << n);
    for (const bool bonds : {true, false}) {
      Cracked c = bonds ? intact_by_bonds(cloud, 2) : intact(cloud, 1.4);
      const auto pairs = cracked_pairs(cloud, Parts(cloud), Cracks(cloud, {crack_of_the_plate}), c.neighbours, c.G,
                                       ones(cloud), c.report);
      const PlateErrors e = plate_errors(cloud, pairs);
      std::printf("%s %d^2: rms %.2e, jump %.2e\n", bonds ? "bonds" : "h = 1.4 dx", 20 << n, e.rms, e.jump);
      EXPECT_LE(e.rms, rms[n]);
      EXPECT_LE(e.jump, jump[n]);
    }
  }
}

TEST(Cracks, HoldUpHeatAskewInALattice) {
  for (const double angle : {0.15, 0.35, 0.6}) {
    Cloud cloud = square(40);
    const double c = std::cos(angle), s = std::sin(angle);
    for (Vec3& v : cloud.x) v = {c * v.x - s * v.y, s * v.x + c * v.y, 0};
    for (Vec3& v : cloud.area) v = {c * v.x - s * v.y, s * v.x + c * v.y, 0};
    const PlateErrors e = plate_errors(cloud, with_crack(cloud, {crack_of_the_plate}, 1.2));
    std::printf("turned by %.3f: rms %.2e, jump %.2e\n", angle, e.rms, e.jump);
    EXPECT_LE(e.rms, 1.5e-3);
    EXPECT_LE(e.jump, 8e-3);
  }
}

TEST(Cracks, LetHeatRunBesideThemAsInTheRestOfTheBody) {
  // cos(2x) cosh(2y) does not know of a cut at y = 0, so a cut body must be as good as a whole one. What the cut pairs
  // carried along the faces matters: without it the error is of first order, 9e-4 and 6e-4 here.
  const Cloud cloud = square(40);
  std::vector<double> exact, fixed;
  for (int i = 0; i < cloud.owned; ++i) {
    exact.push_back(std::cos(2 * cloud.x[i].x) * std::cosh(2 * cloud.x[i].y) / 2);
    fixed.push_back(cloud.on_faces[i] ? exact[i] : not_fixed);
  }
  const auto rms = [&](const PairConduction& pairs) {
    const auto T = steady(cloud, pairs, fixed);
    double squares = 0;
    for (int i = 0; i < cloud.owned; ++i) squares += cloud.volume[i] * (T[i] - exact[i]) * (T[i] - exact[i]);
    return std::sqrt(squares / 4);
  };
  for (const bool bonds : {true, false}) {
    Cracked c = bonds ? intact_by_bonds(cloud, 2) : intact(cloud, 1);
    const double whole = rms(PairConduction(cloud, c.neighbours, c.G));
    const Cracks cut(cloud, {line({-1, 0, 0}, {1, 0, 0})});
    const double cracked = rms(cracked_pairs(cloud, Parts(cloud), cut, c.neighbours, c.G, ones(cloud), c.report));
    std::printf("%s: whole %.2e, cut %.2e\n", bonds ? "bonds" : "h = dx", whole, cracked);
    EXPECT_LE(cracked, 2.5 * whole);
  }
}

TEST(Cracks, CutASquareIntoHalvesOfSecondOrderWhereverTheyLieBetweenItsRows) {
  // Two temperatures that conduct with the cut insulated, another one on each side of it: through a row of points,
  // beside one and between two.
  for (const double off : {0.0, 0.04, -0.4, -0.5, 1.0}) {  // half spacings from a row
    for (const double smoothing : {1.0, 1.2, 0.0}) {       // of SPH, of MLPG, and bonds
      double rms[3];
      for (int n = 0; n < 3; ++n) {
        Cloud cloud = square(10 * (1 << n) + 1);
        const double y = off / (10 << n);
        const Cracks cut(cloud, {line({-1, y, 0}, {1, y, 0})});
        end_cells_at_cracks(cloud, cut);
        std::optional<Cloud> copy;
        const Cloud& whole = without_cracks(cloud, copy);
        Cracked c = smoothing > 0 ? intact(whole, smoothing) : intact_by_bonds(whole, 2);
        const auto pairs = cracked_pairs(cloud, Parts(cloud), cut, c.neighbours, c.G, ones(cloud), c.report);
        std::vector<double> exact, fixed;
        for (int i = 0; i < cloud.owned; ++i) {
          const Vec3& x = cut.location(i);
          exact.push_back((x.y > y ? 1 : -0.5) * std::cos(x.x) * std::cosh(cloud.x[i].y - y));
          fixed.push_back(cloud.on_faces[i] ? exact[i] : not_fixed);
        }
        const auto T = steady(cloud, pairs, fixed);
        double squares = 0;
        for (int i = 0; i < cloud.owned; ++i) squares += cloud.volume[i] * (T[i] - exact[i]) * (T[i] - exact[i]);
        rms[n] = std::sqrt(squares / 4);
      }
      std::printf("%.2f spacings off, %g: rms %.2e %.2e %.2e\n", off / 2, smoothing, rms[0], rms[1], rms[2]);
      EXPECT_LE(rms[0], 1.5e-3) << off << " " << smoothing;
      EXPECT_GE(std::log2(rms[0] / rms[2]) / 2, 1.6) << off << " " << smoothing;
    }
  }
}

TEST(Cracks, HoldUpHeatWhereverTheirTipsLie) {
  // The tips move over a whole spacing; a crack too long or too short by a hundredth of one is off by 1e-3 in the jump,
  // one rounded to the pairs that it cuts by up to 5e-2.
  const Cloud cloud = square(40);
  for (const double shift : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    Cloud moved = cloud;
    for (Vec3& x : moved.x) x.x += shift * 2 / 39;
    const auto pairs = with_crack(moved, {crack_of_the_plate}, 1);
    const PlateErrors e = plate_errors(moved, pairs);
    std::printf("shift %.1f: rms %.2e, jump %.2e\n", shift, e.rms, e.jump);
    EXPECT_LE(e.rms, 2e-4);
    EXPECT_LE(e.jump, 1e-3);
  }
}

TEST(Cracks, HoldUpHeatInJitteredClouds) {
  const double rms[] = {4e-3, 2e-3}, jump[] = {2e-2, 8e-3};
  for (int n = 0; n < 2; ++n) {
    const Cloud cloud = square(20 << n, 0.2);
    const PlateErrors e = plate_errors(cloud, with_crack(cloud, {crack_of_the_plate}, 1.2));
    std::printf("jittered %d^2: rms %.2e, jump %.2e\n", 20 << n, e.rms, e.jump);
    EXPECT_LE(e.rms, rms[n]);
    EXPECT_LE(e.jump, jump[n]);
  }
}

TEST(Cracks, WouldHealWithoutTheAreasOfTheirFaces) {
  // The cut pairs' load would go to their neighbours: linear fields stay exact, and the crack is gone.
  const Cloud cloud = square(20);
  Cracked c = intact(cloud, 1);
  const Cracks cracks(cloud, {crack_of_the_plate});
  for (const Crossing& x : cracks.crossings(c.neighbours)) c.G[x.entry] *= 1 - x.fraction;
  enforce_linear_consistency(cloud, c.neighbours, c.G, 1e-12);
  const auto R = linear_residual(cloud, c.neighbours, c.G);
  for (const Vec3& r : R) EXPECT_LE(norm(r), 1e-12);
  EXPECT_GE(plate_errors(cloud, PairConduction(cloud, c.neighbours, c.G)).jump, 0.7);
}

TEST(Cracks, ThatCutRightThroughIsolateToRoundOff) {
  // Along and across a lattice, and askew through a jittered cloud, ends on the surface or beyond.
  struct Cut {
    double jitter, smoothing;
    std::vector<Vec3> line;
  };
  for (const Cut& cut : {Cut{0, 1, {{-1, 0.02, 0}, {1, 0.02, 0}}}, Cut{0.2, 1.2, {{-1.5, -0.71, 0}, {1.2, 0.53, 0}}},
                         Cut{0.2, 1.2, {{-1, -0.4, 0}, {0.05, 0.1, 0}, {0.31, 1, 0}}}}) {
    const Cloud cloud = square(20, cut.jitter);
    CorrectionReport report;
    const auto pairs = with_crack(cloud, {{.vertices = cut.line}}, cut.smoothing, &report);
    EXPECT_LE(report.residual, 1e-11);
    // Everything that the first point can reach is on its side, and no heat leaves it.
    std::vector<char> reached(cloud.owned, 0);
    std::vector<int> next = {0};
    std::vector<std::int32_t> buffer;
    reached[0] = 1;
    while (!next.empty()) {
      const int i = next.back();
      next.pop_back();
      for (int j : pairs.coupled(i, buffer))
        if (!reached[j]) reached[j] = 1, next.push_back(j);
    }
    const auto count = std::ranges::count(reached, 1);
    EXPECT_GT(count, cloud.owned / 5);
    EXPECT_LT(count, 4 * cloud.owned / 5);
    std::vector<double> T, F(cloud.owned, 0.0);
    for (int i = 0; i < cloud.local(); ++i) T.push_back(std::sin(17.0 * i));
    pairs.add_rate(Unit(cloud, pairs).at(), T, F);
    double sum = 0, size = 0;
    for (int i = 0; i < cloud.owned; ++i)
      if (reached[i]) sum += F[i], size += std::abs(F[i]);
    EXPECT_LE(std::abs(sum), 1e-14 * size);
    // A linear temperature along the cut stays one: heat runs beside the crack as if it were not there. Askew the area
    // vectors of the walls do not end where the cut does, and the balance of the parts tilts those of its faces.
    if (cut.line.size() > 2) continue;
    const double tolerance = cut.jitter == 0 ? 1e-11 : 5e-3;
    const Vec3 along = cut.line[1] - cut.line[0];
    std::vector<double> exact, fixed;
    for (int i = 0; i < cloud.owned; ++i) {
      exact.push_back(dot(along, cloud.x[i]));
      fixed.push_back(cloud.on_faces[i] ? exact[i] : not_fixed);
    }
    const auto solved = steady(cloud, pairs, fixed);
    for (int i = 0; i < cloud.owned; ++i) EXPECT_NEAR(solved[i], exact[i], tolerance);
  }
}

TEST(Cracks, InContactLetTheTemperatureJumpByTheFluxOverTheConductance) {
  // Two slabs, 1 K/m in each (k = 1) and a jump of q / h = 0.4 K at the interface; askew too, and in the means of k.
  for (const double slope : {0.0, 0.3}) {
    const Cloud cloud = square(15, slope == 0 ? 0 : 0.2);
    const double h = 2.5;
    const auto interface = line({-1, -slope + 0.03, 0}, {1, slope + 0.03, 0}, h);
    const auto pairs = with_crack(cloud, {interface}, 1.2);
    const Vec3 normal = (1 / std::hypot(slope, 1.0)) * Vec3{-slope, 1, 0};
    std::vector<double> exact, fixed;
    for (int i = 0; i < cloud.owned; ++i) {
      const double s = dot(cloud.x[i] - Vec3{0, 0.03, 0}, normal);
      exact.push_back(s + (s > 0 ? 1 / h : 0));
      fixed.push_back(cloud.on_faces[i] ? exact[i] : not_fixed);
    }
    const auto T = steady(cloud, pairs, fixed);
    for (int i = 0; i < cloud.owned; ++i) EXPECT_NEAR(T[i], exact[i], 1e-11);
    // The flux across it is the same everywhere.
    std::vector<Vec3> q(cloud.owned);
    std::vector<int> all(cloud.owned);
    std::iota(all.begin(), all.end(), 0);
    pairs.heat_flux(Unit(cloud, pairs).at(), T, all, q);
    for (const Vec3& v : q) EXPECT_NEAR(norm(v + normal), 0, 1e-10);
    // Its Jacobian is the derivative of its rate.
    SparseJacobian J;
    pairs.add_jacobian(Unit(cloud, pairs).at(), T, J);
    const Eigen::VectorXd F = J.matrix(cloud.owned) * Eigen::Map<const Eigen::VectorXd>(T.data(), cloud.owned);
    std::vector<double> rate(cloud.owned, 0.0);
    pairs.add_rate(Unit(cloud, pairs).at(), T, rate);
    for (int i = 0; i < cloud.owned; ++i) EXPECT_NEAR(F[i], rate[i], 1e-12);
  }
}

TEST(Cracks, LeaveTheBodyWholeUntilTheyOpen) {
  const Cloud cloud = square(10);
  const Cracked c = intact(cloud, 1);
  Crack crack = crack_of_the_plate;
  crack.opens = 2;
  PairConduction pairs = cracked_pairs(cloud, Parts(cloud), Cracks(cloud, {crack}), c.neighbours, c.G, ones(cloud),
                                       const_cast<Cracked&>(c).report);
  std::vector<double> T(cloud.local()), F_whole(cloud.owned), F_closed(cloud.owned), F_open(cloud.owned);
  for (int i = 0; i < cloud.local(); ++i) T[i] = std::sin(17.0 * i);
  const PairConduction whole(cloud, c.neighbours, c.G);
  whole.add_rate(Unit(cloud, whole).at(), T, F_whole);
  EXPECT_EQ(pairs.changes().events, std::vector<double>{2});
  pairs.apply(1.9);
  pairs.add_rate(Unit(cloud, pairs).at(), T, F_closed);
  for (int i = 0; i < cloud.owned; ++i) EXPECT_NEAR(F_closed[i], F_whole[i], 1e-13);
  pairs.apply(2);
  pairs.add_rate(Unit(cloud, pairs).at(), T, F_open);
  const Cracks cracks(cloud, {crack});
  std::vector<double> expected = c.G;
  for (const Crossing& x : cracks.crossings(c.neighbours)) expected[x.entry] -= x.fraction * c.G[x.entry];
  EXPECT_NE(expected, c.G);
  const PairConduction cut(cloud, c.neighbours, expected);
  std::vector<double> F_cut(cloud.owned);
  cut.add_rate(Unit(cloud, cut).at(), T, F_cut);
  for (int i = 0; i < cloud.owned; ++i) EXPECT_NEAR(F_open[i], F_cut[i], 1e-13);
  // First order, and far from whole: the jump is there.
  EXPECT_LE(plate_errors(cloud, pairs).jump, 0.3);
}

TEST(Cracks, TakePointsOnThemToTheirUpperSideAndAlongTheSurfaceIntoTheBody) {
  const Cloud cloud = square(21);  // a row on y = 0
  const Cracks cracks(cloud, {crack_of_the_plate});
  EXPECT_EQ(cracks.moved(), 11);  // x = -0.5, -0.4, ..., 0.5
  for (int i = 0; i < cloud.owned; ++i) {
    if (std::abs(cloud.x[i].y) < 1e-12 && std::abs(cloud.x[i].x) < 0.45) {
      EXPECT_NEAR(cracks.location(i).y, 1e-3 * cloud.spacing[i], 1e-12);
    } else if (std::abs(cloud.x[i].y) > 1e-12) {
      EXPECT_EQ(cracks.location(i), cloud.x[i]);
    }
  }
  for (const Crack& along : {line({-1, 1, 0}, {1, 1, 0}), line({1, 1, 0}, {-1, 1, 0})}) {
    const Cracks beside(cloud, {along});
    EXPECT_EQ(beside.moved(), 21);
    for (int i = 0; i < cloud.owned; ++i)
      EXPECT_LE(beside.location(i).y, 1 - 0.9e-3 * cloud.spacing[i] * (cloud.x[i].y == 1));
  }
  const PlateErrors e = plate_errors(cloud, with_crack(cloud, {crack_of_the_plate}, 1));
  std::printf("row on the crack: rms %.2e\n", e.rms);
  EXPECT_LE(e.rms, 4e-3);
}

TEST(Cracks, ArePolygonsInThreeDimensions) {
  // The same plate with a height, the crack through all of it.
  const Cloud cloud = square(20, 0, 4);
  const double top = 3 * 2.0 / 19;
  const Crack wall{.vertices = {{-a, 0, 0}, {a, 0, 0}, {a, 0, top}, {-a, 0, top}}};
  CorrectionReport report;
  const auto pairs = with_crack(cloud, {wall}, 1, &report);
  EXPECT_LE(report.residual, 1e-11);
  const PlateErrors e = plate_errors(cloud, pairs);
  std::printf("3D: rms %.2e, jump %.2e\n", e.rms, e.jump);
  EXPECT_LE(e.rms, 3e-4);
  EXPECT_LE(e.jump, 1.5e-3);
}

TEST(Cracks, KeepTheirTipsHoweverFarTheyReachOutOfTheBody) {
  const Cloud cloud = square(20, 0, 4);
  const Crack wall{.vertices = {{-a, 0, -5}, {a, 0, -5}, {a, 0, 1}, {-a, 0, 1}}};
  const PlateErrors e = plate_errors(cloud, with_crack(cloud, {wall}, 1));
  EXPECT_LE(e.rms, 3e-4);
  EXPECT_LE(e.jump, 1.5e-3);
}

TEST(Cracks, OfSeveralPiecesAreAsTightAsOne) {
  const Cloud cloud = square(20, 0.2);
  const Cracked c = intact(cloud, 1.2);
  const Cracks whole(cloud, {crack_of_the_plate});
  const Cracks polyline(cloud, {{.vertices = {{-a, 0, 0}, {-0.1, 0, 0}, {0.2, 0, 0}, {a, 0, 0}}}});
  const Cracks two(cloud, {line({-a, 0, 0}, {0.13, 0, 0}), line({0.13, 0, 0}, {a, 0, 0})});
  std::vector<double> left(c.G.size(), 1), left_polyline = left, left_two = left;
  for (const Crossing& x : whole.crossings(c.neighbours)) left[x.entry] -= x.fraction;
  for (const Crossing& x : polyline.crossings(c.neighbours)) left_polyline[x.entry] -= x.fraction;
  for (const Crossing& x : two.crossings(c.neighbours)) left_two[x.entry] -= x.fraction;
  for (std::size_t n = 0; n < left.size(); ++n) {
    EXPECT_NEAR(left_polyline[n], left[n], 1e-12);
    EXPECT_NEAR(left_two[n], left[n], 1e-12);
  }
}

TEST(CracksParallel, AreTheSameOnAnyNumberOfRanks) {
  for (const double jitter : {0.0, 0.2}) {
    const double smoothing = jitter > 0 ? 1.2 : 1;
    const std::vector<Crack> cracks = {line({-0.4, -0.3, 0}, {0.5, 0.2, 0}), line({-1, 0.52, 0}, {1, 0.61, 0}),
                                       line({-0.5, -1, 0}, {-0.45, -0.5, 0}, 3)};
    const auto checksum = [&](MPI_Comm comm) {
      const Cloud cloud = square(21, jitter, 0, comm);
      const auto pairs = with_crack(cloud, cracks, smoothing);
      std::vector<double> terms;
      PairRows::Row row;
      for (int i = 0; i < cloud.owned; ++i) {
        pairs.rows().read(i, row);
        for (std::size_t n = 0; n < row.column.size(); ++n)
          terms.push_back(row.weight[n] * (1 + std::fmod(0.618 * cloud.id[i] + 0.414 * cloud.id[row.column[n]], 1.0)));
      }
      return sum(comm, terms);
    };
    EXPECT_EQ(checksum(MPI_COMM_WORLD), checksum(MPI_COMM_SELF));
  }
}

}  // namespace
}  // namespace calor
