#pragma once
// The stage that turns the base weights of any pair method into weights that conserve heat, reproduce linear fields to
// round-off on any cloud and converge with second order.
//
// Think of the pairs as the bars of a truss with forces G_ij x_ji, x_ji = x_j - x_i: it carries the stress
// sigma = 1/2 sum_ij G_ij x_ji (x) x_ji on the segments ij, and heat is conducted with the tensor sigma instead of I.
//   sum_j G_ij x_ji = -A_i                     (L)  div sigma = 0 with the tractions of sigma = I on the surface:
//                                                   linear temperatures and their wall fluxes are exact
//   sum_j G_ij x_ji (x) x_ji = 2 V_i I         (M)  no self-equilibrated stress: without it a layer along the walls has
//                                                   sigma - I = O(1), and the scheme is of first order only
// (M), for points on the walls, cannot hold everywhere at once: it is fitted; (L) is then enforced to round-off. What
// (L) leaves open are rigid motions of the truss, so the areas must satisfy sum A = 0 and sum x cross A = 0.
//
// In the plane (x = r, y = z) of an axisymmetric body the stress is r I, whose divergence is e_r: with the hoop term
// S_i = integral of dV / r and m_i = integral of (x - x_i) dV / r over the cell
//   sum_j G_ij x_ji = -A_i + S_i e_r           sum_j G_ij x_ji (x) x_ji = 2 V_i I + e_r (x) m_i + m_i (x) e_r
// and A_i - S_i e_r, not A_i, adds up to 0 (docs/theory-axisymmetric.md).
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/linear_algebra.hpp"

