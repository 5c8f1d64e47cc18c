#include "conduction/mirror_images.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

#include "base/parallel.hpp"

namespace calor {

namespace {

constexpr int not_across = MirroredNeighbours::not_across;

/// Points on one face whose conditions are wanted, and where the answers go.
struct Questions {
  std::vector<Vec3> x;
  std::vector<int*> answer;
};

/// Where the bond of point i to the image of point j crosses the wall at `coordinate` of an axis, reflected into the
/// body where it has crossed another wall before; the same bits when i and j change roles.
Vec3 crossing(const Cloud& cloud, const Neighbours& neighbours, int i, std::int64_t n, int axis, double coordinate) {
  int j = neighbours.column[n];
  if (cloud.id[i] > cloud.id[j]) std::swap(i, j);
  const Vec3 &x_i = cloud.x[i], r = neighbours.mirrors[neighbours.image[n]].displacement(x_i, cloud.x[j]);
  Vec3 x = x_i + ((coordinate - x_i[axis]) / r[axis]) * r;
  x[axis] = coordinate;
  for (std::size_t f = 0; f < cloud.walls.size(); ++f) {
    if (!(neighbours.image[n] >> f & 1)) continue;
    double& along = x[static_cast<int>(f / 2)];
    const bool beyond = f % 2 == 0 ? along < cloud.walls[f] : along > cloud.walls[f];
    if (beyond) along = 2 * cloud.walls[f] - along;
  }
  return x;
}

/// Which facets have a condition that images can hold.
std::vector<char> mirrored_patches(const Cloud& cloud, const Conditions& conditions, bool insulated_too) {
  std::vector<Questions> questions(cloud.faces.size());
  std::vector<int> held(cloud.facets.size());
  for (std::size_t p = 0; p < held.size(); ++p) {
    const Facet& facet = cloud.facets[p];
    Vec3 x = cloud.x[facet.point];
    x[facet.face / 2] = cloud.walls[facet.face];
    questions[facet.face].x.push_back(x);
    questions[facet.face].answer.push_back(&held[p]);
  }
  collective_try(cloud.comm, [&] {
    for (std::size_t f = 0; f < questions.size(); ++f) {
      const auto answers = conditions_at(conditions, static_cast<int>(f), questions[f].x);
      for (std::size_t n = 0; n < answers.size(); ++n) *questions[f].answer[n] = answers[n];
    }
  });
  std::vector<char> mirrored;
  mirrored.reserve(held.size());
  for (const int condition : held)
    mirrored.push_back(condition >= 0 || (condition == WallSection::insulated && insulated_too));
  return mirrored;
}

/// Removes the images that are seen through walls which hold none.
void remove_unseen(MirroredNeighbours& mirrored, bool insulated_too) {
  Neighbours& all = mirrored.neighbours;
  std::size_t kept = 0, image = 0, kept_images = 0;
  for (std::size_t i = 0, n = 0; i + 1 < all.row.size(); ++i) {
    const auto end = static_cast<std::size_t>(all.row[i + 1]);
    for (; n < end; ++n) {
      if (all.image[n] != 0) {
        const auto& walls = mirrored.walls[image++];
        const bool unseen = std::ranges::any_of(walls, [&](int condition) {
          return condition == WallSection::flux || (condition == WallSection::insulated && !insulated_too);
        });
        if (unseen) continue;
        mirrored.walls[kept_images++] = walls;
      }
      all.column[kept] = all.column[n];
      all.image[kept++] = all.image[n];
    }
    all.row[i + 1] = static_cast<std::int64_t>(kept);
  }
  all.column.resize(kept);
  all.image.resize(kept);
  mirrored.walls.resize(kept_images);
}

/// Temperature of the image of point m across the walls of `set` whose conditions are terms, as values on the walls.
/// Odd reflection across a wall is 2 P - 1, P the value at the projection on the wall; across several the product of
/// these, whose parts are values on walls, edges and corners. It continues fields linear in every coordinate exactly.
/// An edge takes the mean of its walls.
void add_values(const Cloud& cloud, int m, std::uint32_t set, const std::array<int, 3>& terms, Layers layers,
                ImageBonds& bonds) {
  std::vector<std::pair<int, int>> odd;  // axis, face
  for (std::size_t f = 0; f < cloud.walls.size(); ++f)
    if (set >> f & 1 && terms[f / 2] >= 0) odd.emplace_back(static_cast<int>(f / 2), static_cast<int>(f));
  const auto image = static_cast<std::int32_t>(bonds.images.size());
  const auto S = static_cast<int>(odd.size());
  const bool is_odd = layers == Layers::odd;
  ImageBonds::Image& added = bonds.images.emplace_back();
  added = {.point = m, .sign = !is_odd ? 0.0 : S % 2 == 1 ? -1.0 : 1.0, .term = {-1, -1, -1}};
  for (const auto& [axis, face] : odd) added.term[axis] = terms[axis];
  for (std::uint32_t U = 1; U < 1u << S; ++U) {
    const int size = std::popcount(U);
    if (!is_odd && size > 1) continue;
    Vec3 x = cloud.x[m];
    for (int a = 0; a < S; ++a)
      if (U >> a & 1) x[odd[a].first] = cloud.walls[odd[a].second];
    const double factor = is_odd ? ((S - size) % 2 == 1 ? -1.0 : 1.0) * (1 << size) / size : 1.0 / S;
    for (int a = 0; a < S; ++a)
      if (U >> a & 1) bonds.values.push_back({image, terms[odd[a].first], factor, x});
  }
}

/// Pairs that carry nothing, as those across the lines of a lattice, need not be looked at.
void remove_pairs_without_weight(Neighbours& pairs, std::vector<double>& G) {
  std::size_t kept = 0, n = 0;
  for (std::size_t i = 0; i + 1 < pairs.row.size(); ++i) {
    for (const auto end = static_cast<std::size_t>(pairs.row[i + 1]); n < end; ++n) {
      if (G[n] == 0) continue;
      pairs.column[kept] = pairs.column[n];
      G[kept++] = G[n];
    }
    pairs.row[i + 1] = static_cast<std::int64_t>(kept);
  }
  pairs.column.resize(kept);
  G.resize(kept);
}

}  // namespace

MirroredNeighbours find_mirrored_neighbours(const Cloud& cloud, const Support& support, const Conditions& conditions,
                                            bool insulated_too) {
  // Beyond a curved wall an axisymmetric body has no image.
  if (cloud.points_on_walls || cloud.walls.empty() || cloud.axisymmetric) return {find_neighbours(cloud, support)};
  std::vector<char> facets = mirrored_patches(cloud, conditions, insulated_too);
  std::uint32_t faces = 0;
  for (std::size_t p = 0; p < facets.size(); ++p)
    if (facets[p]) faces |= 1u << cloud.facets[p].face;
  faces = any_bit(cloud.comm, faces);

  MirroredNeighbours out{find_neighbours(cloud, support, faces)};
  Neighbours& all = out.neighbours;
  if (faces == 0) return out;
  all.mirrored = std::move(facets);
  out.walls.assign(std::ranges::count_if(all.image, [](auto set) { return set != 0; }),
                   {not_across, not_across, not_across});
  std::vector<Questions> questions(cloud.faces.size());
  std::size_t image = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = all.row[i]; n < all.row[i + 1]; ++n) {
      if (all.image[n] == 0) continue;
      for (std::size_t f = 0; f < cloud.walls.size(); ++f) {
        if (!(all.image[n] >> f & 1)) continue;
        const int axis = static_cast<int>(f / 2);
        questions[f].x.push_back(crossing(cloud, all, i, n, axis, cloud.walls[f]));
        questions[f].answer.push_back(&out.walls[image][axis]);
      }
      ++image;
    }
  }
  collective_try(cloud.comm, [&] {
    for (std::size_t f = 0; f < questions.size(); ++f) {
      const auto answers = conditions_at(conditions, static_cast<int>(f), questions[f].x);
      for (std::size_t n = 0; n < answers.size(); ++n) *questions[f].answer[n] = answers[n];
    }
  });
  remove_unseen(out, insulated_too);
  return out;
}

