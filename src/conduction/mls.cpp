#include "conduction/mls.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "base/cholesky.hpp"
#include "base/lanes.hpp"

namespace calor {

namespace {

constexpr double largest_condition = 1e10;

/// The basis of D dimensions: 1, then u_a, then their products; and the distinct products of two of its members, of
/// which the moment matrix is made: for degree 2 in space 35, where the matrix has 55 entries.
template <int D, int degree>
struct Basis {
  static constexpr int M = degree == 1 ? D + 1 : (D + 1) * (D + 2) / 2;
  using Exponents = std::array<int, D>;

  std::array<Exponents, M> member{};
  int products = 0;
  std::array<std::pair<int, int>, M*(M + 1) / 2> factors{};  ///< of product n
  std::array<std::array<int, M>, M> product{};               ///< which one p_i p_j is

  constexpr Basis() {
    for (int a = 0; a < D; ++a) member[1 + a][a] = 1;
    for (int a = 0, m = D; degree == 2 && a < D; ++a)
      for (int b = a; b < D; ++b) ++m, ++member[m][a], ++member[m][b];
    for (int i = 0; i < M; ++i)
      for (int j = 0; j <= i; ++j) product[i][j] = product[j][i] = find(i, j);
  }
  constexpr Exponents exponents(int i, int j) const {
    Exponents sum{};
    for (int a = 0; a < D; ++a) sum[a] = member[i][a] + member[j][a];
    return sum;
  }
  constexpr int find(int i, int j) {
    for (int n = 0; n < products; ++n)
      if (exponents(factors[n].first, factors[n].second) == exponents(i, j)) return n;
    factors[products] = {i, j};
    return products++;
  }
};

template <class Values>
struct Weight {
  Values value, slope;  ///< w(s), w'(s) / s
};

template <class Values>
CALOR_ALWAYS_INLINE inline Weight<Values> quartic(Values s) {
  return {1 - s * s * (6 - s * (8 - 3 * s)), -12 * (1 - s) * (1 - s)};
}

template <class Values>
CALOR_ALWAYS_INLINE inline Weight<Values> wendland(Values s) {
  const Values r = 1 - s, r2 = r * r, r5 = r2 * r2 * r;
  return {r5 * r * (3 + s * (18 + 35 * s)) / 3, -56.0 / 3 * r5 * (1 + 5 * s)};
}

/// The nodes that count, and what becomes of them, one vector a node.
struct Nodes {
  std::span<const MlsNode> node;
  std::span<const std::uint8_t> sees;
  MlsPlaces::Lanes *phi, *slope;  ///< slope: null where it is not asked for
};

/// Fits around `width` of the places, from lane `first` on, by their moment matrices A = sum_k w_k p_k p_k^T.
template <int D, int degree, int width>
class Fits {
 public:
  static constexpr Basis<D, degree> basis{};
  static constexpr int M = basis.M;
  using Values = typename Vectors<width>::Values;
  using Flags = typename Vectors<width>::Flags;
  using Vector = std::array<Values, M>;
  using Matrix = std::array<Vector, M>;

  CALOR_ALWAYS_INLINE Fits(const MlsPlaces& places, const Nodes& nodes, int first) : nodes_(nodes), first_(first) {
    for (int a = 0; a < D; ++a) {
      x_[a] = of(places.x[a]), along_[a] = of(places.along[a]);
      by_H_[a] = Values{} + std::numeric_limits<double>::infinity();
    }
    for (int lane = 0; lane < width; ++lane) bit_[lane] = first + lane;
  }

  /// Weights into phi, and their slopes; 0 where a node does not count. Finds the scales of the polynomials.
  CALOR_ALWAYS_INLINE void weigh(MlsWeight kind) {
    const Values zero{};
    for (std::size_t k = 0; k < nodes_.node.size(); ++k) {
      const MlsNode& node = nodes_.node[k];
      const Flags sees = -(nodes_.sees[k] >> bit_ & 1);  // all bits or none
      Values square{}, towards{};                        // s^2 and u.(a / R), u = (x_k - x) / R
      for (int a = 0; a < D; ++a) {
        const Values u = (node.x[a] - x_[a]) * node.by_R[a];
        square += u * u;
        towards += u * (along_[a] * node.by_R[a]);
        by_H_[a] = chosen(sees & (node.by_R[a] < by_H_[a]), zero + node.by_R[a], by_H_[a]);
      }
      const Values s = root(chosen(square < 1, square, zero + 1));
      const Weight<Values> w = kind == MlsWeight::quartic ? quartic(s) : wendland(s);
      of(nodes_.phi[k]) = chosen(sees, w.value, zero);
      if (nodes_.slope) of(nodes_.slope[k]) = chosen(sees, -w.slope * towards, zero);
    }
  }

  /// A by its entries j <= i.
  CALOR_ALWAYS_INLINE Matrix moments() const {
    Values sums[basis.products] = {};
    for (std::size_t k = 0; k < nodes_.node.size(); ++k) {
      const Vector p = polynomials(k);
      const Values w = of(nodes_.phi[k]);
      Vector wp;
      for (int m = 0; m < M; ++m) wp[m] = w * p[m];
#pragma GCC unroll 35
      for (int n = 0; n < basis.products; ++n) sums[n] += wp[basis.factors[n].first] * p[basis.factors[n].second];
    }
    Matrix A;
    for (int i = 0; i < M; ++i)
      for (int j = 0; j <= i; ++j) A[i][j] = sums[basis.product[i][j]];
    return A;
  }

