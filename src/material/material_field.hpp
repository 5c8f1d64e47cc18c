#pragma once
// The properties of the whole body at the points where terms of the heat equation want them: every point has the
// conductivity of its part, or on an interface that of all parts that meet there by their shares; the heat of a cell is
// that of the parts in it.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "geometry/parts.hpp"
#include "material/anisotropy.hpp"
#include "material/material.hpp"

namespace calor {

/// How two points of one part share a conductivity. integral: one material whose k depends on T alone, the pair flux is
/// G (theta_j - theta_i) with theta = integral of k dT (exact); arithmetic: k(x) or k(x,T); harmonic: k given in
/// layers, the interface midway between the points.
enum class Mean { integral, arithmetic, harmonic };

class MaterialField {
 public:
  /// The parts of the case with their materials at all local points of the cloud, which must outlive this. Collective
  /// (errors are raised together).
  MaterialField(const Case& c, const Cloud& cloud, const TemperatureRange& range);
  /// The same body at other places, which must outlive this; `tag`: one a place. `part`: the part that is meant at each
  /// place; empty: the one that the place lies in. Collective.
  MaterialField(const MaterialField& body, std::span<const Vec3> x, std::span<const int> tag,
                std::span<const int> part);
  MaterialField(MaterialField&&) noexcept;
  ~MaterialField();

  const Parts& parts() const;
  /// Of the body itself: see Parts::cell_shares.
  const std::vector<PlacesOfPart>& cell_shares() const;
  /// Of every place: does it lie in the part, or on its surface?
  std::vector<char> lie_in(int part) const;
  /// How pairs inside a part share k: as the case asks for, otherwise integral for one material with k(T), harmonic
  /// where k is given in layers, arithmetic for the rest.
  Mean mean() const;
  /// Does the conductivity of a part jump between layers of its material?
  bool conductivity_is_layered() const;
  /// How a part conducts by direction; null: alike.
  const Anisotropy* anisotropy(int part) const;
  bool is_isotropic() const;
  bool conductivity_depends_on_T() const;
  const TemperatureRange& expected_range() const;
  bool conductivity_depends_on_time() const;
  bool capacity_depends_on_T() const;
  /// Are density and specific heat known everywhere? A steady case does without: rho c then counts as 1 J/(m^3 K).
  bool has_capacity() const;

  /// Names of the materials in the body that are no mixtures, each once.
  std::vector<std::string> ingredients() const;
  /// Volume fraction of an ingredient at the first v.size() places, 0 to 1.
  void volume_fraction(const std::string& ingredient, std::span<double> v) const;

  // All places, or only the first T.size() of them. A value that is not positive and finite throws Error(numbers)
  // with point and temperature; that can happen on one rank alone: callers run these inside `together` or check at
  // their own reduction.
  void conductivity(double t, std::span<const double> T, std::span<double> k, std::span<double> dk_dT) const;
  void theta(std::span<const double> T, std::span<double> theta) const;
  /// Per volume; either span may be empty.
  void enthalpy(std::span<const double> T, std::span<double> H, std::span<double> rho_c) const;
  /// Solves H(T) = H for T (Newton, safeguarded); T holds a guess on entry. First `H.size()` points.
  void temperature(std::span<const double> H, std::span<double> T) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// [material.*] and [body].
void declare_materials(Schema& schema);

}  // namespace calor
