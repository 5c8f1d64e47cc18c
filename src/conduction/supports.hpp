#pragma once
// Which points' supports cover a place, and the rows of shape functions there.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cloud/cells.hpp"
#include "cloud/cloud.hpp"
#include "conduction/mls.hpp"
#include "conduction/quadrature.hpp"

namespace calor {

/// How far the support of a point reaches.
struct SupportSize {
  double spacings = 2.3;  ///< R_J = spacings, in units of the metric s_J along every axis
  int neighbours = 0;     ///< instead, if not 0: R_J = 1.1 times the distance to the n-th nearest point, in that metric
  /// Supports are enlarged where a place sees fewer points than this, or points from which no fit can be made.
  int least = 0;

  /// The largest radius in spacings that counting and enlarging may lead to.
  double limit() const;
};

/// Shape functions at many places, one row a place, of the local points in ascending order of id, so that sums over a
/// row do not depend on the number of ranks.
struct ShapeRows {
  SparseRows phi;
  std::vector<double> slope;  ///< grad phi . along of the first rows, which were given such a vector
};

/// Local points that count at some of several places, ascending by id.
struct Covering {
  std::vector<std::int32_t> points;
  std::vector<MlsNode> nodes;      ///< of the same points
  std::vector<std::uint8_t> sees;  ///< bit l: the support of the point covers place l, which sees it through the body
  struct Hit {
    std::int64_t id;
    std::int32_t position;
    std::uint8_t sees;
  };
  std::vector<Hit> hits;  ///< of the search
};

/// Finds the points whose support covers a place.
class Supports {
 public:
  /// R: support radii of all local points, in spacings.
  Supports(const Cloud& cloud, std::vector<double> R);

  std::span<const double> radius() const { return R_; }
  void set_radius(std::span<const double> R);

  /// How many of the places, from the first on, are evaluated together: few enough, and near enough to each other, for
  /// most of the points that one sees to be seen by the others.
  std::size_t batch(std::span<const Vec3> places) const;
  /// Local points J with |(x - x_J) / s_J| < R_J at one of the places.
  void covering(const MlsPlaces& places, Covering& found) const;
  /// The `count` local points nearest to x in the given metric, nearest first, of those within the ellipsoid `reach`
  /// (m); fewer if there are no more.
  std::vector<std::int32_t> nearest(const Vec3& x, int count, const Vec3& reach, const Vec3& metric) const;
  /// Metric of the point that is the nearest to x in its own metric; some point must lie within `reach` (m).
  const Vec3& metric_at(const Vec3& x, const Vec3& reach) const;

 private:
  /// Leaves those that x sees through the body.
  void keep_seen(const Vec3& x, std::vector<std::int32_t>& points) const;
  void keep_seen(const MlsPlaces& places, std::span<Covering::Hit> hits) const;
  /// Adds the positions begin .. end of order_ whose points cover any of the places to `out`; returns its end.
  Covering::Hit* scan(const MlsPlaces& places, std::int32_t begin, std::int32_t end, Covering::Hit* out) const;
  /// Calls use(begin, end) for the ranges of order_ that hold all points of the box from low to high.
  template <class Use>
  void for_each_row(const Vec3& low, const Vec3& high, const Use& use) const;
  template <class Use>
  void for_each_near(const Vec3& x, const Vec3& reach, const Use& use) const;

  const Cloud& cloud_;
  std::vector<double> R_;
  Vec3 largest_;  // semi-axes of the largest supports, m
  Cells cells_;
  CellOrder order_;
  std::array<std::vector<double>, 3> x_, by_R_;  // in that order: places and inverse semi-axes, axis by axis
};

/// What enlarging did, for the report.
struct SupportReport {
  std::int64_t enlarged = 0;  ///< points whose support was enlarged
  double largest = 0;         ///< radius, in spacings
  std::vector<double> R;      ///< radii of all local points, in spacings
};

/// Rows of shape functions at `places`, every one within a spacing of an owned point of this rank; the first rows with
/// their slopes times the vectors `along`. Supports that are too small for any of the places (of all ranks) are
/// enlarged to 1.15 times the distance of the nearest points. Does not depend on the number of ranks. Collective;
/// throws Error that names the place and the condition number where no support within the limit gives a fit.
ShapeRows shape_rows(const Cloud& cloud, const MovingLeastSquares& mls, const SupportSize& size,
                     std::span<const Vec3> places, std::span<const Vec3> along, SupportReport& report);

/// The same from radii R, which are enlarged.
ShapeRows shape_rows(const Cloud& cloud, const MovingLeastSquares& mls, const SupportSize& size, std::vector<double>& R,
                     std::span<const Vec3> places, std::span<const Vec3> along);

}  // namespace calor