namespace calor {

/// What the correction did, for the report.
struct CorrectionReport {
  bool lattice_shortcut = false;  ///< weights of a lattice, nothing to solve
  int moment_iterations = 0;
  int lambda_solves = 0, lambda_iterations = 0;
  double residual = 0;        ///< max |sum_j G_ij x_ji + A_i| over the faces of a cell, axis by axis
  double change = 0;          ///< max |G/g - 1| of the first lambda solve
  std::int64_t negative = 0;  ///< directed pairs with G < 0 that remain
  double most_negative = 0;   ///< min G / mean |G|, 0 when none
  double negative_share = 0;  ///< sum of |G| |x_ji|^2 over the negative weights, over that of all
  double moment_error = 0;    ///< (M) at points inside the body: root mean square, of the axis where it is largest
  std::int64_t pairs = 0;     ///< directed pairs
};

/// Area of the faces of a whole cell across every axis, m^2, cross-section included; 0 across axes that the body does
/// not have.
Vec3 face_size(const Cloud& cloud, int i);
/// |x_ji / s_ij|^2 of entry n in row i: how many spacings the points of a pair are apart, squared.
double square_in_spacings(const Cloud& cloud, const Neighbours& neighbours, int i, std::int64_t n);
/// Product of the spacings of a pair along the axes of the body, m^D.
double cell_size(const Cloud& cloud, int i, int j);

/// Adds the numbers that report.json shows, by name.
void add_to_report(const CorrectionReport& done, std::map<std::string, double>& report);

/// What to do where pairs cannot serve a material that conducts differently by direction.
inline constexpr const char* cure_of_anisotropy =
    "use method = \"mlpg\", or a box without jitter along the axes of the material, or a cloud whose spacings go with "
    "the roots of the conductivities";

/// Refuses weights that are far from conducting alike in all directions, as on clouds of flat points that lie in no
/// lines: no weights of pairs suit them. `anisotropic`: the body does not conduct alike, and the weights are off that.
/// Throws Error(bad_case) with the numbers, on all ranks alike.
void require_sound(const Cloud& cloud, const CorrectionReport& done, bool anisotropic = false);

/// Base weights g (directed, symmetric to the last bit, true volumes); called only where they are needed.
using BaseWeights = std::function<std::vector<double>()>;

/// Times that (L) is solved at most, each time from weights without the negative ones of the time before.
constexpr int most_solves = 6;

/// G |x_ji|^2 of two points `distance` spacings apart in an unbounded lattice, up to a factor common to all pairs; 0
/// from some distance on.
using LatticeWeight = std::function<double(double distance)>;

/// Consistent weights from base weights: Sinkhorn scaling of the traces of (M), a fit of (M) and (L), then (L) by
/// G_ij = g_ij [1 + (lambda_i - lambda_j).x_ji]. The cloud must have boundary areas. `lattice_weight`: with it an even
/// lattice takes its exact weights without any solve (mirrored_lattice_weights). Empty: it does not. The result does
/// not depend on the number of ranks. Collective; throws Error(numbers) where (L) has no solution.
std::vector<double> consistent_weights(const Cloud& cloud, const Neighbours& neighbours,
                                       const BaseWeights& base_weights, const LatticeWeight& lattice_weight,
                                       CorrectionReport& report, int solves = most_solves);

/// Are the points those of an unjittered lattice in a box with one spacing along every axis?
bool is_even_lattice(const Cloud& cloud);

/// Weights of such a lattice in closed form: symmetric, consistent up to round-off, none negative. Images beyond
/// `folded_faces` (bit f: faces[f]) are folded back, the others are in the lists. None where the body is too thin for
/// that. Collective.
std::optional<std::vector<double>> mirrored_lattice_weights(const Cloud& cloud, const Neighbours& neighbours,
                                                            const LatticeWeight& weight, std::uint32_t folded_faces);

/// Force f = G |x_ji| that two points on a line of a lattice would exchange if it were unbounded, up to a common
/// factor: of how many intervals apart they are, and of their distance over the mean spacing along the axis of the
/// line.
using LineForce = std::function<double(std::int64_t steps, double distance, double spacing)>;

/// The same on unjittered box lattices of unequal spacings, graded or not: every line of points along an axis conducts
/// as a rod of its own, with the face between its cells as cross-section; pairs that lie across get none. The forces of
/// a line are scaled such that those of all pairs across an interval add up to 1, and what then lacks is given to the
/// pair of neighbours. So (L) holds to round-off, no weight is negative whatever the spacings and the grading, and
/// nothing is left to solve. Where cells end at cracks (Cloud::whole) pairs of next rods brace them. Of neighbours
/// alone, the force is 1: the face over the distance, and (M) holds too. Collective; throws Error where points next to
/// each other along an axis are no neighbours.
std::vector<double> lattice_line_weights(const Cloud& cloud, const Neighbours& neighbours, const LineForce& force,
                                         CorrectionReport& report);

/// The same of neighbours alone.
std::vector<double> neighbour_line_weights(const Cloud& cloud, const Neighbours& neighbours, CorrectionReport& report);

// The steps, for bodies whose weights are made in another way. All are collective, take weights of directed pairs that
// are symmetric to the last bit and leave them so.

/// w_ij <- w_ij a_i a_j such that sum_j w_ij = 2 D volume_i: Sinkhorn sweeps. `volume` of the owned points.
void scale_sums(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume, std::span<double> w);

/// g_ij <- g_ij a_i a_j such that sum_j g_ij |x_ji|^2 = 2 D volume_i, in the same way.
void scale_traces(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> volume,
                  std::span<double> g);

/// A few steps towards (M) and (L) at once, sum_j g_ij x_ji (x) x_ji = 2 V_i I and sum_j g_ij x_ji = -A_i, by
///   g_ij <- g_ij [1 + (lambda_i - lambda_j).x_ji + x_ji.(tau_i + tau_j) x_ji],
/// tau symmetric tensors; keeps g >= 0.02 of what it was.
/// Returns their number.
int fit_moments(const Cloud& cloud, const Neighbours& neighbours, std::vector<double>& g);

/// Second moments of points beside cracks: g_ij <- g_ij [1 + x_ji.(tau_i + tau_j) x_ji], tau_i = z_i P_i, so that
/// sum_j g_ij x_ji.P_i x_ji is wanted_i where P_i, of the owned points, is not zero.
void restore_second_moments(const Cloud& cloud, const Neighbours& neighbours, std::span<const Symmetric3> P,
                            std::span<const double> wanted, std::span<double> g);

/// max |R_i| over the faces of a cell, axis by axis. Collective.
double largest_residual(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G);

/// What sum_j g_ij x_ji is to be: -A_i of the owned points, of the facets without images; of axisymmetric bodies
/// S_i e_r - A_i.
std::vector<Vec3> wanted_sums(const Cloud& cloud, const Neighbours& neighbours);

/// R_i = -A_i - sum_j g_ij x_ji of the owned points, m^2; of axisymmetric bodies with A_i - S_i e_r.
std::vector<Vec3> linear_residual(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g);

/// Of the conduction sum_j G_ij (u_i - u_j), each row over sum_j |G_ij|: the least value that 100 steps of Lanczos'
/// method find. Well below 0, differences of temperature grow by themselves; 0 is that of a body of one temperature.
/// Collective.
double lowest_eigenvalue(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G);

struct LambdaSolve {
  int iterations;
  double change;  ///< max |G/g - 1|
  bool negative;  ///< are there weights below 0, or were there before they were lifted
};

/// g_ij <- g_ij [1 + (lambda_i - lambda_j).x_ji] with lambda such that sum_j g_ij x_ji = -A_i, up to `tolerance` of
/// what it was off by. Where any weight becomes negative, all that fall below `floor` of what they were are lifted to
/// that, and lambda may be a rough one; 0: none are.
LambdaSolve enforce_linear_consistency(const Cloud& cloud, const Neighbours& neighbours, std::span<double> g,
                                       double tolerance, double floor = 0);

/// The same, again and again from weights without the negative ones (kept at 0.02 of what they were), until there are
/// none, `most` times at most. Books solves, residual and what is left of negative weights.
void enforce_with_positive_weights(const Cloud& cloud, const Neighbours& neighbours, std::vector<double>& g,
                                   CorrectionReport& report, int most = most_solves);

}  // namespace calor
