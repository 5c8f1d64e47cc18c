#pragma once
// The sums over pairs that the corrections of weights iterate with: of relative changes of the weights,
//   c_ij = (lambda_i - lambda_j).x_ji                          of vectors, or
//   c_ij = (lambda_i - lambda_j).x_ji + x_ji.(tau_i + tau_j) x_ji     of vectors and symmetric tensors,
// their effect sum_j g_ij c_ij x_ji, and sum_j g_ij c_ij x_ji (x) x_ji.
#include <array>
#include <span>
#include <type_traits>
#include <vector>

#include "base/simd.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

/// xx, yy, zz, xy, xz, yz of a (x) a, or of a symmetric tensor; the mixed components of tau count twice.
using Six = std::array<double, 6>;
inline Six products(const Vec3& a) { return {a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.x * a.z, a.y * a.z}; }

template <bool tensors>
class PairChanges {
 public:
  using Number = double;
  /// Unknowns of a point: lambda, and with tensors the six of tau.
  static constexpr int unknowns = tensors ? 9 : 3;

  /// Lengths are measured in `unit`, m: a power of 2, so that this rounds nothing. The unknowns are 0 at first.
  PairChanges(const Cloud& cloud, const Neighbours& neighbours, double unit = 1)
      : cloud_(cloud), neighbours_(neighbours), points_(cloud.local()) {
    for (std::size_t i = 0; i < points_.size(); ++i)
      for (int a = 0; a < 3; ++a) points_[i].x[a] = cloud.x[i][a] / unit;
    const auto sign = [](double v) { return static_cast<Number>(v); };
    for (const Mirror& m : neighbours.mirrors) {
      const Vec3 s = m.sign, shift = (1 / unit) * m.shift;
      mirrors_.push_back({.place_sign = {s.x, s.y, s.z, 0},
                          .shift = {shift.x, shift.y, shift.z, 0},
                          .sign = {sign(s.x), sign(s.y), sign(s.z), 0},
                          .mixed_sign = {sign(s.x * s.y), sign(s.x * s.z), sign(s.y * s.z), 0}});
    }
  }

  /// Of an owned point.
  std::span<Number, unknowns> at(int i) { return std::span<Number, unknowns>(points_[i].v, unknowns); }
  /// Gives ghosts the unknowns of their points. Collective.
  void update_ghosts() {
    if (size_of(cloud_.comm) == 1) return;
    std::vector<Vec3> field(points_.size());
    for (int first = 0; first < unknowns; first += 3) {
      for (int i = 0; i < cloud_.owned; ++i)
        for (int a = 0; a < 3; ++a) field[i][a] = points_[i].v[first + a];
      cloud_.halo.update(std::span<Vec3>(field));
      for (std::size_t j = cloud_.owned; j < points_.size(); ++j)
        for (int a = 0; a < 3; ++a) points_[j].v[first + a] = static_cast<Number>(field[j][a]);
    }
  }

