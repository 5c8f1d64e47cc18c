// Weights of lattices whose axes are divided evenly, in closed form, whatever the support.
//
// In an unbounded lattice the weights follow from the steps between two points alone. At a wall the lattice is mirrored
// and the images are folded back: with the shares m_i = V_i / V that points have of a whole cell,
//   G_ij = m_i m_j sum over j and its images j' of G(x_j' - x_i).
// Every point so keeps the second moments along the walls, and (L) along them too. Across a wall a folded pair is
// shorter than it was: as sums over layers of the mirrored lattice do not depend on the place in the layer, what lacks
// in the force across an interval between two layers is the same for all their points but for their shares. The pairs
// of points next to each other across the interval get it. So (L) holds everywhere, edges and corners included, no
// weight is negative, and equal rows have equal bits.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "conduction/correction.hpp"
#include "conduction/lattice_index.hpp"

namespace calor {
namespace {

/// Points along an axis, numbered from 0; beyond a wall with images in the lists the numbers go on, elsewhere images
/// are folded back.
class Axis {
 public:
  /// `reach`: steps that the support has along the axis.
  Axis(std::int64_t n, bool on_walls, bool fold_low, bool fold_high, std::int64_t reach)
      : n_(n),
        reach_(reach),
        on_walls_(on_walls),
        fold_low_(fold_low),
        fold_high_(fold_high),
        period_(on_walls ? 2 * n - 2 : 2 * n) {}

  /// Images of images are folded back only where they are on both sides: else the body must be thicker than the reach.
  bool can_fold() const { return period_ > 0 && (fold_low_ == fold_high_ || n_ >= reach_); }

  /// Calls use(steps) for the point q seen from p and for its images, in the same order for (q, p).
  template <class Use>
  void for_each_image(std::int64_t p, std::int64_t q, const Use& use) const {
    const std::int64_t d = std::abs(q - p), e = p + q + (on_walls_ ? 0 : 1);
    const auto within = [&](std::int64_t steps) {
      if (steps <= reach_) use(steps);
    };
    within(d);
    if (fold_low_) within(e);
    if (fold_high_) within(period_ - e);
    if (!fold_low_ || !fold_high_) return;
    for (std::int64_t shift = period_; shift - d <= reach_; shift += period_) {
      within(shift - d), within(shift + d);
      within(shift + e), within(shift + period_ - e);
    }
  }

  /// Share that a point has of a whole cell.
  double share(std::int64_t p) const { return on_walls_ && (p == 0 || p == n_ - 1) ? 0.5 : 1; }

  /// Points of one class see the same.
  std::int64_t classes() const { return 2 * reach_ + 3; }
  std::int64_t class_of(std::int64_t p) const { return p <= reach_ ? p : std::max(reach_ + 1, p - (n_ - classes())); }

  /// Sets what lacks in the force across the intervals, of the share 1; `layer[m]`: weight that a point has to the
  /// whole layer m steps away, `whole`: the force there should be, over a step.
  void set_lacking(const std::vector<double>& layer, double whole) {
    const std::int64_t low = fold_low_ ? 0 : -reach_, high = fold_high_ ? n_ : n_ + reach_;
    for (std::int64_t k = 0; k <= n_; ++k) {  // between k - 1 and k
      double force = 0;
      for (std::int64_t p = std::max(low, k - reach_); p < k; ++p)
        for (std::int64_t q = k; q < std::min(high, p + reach_ + 1); ++q)
          for_each_image(p, q, [&](std::int64_t steps) {
            force += share(p) * share(q) * layer[steps] * static_cast<double>(q - p);
          });
      lacking_.push_back(std::max(0.0, whole - force));
    }
  }
  /// Between p and the point next to it, q.
  double lacking(std::int64_t p, std::int64_t q) const { return lacking_[std::max(p, q)]; }

 private:
  std::int64_t n_, reach_;
  bool on_walls_, fold_low_, fold_high_;
  std::int64_t period_;  ///< after so many steps the mirrored lattice repeats
  std::vector<double> lacking_;
};

class MirroredLattice {
 public:
  MirroredLattice(const Cloud& cloud, const LatticeWeight& weight, std::uint32_t folded_faces)
      : lattice_(*cloud.lattice), D_(cloud.dimension) {
    while (weight(static_cast<double>(reach_ + 1)) > 0) ++reach_;
    double volume = cloud.cross_section;
    for (int a = 0; a < D_; ++a) {
      along_[a] = reach_ + 1, volume *= lattice_.dx(a);
      axes_.emplace_back(lattice_.box().points[a], cloud.points_on_walls, folded_faces >> 2 * a & 1,
                         folded_faces >> 2 * a & 2, reach_);
    }
    set_weights(weight, volume);
    for (int a = 0; a < D_; ++a) set_lacking(a, volume);
    std::size_t classes = 1;
    for (const Axis& axis : axes_) classes *= axis.classes();
    rows_.resize(classes);
  }

  bool can_fold() const {
    return std::ranges::all_of(axes_, [](const Axis& axis) { return axis.can_fold(); });
  }

