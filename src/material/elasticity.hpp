#pragma once
// What [stress] needs to know of materials: stiffness, Poisson's ratio, thermal strain, of mixtures by rules for
// their bulk and shear moduli.
#include <mpi.h>

#include <span>
#include <string>
#include <vector>

#include "base/vec3.hpp"
#include "case/case.hpp"
#include "case/registry.hpp"
#include "case/schema.hpp"
#include "material/material_field.hpp"

namespace calor {

/// Isotropic elastic constants, and the strain at which there is no stress, one value a place.
struct ElasticState {
  std::vector<double> E;   ///< Young's modulus, Pa
  std::vector<double> nu;  ///< Poisson's ratio
  std::vector<double> thermal_strain;
};

/// Bulk and shear modulus, Pa.
struct Moduli {
  double K, G;
};

/// A rule for the moduli of a mixture. Phases are embedded in a medium of moduli K*, G*: K = sum v_i K_i f_i /
/// sum v_i f_i with f_i = 1/(a K_i + K*), G alike. Hashin & Shtrikman, J. Mech. Phys. Solids 11 (1963) 127.
struct ElasticRule {
  std::string name;
  std::string sentence;  ///< for the manual, without a full stop
  double a;              ///< 0: all phases have the same strain; 1 otherwise
  Moduli (*medium)(const Moduli& first_phase);
};
Registry<ElasticRule>& elastic_rules();

class Elasticity {
 public:
  /// Of the body at places x (m), which must outlive this; `tag`: one a place; `free_at`: temperature without stress,
  /// K. Refuses materials that say too little. Collective; throws Error(bad_case).
  Elasticity(const Case& c, MPI_Comm comm, const MaterialField& body, std::span<const Vec3> x, std::span<const int> tag,
             const ElasticRule& rule, double free_at);
  /// At temperatures T of all places, K. Throws Error, maybe on one rank alone, where a stiffness is not positive, or
  /// Poisson's ratio not below 0.5.
  ElasticState at(std::span<const double> T) const;

 private:
  struct Phase {
    std::string name;
    std::vector<double> fraction;  ///< of the volume, one a place
    bool is_pore = false;
    Function E = {}, nu = {}, expansion = {};
    double expansion_from = 0;  ///< K
  };
  Phase read_phase(const Case& c, const std::string& name) const;
  void find_matrix(const Case& c, const MaterialField& body, std::span<const int> tag);

  std::span<const Vec3> x_;
  const ElasticRule* rule_;
  double free_at_;
  std::vector<Phase> phases_;
  std::vector<int> matrix_;  ///< the phase that is the matrix, one a place
};

/// Keys of [material.NAME] for it.
void declare_elasticity(Schema& schema);

}  // namespace calor