PairTerms fold_images(const Cloud& cloud, const Parts& parts, MirroredNeighbours mirrored, std::vector<double> G,
                      Layers layers, std::span<const PrescribedTerm> temperatures, const PairDirections& directions) {
  Neighbours& all = mirrored.neighbours;
  const auto pairs = [&] {
    return std::make_unique<PairConduction>(cloud, parts, std::move(all), std::move(G), CrackBonds(), directions);
  };
  if (all.mirrors.empty()) {
    remove_pairs_without_weight(all, G);
    return {pairs(), nullptr};
  }
  // Pairs without weight stay here: the image of one of their points may count, and the Jacobian has room for pairs.
  std::vector<int> part;
  if (!directions.of_parts.empty()) collective_try(cloud.comm, [&] { part = parts.at(cloud.x, cloud.tag); });

  using Image = std::tuple<int, std::uint8_t, std::array<int, 3>>;
  std::map<Image, std::int32_t> numbers;
  ImageBonds bonds;
  std::size_t kept = 0, image = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    const std::int64_t begin = all.row[i], end = all.row[i + 1];
    const std::size_t first = kept;
    for (auto n = begin; n < end; ++n) {
      const int j = all.column[n];
      if (all.image[n] == 0) {
        all.column[kept] = j;
        G[kept++] = G[n];
        continue;
      }
      const auto& walls = mirrored.walls[image++];
      if (std::ranges::none_of(walls, [](int condition) { return condition >= 0; })) {
        if (j == i) continue;  // as warm as the point itself
        // The point is nearer than its image, hence a neighbour, and the row is sorted by id.
        const auto row = std::span(all.column).subspan(first, kept - first);
        const auto at = std::ranges::lower_bound(row, cloud.id[j], {}, [&](int point) { return cloud.id[point]; });
        G[first + (at - row.begin())] += G[n];
        continue;
      }
      const auto [known, is_new] =
          numbers.try_emplace({j, all.image[n], walls}, static_cast<std::int32_t>(bonds.images.size()));
      if (is_new) add_values(cloud, j, all.image[n], walls, layers, bonds);
      bonds.point.push_back(i);
      bonds.image.push_back(known->second);
      const Vec3 x_ji = all.mirrors[all.image[n]].displacement(cloud.x[i], cloud.x[j]);
      bonds.G.push_back(part.empty() ? G[n] : along(directions.of_parts[part[i]], x_ji) * G[n]);
    }
    all.row[i] = static_cast<std::int64_t>(first);
  }
  all.row[cloud.owned] = static_cast<std::int64_t>(kept);
  all.column.resize(kept);
  G.resize(kept);
  all.image = std::vector<std::uint8_t>();  // {} would keep its memory
  all.mirrors.clear(), all.mirrored.clear();
  PairTerms terms{pairs(), nullptr};
  if (any(cloud.comm, !bonds.G.empty()))
    terms.images = std::make_unique<ImageConduction>(std::move(bonds), temperatures);
  return terms;
}

Discretisation pair_discretisation(const Cloud& cloud, const Parts& parts, const Conditions& conditions,
                                   MirroredNeighbours mirrored, std::vector<double> G, Layers layers,
                                   const PairDirections& directions) {
  PairTerms terms =
      fold_images(cloud, parts, std::move(mirrored), std::move(G), layers, conditions.temperatures, directions);
  std::vector<std::unique_ptr<HeatTerm>> walls;
  if (terms.images) walls.push_back(std::move(terms.images));
  return nodal_discretisation(cloud, conditions, std::move(terms.pairs), std::move(walls), nullptr,
                              layers_before_walls(cloud, parts, directions.of_parts));
}

}  // namespace calor