  /// y = sum_j g_ij c_ij x_ji, and the six of x_ji (x) x_ji, of the points begin .. end, from that of point `begin` on.
  template <class Weight>
  void effects(const Weight* g, int begin, int end, Number* y) const {
    run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
      neighbours_.image.empty() ? add_up<false>(g, 0, begin, end, y) : add_up<true>(g, 0, begin, end, y);
    });
  }
  /// The same with g_ij (1 + c_ij), what the weights become.
  template <class Weight>
  void changed_sums(const Weight* g, int begin, int end, Number* y) const {
    run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
      neighbours_.image.empty() ? add_up<false>(g, 1, begin, end, y) : add_up<true>(g, 1, begin, end, y);
    });
  }

  /// What the unknowns of a point do to the point itself: of a symmetric matrix the upper triangle, row by row, but the
  /// rows of mixed components, which hold nothing that those before do not hold, too; and sum_j g_ij x_ji. With
  /// tensors.
  struct Block {
    std::array<Number, 3> first;
    std::array<Number, 39> upper;
  };
  template <class Weight>
  Block block(const Weight* g, int i) const {
    Block B;
    run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
      neighbours_.image.empty() ? add_up_block<false>(g, i, B) : add_up_block<true>(g, i, B);
    });
    return B;
  }

  /// Calls use(i, n, c_ij), which must be CALOR_ALWAYS_INLINE, for all entries; the same bits for (j, i).
  template <class Use>
  void for_each_change(const Use& use) const {
    run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
      neighbours_.image.empty() ? use_changes<false>(use) : use_changes<true>(use);
    });
  }

 private:
  static constexpr int parts = unknowns / 3;  ///< lambda, diagonal and mixed components of tau
  using Places = Doubles<4>;
  using Vector __attribute__((vector_size(4 * sizeof(Number)))) = Number;

  CALOR_ALWAYS_INLINE static Places load(const double* x) { return *reinterpret_cast<const UnalignedDoubles<4>*>(x); }
  CALOR_ALWAYS_INLINE static Vector load_numbers(const Number* v) {
    using Unaligned __attribute__((vector_size(4 * sizeof(Number)), aligned(sizeof(Number)), may_alias)) = Number;
    return *reinterpret_cast<const Unaligned*>(v);
  }

  /// One line of a cache. Vectors of four are loaded from x and from any three unknowns: their last number belongs to
  /// what follows and is multiplied by 0.
  struct alignas(64) Point {
    double x[3] = {};
    Number v[tensors ? 10 : 5] = {};

    CALOR_ALWAYS_INLINE Places place() const { return load(x); }
    CALOR_ALWAYS_INLINE Vector part(int f) const { return load_numbers(v + 3 * f); }
  };
  struct Reflection {
    double place_sign[4], shift[4];
    Number sign[4], mixed_sign[4];
  };
  struct Pair {
    Vector x, squares, mixed;  ///< x_ji, xx yy zz, xy xz yz
    Vector change;             ///< the same number four times
  };

  template <bool has_images>
  CALOR_ALWAYS_INLINE inline Pair pair(int i, std::int64_t n) const {
    const Point &own = points_[i], &other = points_[neighbours_.column[n]];
    const Reflection* image = has_images ? &mirrors_[neighbours_.image[n]] : nullptr;
    Places place = other.place();
    if constexpr (has_images)
      place = (load(image->place_sign) * place - own.place()) + load(image->shift);
    else
      place -= own.place();
    place = __builtin_shufflevector(place, Places{}, 0, 1, 2, 4);

    Pair pair;
    pair.x = __builtin_convertvector(place, Vector);
    Vector lambda = other.part(0);
    if constexpr (has_images) lambda *= load_numbers(image->sign);
    Vector c = (own.part(0) - lambda) * pair.x;
    if constexpr (tensors) {
      pair.squares = pair.x * pair.x;
      pair.mixed =
          __builtin_shufflevector(pair.x, pair.x, 0, 0, 1, 3) * __builtin_shufflevector(pair.x, pair.x, 1, 2, 2, 3);
      Vector mixed = other.part(2);
      if constexpr (has_images) mixed *= load_numbers(image->mixed_sign);
      c += (own.part(1) + other.part(1)) * pair.squares + (own.part(2) + mixed) * pair.mixed;
    }
    c += __builtin_shufflevector(c, c, 1, 0, 3, 2);
    pair.change = c + __builtin_shufflevector(c, c, 2, 3, 0, 1);
    return pair;
  }

  template <bool has_images, class Use>
  CALOR_ALWAYS_INLINE inline void use_changes(const Use& use) const {
    for (int i = 0; i < cloud_.owned; ++i)
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) use(i, n, pair<has_images>(i, n).change[0]);
  }

  template <bool has_images, class Weight>
  CALOR_ALWAYS_INLINE inline void add_up(const Weight* g, Number kept, int begin, int end, Number* y) const {
    for (int i = begin; i < end; ++i) {
      // Two sums, so that one addition need not wait for the other.
      Vector sum[2][parts] = {};
      const auto add = [&](std::int64_t n, int s) CALOR_ALWAYS_INLINE {
        const Pair p = pair<has_images>(i, n);
        const Vector w = static_cast<Number>(g[n]) * (kept + p.change);
        sum[s][0] += w * p.x;
        if constexpr (tensors) sum[s][1] += w * p.squares, sum[s][2] += w * p.mixed;
      };
      std::int64_t n = neighbours_.row[i];
      const std::int64_t last = neighbours_.row[i + 1];
      for (; n + 2 <= last; n += 2) add(n, 0), add(n + 1, 1);
      if (n < last) add(n, 0);
      for (int f = 0; f < parts; ++f)
        for (int a = 0; a < 3; ++a) *y++ = sum[0][f][a] + sum[1][f][a];
    }
  }

  template <bool has_images, class Weight>
  CALOR_ALWAYS_INLINE inline void add_up_block(const Weight* g, int i, Block& B) const {
    Vector first = {}, rows[6][3] = {};
    for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      const Pair p = pair<has_images>(i, n);
      const Number weight = static_cast<Number>(g[n]);
      const Vector v[3] = {p.x, p.squares, p.mixed};
      first += weight * p.x;
#pragma GCC unroll 6
      for (int a = 0; a < 6; ++a) {
        const Number w = weight * v[a / 3][a % 3];
        for (int f = a / 3; f < 3; ++f) rows[a][f] += w * v[f];
      }
    }
    for (int a = 0; a < 3; ++a) B.first[a] = first[a];
    Number* out = B.upper.data();
    for (int a = 0; a < 6; ++a)
      for (int b = a; b < 9; ++b) *out++ = rows[a][b / 3][b % 3];
  }

  const Cloud& cloud_;
  const Neighbours& neighbours_;
  std::vector<Point> points_;
  std::vector<Reflection> mirrors_;
};

}  // namespace calor
