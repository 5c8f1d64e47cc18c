#pragma once
// Pairs whose heat crosses interfaces, contacts or cracks, and pairs along an interface: the few of a body for which
// one mean of two conductivities does not do. What the segment between the points runs through conducts in series:
//   flux = (T_b - T_a) / (sum_p f_p / k_p + R),   f_p the parts of the way, R = sum of 1 / (h |x_ba . n|) of contacts.
// A conductance h that depends on temperature is that of the mean of the contact's faces, which follow from the flux:
//   T = (T_- + T_+) / 2,   T_- = T_a + flux (resistances before the contact),   T_+ = T_- + flux / (h(T) |x_ba . n|).
// With weights that hold linear temperatures exactly, so does heat that flows straight through layers, wherever the
// interfaces lie: T_b - T_a = -q.n (integral of ds.n / k + 1 / h), and kbar (T_b - T_a) = -q.x_ba.
#include <limits>
#include <vector>

#include "base/ramped_function.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/heat_term.hpp"
#include "conduction/linear_algebra.hpp"
#include "geometry/parts.hpp"

namespace calor {

/// A pair across a crack: a fraction of its weight fails when the crack opens, or conducts in series with a contact.
struct CrackBond {
  std::int64_t entry;  ///< in the neighbour lists
  int point;           ///< owned point in whose row it is
  double fraction;
  double contact;  ///< h_c |x_ji . n|, conductance of the contact over the pair's area / length: W/(m K); 0: none
  double opens;    ///< s; 0: open from the start
};

/// All of a rank, and the times at which cracks open, on all ranks.
struct CrackBonds {
  std::vector<CrackBond> bonds;
  std::vector<double> openings;
};

class SeriesPairs {
 public:
  SeriesPairs() = default;
  /// Takes its pairs' weights out of G (directed, as in `neighbours`). `R`: of every part whose conductivity is k R,
  /// all pairs along its axes; empty: it is k. The cloud and the parts must outlive this. Collective; throws Error.
  SeriesPairs(const Cloud& cloud, const Parts& parts, const Neighbours& neighbours, std::span<double> G,
              CrackBonds cracks, std::span<const Symmetric3> R = {});

  /// Are there any on some rank?
  bool exist() const { return exist_; }
  /// Where conductivities are wanted: the points as they belong to the parts that meet there.
  const QuadraturePoints& ends() const { return ends_; }
  const std::vector<double>& openings() const { return openings_; }
  bool depends_on_T() const { return depends_on_T_; }        ///< a contact does, on any rank
  bool depends_on_time() const { return depends_on_time_; }  ///< a contact does, on any rank
  /// Of contacts that depend on time, and the openings of cracks; the same on all ranks.
  const Changes& changes() const { return changes_; }
  void open(double t);

  // F_i += sum_j G_ij flux_ij of the owned points, its derivatives, and the row sums of frozen conductivities.
  void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const;
  void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const;
  void add_row_sums(const Conductivity& k, std::span<double> sums) const;
  /// M_i += G x_ji (x) x_ji and b_i += G flux x_ji of the owned points.
  void add_moments(const Conductivity& k, std::span<const double> T, std::span<Symmetric3> M, std::span<Vec3> b) const;

 private:
  struct Pair {
    std::int32_t a, b;  ///< local points, id a < id b: both ends add up in the same order
    double G;
    std::int32_t first, end;          ///< its pieces
    bool one_part;                    ///< two pieces, of its ends
    double contacts = 0, cracks = 0;  ///< R of contacts that do not change, and of open cracks, m K/W
    std::int32_t first_contact = 0, end_contact = 0;
    std::int32_t first_crack = 0, end_crack = 0;
  };
  struct Piece {
    std::int32_t end;  ///< index into ends_
    double fraction;   ///< of the way, over R along the pair
  };
  struct CrackResistance {
    double opens, resistance;
  };
  /// Where a pair crosses a contact; those of a pair stand in the order from a to b.
  struct Contact {
    const Function* h;
    std::int32_t pair;
    std::int32_t before;  ///< pieces of the pair before it
    Vec3 x;               ///< where the pair crosses it
    double length;        ///< |x_ba . n|, m
    int piece;            ///< of a curved interface, see Parts::curved_areas()
    double R = 0;         ///< if it does not change, m K/W
  };
  /// Contacts of one conductance that changes.
  struct Law {
    RampedFunction h;
    std::vector<std::int32_t> contact;
    std::vector<Vec3> x;
  };
  /// At one state: R of all pairs; of the contacts R and, for Jacobians, d(h |x_ba . n|)/dT, W/(m K^2).
  struct Resistances {
    std::vector<double> R, of_contact, slope;
  };
  /// What the solution for a contact's faces starts from: the temperature jumps from point to point by `jump`; the rest
  /// of the pair has the resistance `others`, `before` of it up to the contact.
  struct Faces {
    double T_a, jump, before, others;
  };
  struct Flux {
    double intact, K, share, value;  ///< without R; kbar without R; 1 / (1 + K R); with R
  };
  struct Derivatives {
    double by_a, by_b;  ///< of a flux, by the temperatures of its points
  };
  class Builder;

  /// R of a contact of conductance h, W/(m^2 K), m K/W.
  static double resistance_of(double h, double length) {
    return h > 0 ? 1 / (h * length) : std::numeric_limits<double>::infinity();
  }
  void fit_contacts_to_areas(const Parts& parts);
  void sort_contacts_into_laws();
  void find_changes(const Parts& parts);
  Resistances resistances(const Conductivity& at, std::span<const double> T, bool derivative) const;
  void follow_time(const Law& law, double t, std::vector<double>& R) const;
  void solve_faces(const Law& law, const Conductivity& at, std::span<const double> T, std::span<const char> is_wanted,
                   Resistances& r, bool derivative) const;
  Faces faces(const Contact& c, const Conductivity& at, std::span<const double> T, std::span<const double> R) const;
  Derivatives derivatives(const Pair& p, const Conductivity& at, const Flux& f, double jump) const;
  /// dK/dk of the conductivity at the end of a piece.
  double dK_dk(const Pair& p, std::int32_t piece, double K, const Conductivity& ends) const;
  Derivatives derivatives_by_faces(const Pair& p, const Conductivity& at, const Flux& f, const Resistances& r) const;
  Flux flux(const Pair& p, const Conductivity& at, double T_a, double T_b, double R) const;

  const Cloud* cloud_ = nullptr;
  bool exist_ = false, depends_on_T_ = false, depends_on_time_ = false;
  std::vector<Pair> pairs_;  ///< by id a, then id b
  std::vector<Piece> pieces_;
  std::vector<CrackResistance> cracks_;
  std::vector<Contact> contacts_;
  std::vector<Law> laws_;
  std::vector<char> shares_pair_;  ///< of every contact: does its pair cross others of temperature?
  std::vector<double> openings_;
  Changes changes_;
  QuadraturePoints ends_;
};

}  // namespace calor
