#pragma once
// The temperature at a place as a sum over points near it, of the part of the body that it lies in: see probes.hpp.
#include <cstdint>
#include <optional>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/cracks.hpp"
#include "geometry/parts.hpp"

namespace calor {

/// What a probe cannot look across.
struct Obstacles {
  const Parts* parts = nullptr;
  const Cracks* cracks = nullptr;
};

/// A cloud point near a place, as it travels between ranks.
struct Candidate {
  double distance;
  std::int64_t id;
  Vec3 x;
  Vec3 side;  ///< where it lies for all questions about sides: beside a crack that it is on
  double spacing;
  std::uint32_t on_faces;
  int tag, rank, point;
};

/// How many of the nearest points of a place are enough: about three times the number of cubic monomials.
int enough_points(int dimension);
/// The nearest points of a place in the whole cloud, nearest first, the same on every rank; more than enough of them
/// where a part may be out of sight. Collective.
std::vector<Candidate> nearest_points(const Cloud& cloud, const Obstacles& obstacles, const Vec3& p);

struct WeightedPoint {
  Candidate point;
  double weight;
};

/// The sum that is the temperature at p; none where the part that p lies in has no point near. In a part so thin that
/// its points do not tell how the temperature changes across it, it is linear between the surfaces on either side.
/// `near`: see nearest_points. Collective; throws Error.
std::optional<std::vector<WeightedPoint>> interpolation(const Cloud& cloud, const Obstacles& obstacles, const Vec3& p,
                                                        const std::vector<Candidate>& near);
/// The same without regard to parts.
std::vector<WeightedPoint> interpolation(const Cloud& cloud, const Vec3& p, std::vector<Candidate> near);

}  // namespace calor
