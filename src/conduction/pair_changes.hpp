#pragma once
// The sums over pairs that the corrections of weights iterate with: of relative changes of the weights,
//   c_ij = (lambda_i - lambda_j).x_ji                          of vectors, or
//   c_ij = (lambda_i - lambda_j).x_ji + x_ji.(tau_i + tau_j) x_ji     of vectors and symmetric tensors,
// their effect sum_j g_ij c_ij x_ji, and sum_j g_ij c_ij x_ji (x) x_ji.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
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
  /// Unknowns of a point: lambda, and with tensors the six of tau.
  static constexpr int unknowns = tensors ? 9 : 3;

  PairChanges(const Cloud& cloud, const Neighbours& neighbours) : cloud_(cloud), neighbours_(neighbours) {
    for (const Vec3& x : cloud.x) x_.push_back({x.x, x.y, x.z, 0});
    for (const Mirror& m : neighbours.mirrors) {
      const Vec3& s = m.sign;
      mirrors_.push_back(
          {Four{s.x, s.y, s.z, 0}, Four{m.shift.x, m.shift.y, m.shift.z, 0}, Four{s.x * s.y, s.x * s.z, s.y * s.z, 0}});
    }
    for (auto& field : fields_) field.resize(cloud.local());
    points_.resize(cloud.local());
  }

  /// The unknowns of the owned points, one point after the other; updates the ghosts. Collective.
  void set(std::span<const double> z) {
    for (int f = 0; f < parts; ++f) {
      for (int i = 0; i < cloud_.owned; ++i) {
        const double* at = z.data() + unknowns * static_cast<std::ptrdiff_t>(i) + 3 * f;
        fields_[f][i] = {at[0], at[1], at[2]};
      }
      cloud_.halo.update(std::span<Vec3>(fields_[f]));
      for (std::size_t i = 0; i < points_.size(); ++i)
        points_[i][f] = {fields_[f][i].x, fields_[f][i].y, fields_[f][i].z, 0};
    }
  }

  /// y = sum_j g_ij c_ij x_ji, and the six of x_ji (x) x_ji, of the owned points.
  void effects(std::span<const double> g, std::span<double> y) const {
    run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
      neighbours_.image.empty() ? add_up<false>(g.data(), y.data()) : add_up<true>(g.data(), y.data());
    });
  }

  /// Upper triangle, row by row, of the matrix that gives the effect on a point of its own unknowns; with tensors.
  using Block = std::array<double, 45>;
  std::vector<Block> blocks(std::span<const double> g) const {
    std::vector<Block> B(cloud_.owned);
    run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
      neighbours_.image.empty() ? add_up_blocks<false>(g.data(), B.data()) : add_up_blocks<true>(g.data(), B.data());
    });
    return B;
  }

  /// Calls use(i, n, c_ij) for all entries; the same bits for (j, i).
  template <class Use>
  void for_each_change(const Use& use) const {
    for (int i = 0; i < cloud_.owned; ++i)
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n)
        use(i, n, neighbours_.image.empty() ? at<false>(i, n).change : at<true>(i, n).change);
  }

 private:
  static constexpr int parts = tensors ? 3 : 1;  ///< lambda, diagonal and mixed components of tau
  using Vector = Doubles<4>;
  /// Three numbers and a zero, where vectors of four are loaded from.
  struct alignas(32) Four {
    double v[4];
    CALOR_ALWAYS_INLINE Vector load() const { return *reinterpret_cast<const UnalignedDoubles<4>*>(v); }
  };
  struct Reflection {
    Four sign, shift, mixed_sign;
  };
  struct Pair {
    Vector x, squares, mixed;  ///< x_ji, xx yy zz, xy xz yz
    double change;
  };

  template <bool has_images>
  CALOR_ALWAYS_INLINE inline Pair at(int i, std::int64_t n) const {
    const std::int32_t j = neighbours_.column[n];
    const Reflection* image = has_images ? &mirrors_[neighbours_.image[n]] : nullptr;
    const auto& own = points_[i];
    const auto& other = points_[j];
    Pair pair;
    Vector lambda = other[0].load();
    if constexpr (has_images) {
      pair.x = (image->sign.load() * x_[j].load() - x_[i].load()) + image->shift.load();
      lambda *= image->sign.load();
    } else {
      pair.x = x_[j].load() - x_[i].load();
    }
    Vector c = (own[0].load() - lambda) * pair.x;
    if constexpr (tensors) {
      using Indices __attribute__((vector_size(32))) = std::int64_t;
      pair.squares = pair.x * pair.x;
      pair.mixed = __builtin_shuffle(pair.x, Indices{0, 0, 1, 3}) * __builtin_shuffle(pair.x, Indices{1, 2, 2, 3});
      Vector mixed = other[2].load();
      if constexpr (has_images) mixed *= image->mixed_sign.load();
      c += (own[1].load() + other[1].load()) * pair.squares + (own[2].load() + mixed) * pair.mixed;
    }
    pair.change = (c[0] + c[1]) + c[2];
    return pair;
  }

  template <bool has_images>
  CALOR_ALWAYS_INLINE inline void add_up(const double* g, double* y) const {
    for (int i = 0; i < cloud_.owned; ++i) {
      Vector sum[parts] = {};
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
        const Pair pair = at<has_images>(i, n);
        const double s = g[n] * pair.change;
        sum[0] += s * pair.x;
        if constexpr (tensors) sum[1] += s * pair.squares, sum[2] += s * pair.mixed;
      }
      for (int f = 0; f < parts; ++f)
        for (int a = 0; a < 3; ++a) y[unknowns * static_cast<std::ptrdiff_t>(i) + 3 * f + a] = sum[f][a];
    }
  }

  template <bool has_images>
  CALOR_ALWAYS_INLINE inline void add_up_blocks(const double* g, Block* B) const {
    for (int i = 0; i < cloud_.owned; ++i) {
      Vector rows[9][3] = {};
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
        const Pair pair = at<has_images>(i, n);
        const Vector v[3] = {pair.x, pair.squares, pair.mixed};
#pragma GCC unroll 9
        for (int a = 0; a < 9; ++a) {
          const double w = g[n] * v[a / 3][a % 3];
          for (int f = a / 3; f < 3; ++f) rows[a][f] += w * v[f];
        }
      }
      double* out = B[i].data();
      for (int a = 0; a < 9; ++a)
        for (int b = a; b < 9; ++b) *out++ = rows[a][b / 3][b % 3];
    }
  }

  const Cloud& cloud_;
  const Neighbours& neighbours_;
  std::vector<Four> x_;
  std::vector<Reflection> mirrors_;
  std::array<std::vector<Vec3>, parts> fields_;  // for the halo
  std::vector<std::array<Four, parts>> points_;  // the same, packed
};

}  // namespace calor
