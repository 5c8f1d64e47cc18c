#pragma once
// Sources that are small and may move: what is common to line, column, surface and double ellipsoid. Heat goes in as
// means over the cells of the points, and its sum is the power asked for.
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "source/path.hpp"
#include "source/source.hpp"
#include "source/source_profile.hpp"

namespace calor {

/// How a source spreads its heat around its place: a product of densities along its motion, across, and along an axis
/// normal to both (bodies of fewer dimensions leave out the last ones).
struct Shape {
  SourceProfile along, across;
  bool is_round = false;  ///< the same in all directions normal to the axis
  int axis = 2;
  double into = 1;  ///< sign of the direction along the axis in which `depth` counts
  SourceProfile depth = SourceProfile::even();
  /// Heat enters by this face of the cloud alone; `depth` is not used.
  std::optional<int> face = {};
  double radius = 0;  ///< within which most of the heat goes in, m; 0: as small as the spacing allows
  double sigma = 0;   ///< of its shortest side along the motion, m: steps in time resolve it
};

/// The source of [source.NAME] with its power and path. Warns where the cloud is too coarse for it; refuses one that
/// never touches the body, and a bad efficiency. The cloud must outlive it. Collective; throws Error.
std::unique_ptr<Source> make_moving_source(const std::string& name, const Table& table, const Cloud& cloud,
                                           const Shape& shape);

/// sigma of a Gaussian from the keys `sigma` or `radius` (= sqrt(6) sigma, where exp(-3 r^2 / radius^2) has fallen to
/// 5 %) of a table; exactly one must be given.
double sigma_of(const Table& table);
/// The two keys.
std::vector<Key> sigma_keys();
/// A length of the table; refuses one that is not positive.
double positive_length(const Table& table, const std::string& key);
/// Axis and sign of a direction like "-z"; refuses an axis that the body does not have.
struct Direction {
  int axis;
  double sign;
};
Direction direction_of(const Table& table, const std::string& key, int dimension);
/// Axis of a line or column from the key `along`: z in a body of two dimensions or one, the normal of its plane.
int axis_through(const Table& table, int dimension);

}  // namespace calor
