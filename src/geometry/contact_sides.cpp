// Cells that end at contacts between parts wherever these run: what the cells of the whole body hold beyond a contact
// goes to the points there, place by place, so that every part keeps its volume and its walls.
#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/neighbours.hpp"
#include "geometry/contact_cells.hpp"
#include "surface/solids.hpp"

namespace calor {
namespace {

/// Volume, or area of a face, that a point gives to one on the other side of a contact.
struct Gift {
  std::int64_t to, from;  ///< global numbers
  int face;               ///< -1: volume
  double amount;          ///< m^3 or m^2
};

/// Finds what lies beyond contacts in the cells and facets of the owned points.
class BeyondContacts {
 public:
  BeyondContacts(const Cloud& cloud, const Sides& sides)
      : cloud_(cloud), sides_(sides), sampler_(cloud), neighbours_(find_neighbours(cloud, reach(cloud))) {}

  /// Of the owned points: does a contact lie between them and a neighbour?
  std::vector<char> beside() const {
    std::vector<char> beside(cloud_.owned);
    for (int i = 0; i < cloud_.owned; ++i)
      beside[i] = std::ranges::any_of(neighbours_.of(i), [&](int j) { return sides_.separate(i, j); });
    return beside;
  }

  std::vector<Gift> find() {
    int facet = 0;
    const int facets = static_cast<int>(cloud_.facets.size());
    for (int i = 0; i < cloud_.owned; ++i) {
      const bool beside = sides_.is_beside[i] != 0;
      if (beside) {
        constexpr int finer = 2;
        sampler_.of(i, finer, places_);
        give(i, -1, cloud_.volume[i], weights_of(cloud_, places_));
      }
      for (; facet < facets && cloud_.facets[facet].point == i; ++facet)
        if (beside) give(i, cloud_.facets[facet].face, cloud_.facets[facet].area, places_on(facet));
    }
    return std::move(gifts_);
  }

 private:
  static Support reach(const Cloud& cloud) {
    constexpr double wanted = 2;  // in spacings: cells end nearer than that
    const Support& support = cloud.halo_support;
    return support.length == 0 ? std::min(wanted, support.over_spacing * (1 - 1e-9)) : wanted;
  }

  /// Sets places_ to some spread over a facet, and returns their weights.
  std::vector<double> places_on(int facet) {
    places_.clear();
    std::vector<double> weights;
    if (cloud_.dimension == 3) {
      sampler_.of_facet(facet, 1, places_);
      return weights_of(cloud_, places_);
    }
    if (cloud_.dimension == 1) {
      places_.push_back(cloud_.x[cloud_.facets[facet].point]);
      return {1};
    }
    const auto ends = sampler_.ends_of_facet(facet);
    const double length = norm(ends[1] - ends[0]) + norm(ends[2] - ends[1]);
    constexpr int per_piece = 64;
    for (const int piece : {0, 1})
      for (int n = 0; n < per_piece; ++n) {
        places_.push_back(ends[piece] + (n + 0.5) / per_piece * (ends[piece + 1] - ends[piece]));
        weights.push_back(norm(ends[piece + 1] - ends[piece]) / (per_piece * length));
      }
    return weights;
  }

  /// Shares what lies at places_ beyond contacts among the nearest points there.
  void give(int i, int face, double measure, const std::vector<double>& weight) {
    part_.resize(places_.size());
    sides_.at(places_, cloud_.tag[i], part_);
    const auto& separated = sides_.separated[sides_.part[i]];
    if (std::ranges::all_of(part_, [&](int p) { return separated[p] != 0; })) return;  // the point keeps something
    for (std::size_t n = 0; n < places_.size(); ++n) {
      if (!separated[part_[n]]) continue;
      int to = -1;
      double nearest = 0;
      for (const int j : neighbours_.of(i)) {
        if (sides_.separated[part_[n]][sides_.part[j]] || (face >= 0 && !(cloud_.on_faces[j] >> face & 1))) continue;
        const Vec3 r = cloud_.x[j] - places_[n];
        if (to < 0 || dot(r, r) < nearest) to = j, nearest = dot(r, r);
      }
      if (to < 0) continue;
      const Gift gift{cloud_.global[to], cloud_.global[i], face, weight[n] * measure};
      const bool more = !gifts_.empty() && gifts_.back().to == gift.to && gifts_.back().from == gift.from &&
                        gifts_.back().face == face;
      more ? void(gifts_.back().amount += gift.amount) : gifts_.push_back(gift);
    }
  }