  /// Weights of row i.
  const std::vector<double>& row(const Cloud& cloud, const Neighbours& neighbours, int i) {
    const LatticeIndex at = lattice_.index(cloud.id[i]);
    std::size_t place = 0;
    for (int a = D_ - 1; a >= 0; --a) place = place * axes_[a].classes() + axes_[a].class_of(at[a]);
    std::vector<double>& row = rows_[place];
    if (row.empty())
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
        row.push_back(pair(at, index_of_neighbour(lattice_, cloud, neighbours, n)));
    return row;
  }

 private:
  double& unbounded(std::int64_t x, std::int64_t y, std::int64_t z) { return G_[x + along_[0] * (y + along_[1] * z)]; }

  /// Weights of the unbounded lattice: scaled such that sum G x_a^2 = 2 V along the axis where it is largest.
  void set_weights(const LatticeWeight& weight, double volume) {
    G_.resize(along_[0] * along_[1] * along_[2]);
    Vec3 moment;
    for_each_step([&](const LatticeIndex& steps, double times) {
      Vec3 x, xi;
      for (int a = 0; a < D_; ++a) xi[a] = static_cast<double>(steps[a]), x[a] = xi[a] * lattice_.dx(a);
      const double square = dot(x, x);
      if (square == 0) return;
      const double G = unbounded(steps[0], steps[1], steps[2]) = weight(norm(xi)) / square;
      moment += times * G * product(x, x);
    });
    const double largest = std::max({moment.x, moment.y, moment.z});
    for (double& G : G_) G *= 2 * volume / largest;
  }

  void set_lacking(int axis, double volume) {
    std::vector<double> layer(reach_ + 1);
    for_each_step([&](const LatticeIndex& steps, double times) {
      const double both = steps[axis] > 0 ? 2 : 1;  // layers, on both sides
      layer[steps[axis]] += times / both * unbounded(steps[0], steps[1], steps[2]);
    });
    const double step = lattice_.dx(axis);
    axes_[axis].set_lacking(layer, volume / (step * step));
  }

  /// Calls use(steps, number of places in the unbounded lattice so many steps away along the axes, to either side).
  template <class Use>
  void for_each_step(const Use& use) {
    for (std::int64_t z = 0; z < along_[2]; ++z)
      for (std::int64_t y = 0; y < along_[1]; ++y)
        for (std::int64_t x = 0; x < along_[0]; ++x)
          use(LatticeIndex{x, y, z}, (x > 0 ? 2.0 : 1.0) * (y > 0 ? 2.0 : 1.0) * (z > 0 ? 2.0 : 1.0));
  }

  double pair(const LatticeIndex& i, const LatticeIndex& j) {
    // G of j and its images, then what lacks across the interval between two points next to each other.
    const auto images = [&](int a, const auto& use) { a < D_ ? axes_[a].for_each_image(i[a], j[a], use) : use(0); };
    double G = 0;
    images(0, [&](std::int64_t x) {
      images(1, [&](std::int64_t y) { images(2, [&](std::int64_t z) { G += unbounded(x, y, z); }); });
    });
    std::int64_t steps = 0;
    int along = 0;
    for (int a = 0; a < D_; ++a) {
      if (i[a] != j[a]) along = a;
      steps += std::abs(j[a] - i[a]);
      G *= axes_[a].share(i[a]) * axes_[a].share(j[a]);
    }
    if (steps != 1) return G;
    double lacking = axes_[along].lacking(i[along], j[along]);
    for (int a = 0; a < D_; ++a)
      if (a != along) lacking *= axes_[a].share(i[a]);
    return G + lacking;
  }

  const Lattice& lattice_;
  int D_;
  std::int64_t reach_ = 1;
  LatticeIndex along_ = {1, 1, 1};  // weights along every axis
  std::vector<Axis> axes_;
  std::vector<double> G_;                  // of the unbounded lattice, by the steps along the axes
  std::vector<std::vector<double>> rows_;  // by the classes of the points
};

}  // namespace

bool is_even_lattice(const Cloud& cloud) { return cloud.lattice && !cloud.lattice->graded() && !cloud.axisymmetric; }

std::optional<std::vector<double>> mirrored_lattice_weights(const Cloud& cloud, const Neighbours& neighbours,
                                                            const LatticeWeight& weight, std::uint32_t folded_faces) {
  MirroredLattice lattice(cloud, weight, folded_faces);
  if (!lattice.can_fold()) return std::nullopt;
  std::vector<double> G(neighbours.column.size());
  bool fits = true;
  for (int i = 0; i < cloud.owned; ++i) {
    const std::vector<double>& row = lattice.row(cloud, neighbours, i);
    fits = fits && static_cast<std::int64_t>(row.size()) == neighbours.row[i + 1] - neighbours.row[i];
    if (fits) std::ranges::copy(row, G.begin() + neighbours.row[i]);
  }
  if (any(cloud.comm, !fits)) return std::nullopt;
  return G;
}

}  // namespace calor
