#pragma once
// Points where walls of prescribed temperature meet, and the heat that each of them gives.
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// What such a point takes to hold its temperature is booked to its walls in equal shares. But heat that flows along
/// one wall comes through another: each gives what flows through its own area, and a share of the rest.
class WallCorners {
 public:
  /// Collective.
  WallCorners(const Cloud& cloud, std::span<const PrescribedTerm> temperatures);

  bool exist() const { return exist_; }                    ///< on any rank
  std::span<const int> points() const { return points_; }  ///< owned
  /// Adds to power[account] what goes beyond equal shares, W; it sums up to nothing. `q`: heat flux at the points,
  /// W/m^2. Exact for linear temperatures.
  void shift(std::span<const Vec3> q, std::span<double> power) const;

 private:
  struct Wall {
    int point;  ///< index into points_
    int account;
    double share;
    Vec3 area;
  };
  std::vector<int> points_;
  std::vector<Wall> walls_;
  bool exist_ = false;
};

}  // namespace calor
