#pragma once
// One state of the body, at which all terms of the heat equation are evaluated. Coefficients are computed on demand,
// once a state, and once for good where they are constant; their buffers live here and are reused.
#include <span>
#include <vector>

#include "conduction/dofs.hpp"
#include "conduction/quadrature.hpp"
#include "material/material_field.hpp"

namespace calor {

/// The conductivity at one set of points, as the formulas of a method take it.
struct Conductivity {
  Mean mean = Mean::arithmetic;
  std::span<const double> k;      ///< W/(m K)
  std::span<const double> dk_dT;  ///< only for Jacobians; empty: k does not depend on T, or counts as frozen
  std::span<const double> theta;  ///< integral of k dT, W/m; only for rates with Mean::integral
  /// At the ends of pairs that cross interfaces or cracks, where a method has such.
  const Conductivity* ends = nullptr;
  double t = 0;  ///< s, at which contacts are wanted
};

/// What a conductivity is wanted for: theta or k for rates and flux vectors, k for bounds, k and dk/dT for Jacobians.
enum class Purpose { rate, bound, jacobian };

/// The material at one set of points: the nodes, or the quadrature points of a method.
class Coefficients {
 public:
  /// `phi`: temperatures there from the degrees of freedom; null: `begin` gets the temperatures. Both must outlive
  /// this.
  explicit Coefficients(const MaterialField& material, const SparseRows* phi = nullptr)
      : material_(&material), phi_(phi) {}

  /// A new state: degrees of freedom or temperatures, which must live as long as the state is asked for.
  void begin(double t, std::span<const double> u, bool frozen);

  const MaterialField& material() const { return *material_; }
  /// These may throw on one rank alone: they belong inside a `collective_try`.
  std::span<const double> T();
  std::span<const double> k();
  /// Empty where k does not depend on T or is frozen.
  std::span<const double> dk_dT();
  Conductivity conductivity(Purpose purpose);
  /// k, and dk/dT for Jacobians: of pairs that take no difference of theta.
  Conductivity at_ends(Purpose purpose);

 private:
  const MaterialField* material_;
  const SparseRows* phi_;
  double t_ = 0;
  bool frozen_ = false;
  std::vector<double> T_buffer_, k_, dk_dT_, theta_;
  std::span<const double> u_;
  bool has_T_ = false, has_k_ = false, has_dk_dT_ = false, has_theta_ = false;
};

/// An index into the sets of points of an evaluation.
using Location = int;

class Evaluation {
 public:
  static constexpr Location nodes = 0;

  /// `locations[0]` is the material at all local nodes. `dofs` must outlive this.
  Evaluation(const Dofs& dofs, std::vector<Coefficients> locations);

  /// A new state. `u` covers the local points, ghosts up to date, and must live as long as the state is asked for.
  /// `frozen`: the conductivity counts as independent of temperature.
  void begin(double t, std::span<const double> u, bool frozen = false);

  double t() const { return t_; }
  std::span<const double> u() const { return u_; }  ///< degrees of freedom of the local points
  std::span<const double> T();                      ///< temperatures of the owned points, K
  double T(int i) const;                            ///< of one alone
  Coefficients& at(Location location);

 private:
  const Dofs& dofs_;
  std::vector<Coefficients> locations_;
  std::vector<char> has_begun_;
  double t_ = 0;
  bool frozen_ = false, has_T_ = false;
  std::span<const double> u_;
  std::vector<double> T_;
};

}  // namespace calor
