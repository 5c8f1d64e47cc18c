#pragma once
// The path of a source along the body: what of it heats nothing.
#include <array>
#include <string>
#include <vector>

#include "cloud/cloud.hpp"
#include "source/path.hpp"

namespace calor {

/// A straight line of a path.
struct Stretch {
  Vec3 from, to;
  double begin;        ///< s
  bool heats;          ///< its power is not 0
  double spacing = 0;  ///< the largest among the points that are touched; 0 where none are
};

/// The path as straight lines, short segments taken together where they stay near a line, with the spacings of the
/// points of this rank that a source of the given radius (m) touches: nearer than it and their own spacing, along the
/// axes on which the source varies. Collective.
std::vector<Stretch> stretches_of(const Path& path, const Cloud& cloud, double radius,
                                  const std::array<bool, 3>& varies);

/// What a user should know of a path that is not what was meant: on which the source heats beside the body, or after
/// the end of the run, s. Collective.
std::vector<std::string> notes_on_path(const std::vector<Stretch>& lines, const std::string& source, double end,
                                       MPI_Comm comm);

}  // namespace calor
