#pragma once
// Unknowns whose values at the points are not themselves: T(x_i) = sum_J Phi_iJ T_J (moving least squares does not
// interpolate).
#include <petscksp.h>

#include <span>

#include "cloud/cloud.hpp"
#include "conduction/flux_sites.hpp"

namespace calor {

class NodalValues {
 public:
  /// `phi`: one row an owned point. Both must outlive this. Collective.
  NodalValues(const Cloud& cloud, const SparseRows& phi);
  ~NodalValues();
  NodalValues(const NodalValues&) = delete;
  NodalValues& operator=(const NodalValues&) = delete;

  const SparseRows& phi() const { return phi_; }
  /// Solves Phi T = values for the owned unknowns. Throws Error(numbers) on all ranks where that fails. Collective.
  void unknowns(std::span<const double> values, std::span<double> T);
  /// T += Phi^-1 change, likewise.
  void add(std::span<const double> change, std::span<double> T);

 private:
  void factorise();
  bool solve();

  const Cloud& cloud_;
  const SparseRows& phi_;
  Mat matrix_ = nullptr;
  Vec right_ = nullptr, solution_ = nullptr, left_ = nullptr;
  KSP solver_ = nullptr;
  bool is_direct_ = false;
};

}  // namespace calor
