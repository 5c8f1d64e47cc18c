#pragma once
// Pairs whose heat crosses interfaces, contacts or cracks, and pairs along an interface: the few of a body for which
// one mean of two conductivities does not do. What the segment between the points runs through conducts in series:
//   flux = (T_b - T_a) / (sum_p f_p / k_p + R),   f_p the parts of the way, R = sum of 1 / (h |x_ba . n|) of contacts.
// With weights that hold linear temperatures exactly, so does heat that flows straight through layers, wherever the
// interfaces lie: T_b - T_a = -q.n (integral of ds.n / k + 1 / h), and kbar (T_b - T_a) = -q.x_ba.
#include <limits>
#include <vector>

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
  bool depends_on_T() const { return depends_on_T_; }  ///< a contact does, on any rank
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
    std::int32_t first, end;  ///< its pieces
    bool one_part;            ///< two pieces, of its ends
    double contacts = 0;      ///< R of contacts that do not depend on temperature, m K/W
    std::int32_t first_crack = 0, end_crack = 0;
    double resistance = 0;  ///< contacts and open cracks, m K/W
  };
  struct Piece {
    std::int32_t end;  ///< index into ends_
    double fraction;   ///< of the way, over R along the pair
  };
  struct CrackResistance {
    double opens, resistance;
  };
  /// A contact, and the pairs across it.
  struct Law {
    const Function* h;
    std::vector<std::int32_t> pair;
    std::vector<Vec3> x;         ///< where they cross it
    std::vector<double> length;  ///< |x_ba . n|, m
    std::vector<int> piece;      ///< of a curved interface, see Parts::curved_areas()
  };
  /// Of all pairs at one state: R with the contacts that depend on temperature, and dR/dT of both ends' mean.
  struct Resistances {
    std::vector<double> R, dR_dT;
  };
  struct Flux {
    double intact, K, share, value;  ///< without R; kbar without R; 1 / (1 + K R); with R
  };
  class Builder;

  /// R of a contact of conductance h, W/(m^2 K), m K/W.
  static double resistance_of(double h, double length) {
    return h > 0 ? 1 / (h * length) : std::numeric_limits<double>::infinity();
  }
  void fit_contacts_to_areas(const Parts& parts);
  void add_constant_contacts();
  Resistances resistances(std::span<const double> T, bool derivative) const;
  Flux flux(const Pair& p, const Conductivity& at, double T_a, double T_b, double R) const;

  const Cloud* cloud_ = nullptr;
  bool exist_ = false, depends_on_T_ = false;
  std::vector<Pair> pairs_;  ///< by id a, then id b
  std::vector<Piece> pieces_;
  std::vector<CrackResistance> cracks_;
  std::vector<Law> laws_;  ///< those that depend on temperature
  std::vector<double> openings_;
  QuadraturePoints ends_;
};

}  // namespace calor
