#pragma once
// The points of a body of any shape with all that they stand for, and the cloud that they are.
#include <mpi.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cloud/body_points.hpp"
#include "cloud/points.hpp"

namespace calor {

class Cache;

/// All points of a body, the same on every rank.
struct MeasuredPoints {
  /// A piece of a wall.
  struct Piece {
    int point;    ///< index into x
    int face;     ///< index into the faces of the body
    double area;  ///< m^(dimension - 1)
    Vec3 vector;  ///< integral of the outward normal over it
  };
  std::vector<Vec3> x;                  ///< m
  std::vector<double> spacing, volume;  ///< m, m^dimension
  std::vector<Piece> pieces;            ///< sorted by point
  std::vector<std::int64_t> id;         ///< numbers of the points, 0 .. count-1 in any order
};

/// Volumes and areas of the points, the same on all ranks, kept in `cache` if there is one. Throws Error(bad_case) with
/// this cure where one has nothing of the body. Collective.
MeasuredPoints measured(MPI_Comm comm, const Body& body, const BodyPoints& points, const std::vector<Box>& boxes,
                        const std::string& cure, Cache* cache = nullptr);

/// The slice of this rank.
Points slice_of(MPI_Comm comm, const MeasuredPoints& all, std::shared_ptr<const Body> body, double section);

}  // namespace calor
