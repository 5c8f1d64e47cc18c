#include "conduction/mls.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "base/cholesky.hpp"

namespace calor {

namespace {

constexpr double largest_condition = 1e10;

struct Weight {
  double value, slope;  ///< w(s), w'(s) / s
};

Weight quartic(double s) { return {1 - s * s * (6 - s * (8 - 3 * s)), -12 * (1 - s) * (1 - s)}; }

Weight wendland(double s) {
  const double r = 1 - s, r2 = r * r, r5 = r2 * r2 * r;
  return {r5 * r * (3 + s * (18 + 35 * s)) / 3, -56.0 / 3 * r5 * (1 + 5 * s)};
}

/// Weights of the nodes into phi, and their gradients where they are asked for.
void weigh(MlsWeight kind, const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R, std::span<double> phi,
           std::span<Vec3> gradient) {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Vec3 u = quotient(nodes[k] - x, R[k]);
    const double s = std::min(1.0, norm(u));
    const Weight w = kind == MlsWeight::quartic ? quartic(s) : wendland(s);
    phi[k] = w.value;
    if (!gradient.empty()) gradient[k] = -w.slope * quotient(u, R[k]);
  }
}

/// The fit around one place x in D dimensions, by the moment matrix A = sum_k w_k p_k p_k^T.
template <int D, int degree>
class Fit {
 public:
  static constexpr int M = degree == 1 ? D + 1 : (D + 1) * (D + 2) / 2;
  using Vector = std::array<double, M>;

  Fit(const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R) : x_(x), nodes_(nodes) {
    for (const Vec3& r : R)
      for (int a = 0; a < D; ++a) H_[a] = std::max(H_[a], r[a]);
    for (int a = 0; a < D; ++a) by_H_[a] = 1 / H_[a];
  }

  /// The polynomials at node k: 1, then u_a = (x_k - x)_a / H_a, then their products.
  Vector basis(std::size_t k) const {
    const Vec3 d = nodes_[k] - x_;
    Vector p;
    p[0] = 1;
    for (int a = 0; a < D; ++a) p[1 + a] = d[a] * by_H_[a];
    if constexpr (degree == 2)
      for (int a = 1, m = D; a <= D; ++a)
        for (int b = a; b <= D; ++b) p[++m] = p[a] * p[b];
    return p;
  }

  void assemble(std::span<const double> w) {
    auto A = A_;  // which no weight can be a part of, for the compiler
    for (std::size_t k = 0; k < w.size(); ++k) {
      const Vector p = basis(k);
      for (int i = 0; i < M; ++i)
        for (int j = 0; j <= i; ++j) A[i][j] += w[k] * p[i] * p[j];
    }
    A_ = A;
  }

  /// A g = e_1, phi_k = w_k p_k.g;
  /// A g_,i = e_{1+i} / H_i - A_,i g, phi_k,i = w_k p_k.g_,i + w_k,i p_k.g: x moves, the centre of the basis does not.
  bool shape(std::span<double> phi, std::span<Vec3> gradient) {
    if (nodes_.size() < M) return false;
    assemble(phi);
    const Cholesky<M> factor(A_);
    if (!(factor.pivot_ratio() * largest_condition > 1)) return false;
    Vector g{1};
    factor.solve(g);
    std::array<Vector, D> g_i{};
    for (int i = 0; i < D; ++i) g_i[i][1 + i] = by_H_[i];
    for (std::size_t k = 0; k < gradient.size(); ++k) {
      const Vector p = basis(k);
      gradient[k] *= product(p, g);
      for (int i = 0; i < D; ++i)
        for (int m = 0; m < M; ++m) g_i[i][m] -= gradient[k][i] * p[m];
    }
    if (!gradient.empty())
      for (Vector& b : g_i) factor.solve(b);
    for (std::size_t k = 0; k < phi.size(); ++k) {
      const Vector p = basis(k);
      if (!gradient.empty())
        for (int i = 0; i < D; ++i) gradient[k][i] += phi[k] * product(p, g_i[i]);
      phi[k] *= product(p, g);
    }
    return true;
  }

  /// By the eigenvalues of A.
  double condition() const {
    Eigen::MatrixXd A(M, M);
    for (int i = 0; i < M; ++i)
      for (int j = 0; j < M; ++j) A(i, j) = A_[i][j];
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A, Eigen::EigenvaluesOnly);  // looks at i >= j only
    const double low = eigen.eigenvalues()[0], high = eigen.eigenvalues()[M - 1];
    return low > 1e-16 * high ? high / low : std::numeric_limits<double>::infinity();
  }

 private:
  static double product(const Vector& a, const Vector& b) {
    double sum = 0;
    for (int m = 0; m < M; ++m) sum += a[m] * b[m];
    return sum;
  }

  const Vec3 x_;
  std::span<const Vec3> nodes_;
  Vec3 H_, by_H_;
  std::array<Vector, M> A_{};  ///< j <= i of A_[i][j]
};

/// Calls use(fit) with the fit of this dimension and degree.
template <class Use>
auto with_fit(const MovingLeastSquares& mls, const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R,
              Use use) {
  const auto of_degree = [&]<int D>() {
    return mls.degree == 1 ? use(Fit<D, 1>(x, nodes, R)) : use(Fit<D, 2>(x, nodes, R));
  };
  return mls.dimension == 1   ? of_degree.template operator()<1>()
         : mls.dimension == 2 ? of_degree.template operator()<2>()
                              : of_degree.template operator()<3>();
}

}  // namespace

bool MovingLeastSquares::evaluate(const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R,
                                  std::span<double> phi, std::span<Vec3> gradient) const {
  phi = phi.first(nodes.size());
  if (!gradient.empty()) gradient = gradient.first(nodes.size());
  weigh(weight, x, nodes, R, phi, gradient);
  return with_fit(*this, x, nodes, R, [&](auto fit) { return fit.shape(phi, gradient); });
}

double MovingLeastSquares::condition(const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R) const {
  std::vector<double> w(nodes.size());
  weigh(weight, x, nodes, R, w, {});
  return with_fit(*this, x, nodes, R, [&](auto fit) {
    fit.assemble(w);
    return fit.condition();
  });
}

}  // namespace calor
