#pragma once
// Materials that conduct better along one direction than along another, as fibres and crystals make them: heat flows by
//   q = -k R grad T,   R = sum_a factor_a e_a (x) e_a,
// k the conductivity of the material, a function as any other, and R a tensor without unit that is the same at all
// times and temperatures.
#include <array>
#include <optional>

#include "base/symmetric3.hpp"
#include "case/case.hpp"
#include "case/schema.hpp"

namespace calor {

struct Anisotropy {
  Vec3 factors = {1, 1, 1};                                        ///< along the axes e_a of the material, all positive
  std::array<Vec3, 3> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< e_a, orthonormal; where there is no cylinder

  /// Material that is wound around a line: e_a is radial, hoop and axial.
  struct Cylinder {
    int axis = 2;  ///< the line runs along x, y or z
    Vec3 centre;   ///< a point on it, m
    bool operator==(const Cylinder&) const = default;
  };
  std::optional<Cylinder> cylinder = {};

  bool operator==(const Anisotropy&) const = default;

  /// R at x. On the line of a cylinder radial and hoop are the same.
  Symmetric3 at(const Vec3& x) const;
  /// R^power of a material whose axes are the same everywhere.
  Symmetric3 power(double power) const;
  /// Is R the same everywhere, and its axes those of the case?
  bool is_diagonal() const { return !cylinder && power(1).is_diagonal(); }
};

/// [material.NAME.anisotropy]; nothing where it is absent. Throws Error(bad_case).
std::optional<Anisotropy> read_anisotropy(const Table& material);
void declare_anisotropy(Schema& schema);
/// Refuses axes that a body of fewer than three dimensions does not have. Throws Error(bad_case) at `location`.
void require_axes_in_body(const Anisotropy& anisotropy, int dimension, const SourceLocation& location);

}  // namespace calor