  const Cloud& cloud_;
  const Sides& sides_;
  CellSampler sampler_;
  Neighbours neighbours_;
  std::vector<Vec3> places_;
  std::vector<int> part_;
  std::vector<Gift> gifts_;
};

void add_to(Cloud& cloud, int i, int face, double amount) {
  if (face < 0) {
    cloud.volume[i] += amount;
    return;
  }
  auto facet = std::ranges::lower_bound(cloud.facets, i, {}, &Facet::point);
  while (facet->face != face) ++facet;
  facet->area += amount;
  cloud.area[i] += amount * facet->normal;
}

/// Takes away the facets that lay beyond contacts as a whole. Collective.
void remove_empty_facets(Cloud& cloud, const std::vector<double>& before) {
  constexpr double round_off = 1e-9;
  std::vector<double> on_faces(cloud.on_faces.begin(), cloud.on_faces.end());
  std::vector<Facet> kept;
  for (std::size_t n = 0; n < cloud.facets.size(); ++n) {
    const Facet& facet = cloud.facets[n];
    if (facet.area > round_off * before[n])
      kept.push_back(facet);
    else
      on_faces[facet.point] -= std::exp2(facet.face);
  }
  cloud.facets = std::move(kept);
  cloud.halo.update(std::span<double>(on_faces));
  for (std::size_t i = 0; i < on_faces.size(); ++i) cloud.on_faces[i] = static_cast<std::uint32_t>(on_faces[i]);
}

}  // namespace

void end_cells_between_points(std::shared_ptr<const Parts> parts, std::vector<std::vector<char>> separated,
                              Cloud& cloud) {
  Sides sides{.part = parts->at(cloud.x, cloud.tag), .is_beside = {}, .separated = std::move(separated), .at = {}};
  sides.at = [parts = std::move(parts)](std::span<const Vec3> x, int tag, std::span<int> part) {
    std::ranges::copy(parts->at(x, std::vector<int>(x.size(), tag)), part.begin());
  };
  // In the same order on any number of ranks.
  std::vector<Gift> gifts;
  BeyondContacts beyond(cloud, sides);
  sides.is_beside = beyond.beside();
  collective_try(cloud.comm, [&] { gifts = beyond.find(); });
  gifts = gather(cloud.comm, gifts);
  std::ranges::stable_sort(gifts, {}, [](const Gift& g) { return std::tuple(g.to, g.from, g.face); });
  auto whole = std::make_shared<Cloud::Measures>(Cloud::Measures{cloud.volume, cloud.area});
  std::vector<double> before;
  for (const Facet& facet : cloud.facets) before.push_back(facet.area);
  const auto local = [&](std::int64_t global) {
    return global >= cloud.first && global < cloud.first + cloud.owned ? static_cast<int>(global - cloud.first) : -1;
  };
  for (const Gift& g : gifts) {
    if (const int i = local(g.to); i >= 0) add_to(cloud, i, g.face, g.amount);
    if (const int i = local(g.from); i >= 0) add_to(cloud, i, g.face, -g.amount);
  }
  remove_empty_facets(cloud, before);
  cloud.halo.update(std::span<double>(cloud.volume));
  cloud.halo.update(std::span<Vec3>(cloud.area));
  // Its cells are not boxes or sectors any more.
  cloud.lattice = nullptr, cloud.rings = nullptr, cloud.box_lattice = false;
  cloud.whole = std::move(whole);
  const auto solids = std::make_shared<Solids>(cloud.solids ? *cloud.solids : Solids());
  solids->set_sides(std::move(sides));
  cloud.solids = solids;
}

}  // namespace calor