  /// A g = e_1, phi_k = w_k p_k.g; along a
  /// A g_a = sum_i a_i e_{1+i} / H_i - A_a g, phi_k,a = w_k p_k.g_a + w_k,a p_k.g: x moves, the centre of the basis
  /// does not. Returns the bits of the places that have a fit.
  CALOR_ALWAYS_INLINE unsigned shape() {
    const Cholesky<M, Values> factor(moments());
    Vector g{}, g_a{};
    g[0] = Values{} + 1;
    factor.solve(g);
    if (nodes_.slope) {
      for (int a = 0; a < D; ++a) g_a[1 + a] = along_[a] * by_H_[a];
      for (std::size_t k = 0; k < nodes_.node.size(); ++k) {
        const Vector p = polynomials(k);
        const Values part = of(nodes_.slope[k]) * product(p, g);
        of(nodes_.slope[k]) = part;
        for (int m = 0; m < M; ++m) g_a[m] -= part * p[m];
      }
      factor.solve(g_a);
    }
    for (std::size_t k = 0; k < nodes_.node.size(); ++k) {
      const Vector p = polynomials(k);
      const Values w = of(nodes_.phi[k]);
      if (nodes_.slope) of(nodes_.slope[k]) += w * product(p, g_a);
      of(nodes_.phi[k]) = w * product(p, g);
    }
    const Flags regular = factor.pivot_ratio() * largest_condition > 1;
    unsigned bits = 0;
    for (int lane = 0; lane < width; ++lane) bits |= static_cast<unsigned>(regular[lane] & 1) << (first_ + lane);
    return bits;
  }

 private:
  /// These places' part of a vector.
  CALOR_ALWAYS_INLINE UnalignedDoubles<width>& of(MlsPlaces::Lanes& v) const {
    return *reinterpret_cast<UnalignedDoubles<width>*>(v.data() + first_);
  }
  CALOR_ALWAYS_INLINE Values of(const MlsPlaces::Lanes& v) const { return Consecutive<width>{first_}(v.data()); }

  /// The polynomials at node k: 1, then u_a = (x_k - x)_a / H_a, then their products.
  CALOR_ALWAYS_INLINE Vector polynomials(std::size_t k) const {
    Vector p;
    p[0] = Values{} + 1;
    for (int a = 0; a < D; ++a) p[1 + a] = (nodes_.node[k].x[a] - x_[a]) * by_H_[a];
    if constexpr (degree == 2)
      for (int a = 1, m = D; a <= D; ++a)
        for (int b = a; b <= D; ++b) p[++m] = p[a] * p[b];
    return p;
  }

  CALOR_ALWAYS_INLINE static Values product(const Vector& a, const Vector& b) {
    Values sum{};
    for (int m = 0; m < M; ++m) sum += a[m] * b[m];
    return sum;
  }

  const Nodes nodes_;
  const int first_;
  std::array<Values, D> x_, along_, by_H_;
  Flags bit_;
};

/// Calls use.operator()<D, degree>() with those of the shape functions.
template <class Use>
auto with_basis(const MovingLeastSquares& mls, const Use& use) {
  const auto of_degree = [&]<int D>() {
    return mls.degree == 1 ? use.template operator()<D, 1>() : use.template operator()<D, 2>();
  };
  return mls.dimension == 1   ? of_degree.template operator()<1>()
         : mls.dimension == 2 ? of_degree.template operator()<2>()
                              : of_degree.template operator()<3>();
}

}  // namespace

unsigned MovingLeastSquares::evaluate(const MlsPlaces& places, std::span<const MlsNode> nodes,
                                      std::span<const std::uint8_t> sees, std::span<MlsPlaces::Lanes> phi,
                                      std::span<MlsPlaces::Lanes> slope) const {
  const Nodes all{nodes, sees, phi.data(), slope.empty() ? nullptr : slope.data()};
  return with_basis(*this, [&]<int D, int degree>() {
    unsigned fitted = 0;
    run_vectorised([&]<int width>() CALOR_ALWAYS_INLINE {
      for (int first = 0; first < places.count; first += width) {
        Fits<D, degree, width> fits(places, all, first);
        fits.weigh(weight);
        fitted |= fits.shape();
      }
    });
    return fitted;
  });
}

/// By the eigenvalues of A.
double MovingLeastSquares::condition(const Vec3& x, std::span<const MlsNode> nodes) const {
  const std::vector<std::uint8_t> sees(nodes.size(), 1);
  std::vector<MlsPlaces::Lanes> w(nodes.size());
  MlsPlaces place;
  place.add(x);
  return with_basis(*this, [&]<int D, int degree>() {
    Fits<D, degree, baseline_width> fits(place, {nodes, sees, w.data(), nullptr}, 0);
    fits.weigh(weight);
    const auto moments = fits.moments();
    const auto M = static_cast<int>(moments.size());
    Eigen::MatrixXd A(M, M);
    for (int i = 0; i < M; ++i)
      for (int j = 0; j <= i; ++j) A(i, j) = moments[i][j][0];
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A, Eigen::EigenvaluesOnly);  // looks at i >= j only
    const double low = eigen.eigenvalues()[0], high = eigen.eigenvalues()[M - 1];
    return low > 1e-16 * high ? high / low : std::numeric_limits<double>::infinity();
  });
}

}  // namespace calor
