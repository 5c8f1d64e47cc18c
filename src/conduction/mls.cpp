#include "conduction/mls.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

namespace calor {

namespace {

constexpr double largest_condition = 1e10;

struct Quartic {
  static double value(double s) { return 1 - s * s * (6 - s * (8 - 3 * s)); }
  static double slope(double s) { return -12 * (1 - s) * (1 - s); }  // w'(s) / s
};

struct Wendland {
  static double fifth(double a) { return a * a * a * a * a; }
  static double value(double s) { return fifth(1 - s) * (1 - s) * (3 + s * (18 + 35 * s)) / 3; }
  static double slope(double s) { return -56.0 / 3 * fifth(1 - s) * (1 + 5 * s); }
};

constexpr int size_of_basis(int D, int degree) { return degree == 1 ? D + 1 : (D + 1) * (D + 2) / 2; }

/// The fit around one place x in D dimensions.
template <int D, int degree, class Weight>
class Fit {
 public:
  static constexpr int M = size_of_basis(D, degree);
  using Vector = Eigen::Matrix<double, M, 1>;
  using Matrix = Eigen::Matrix<double, M, M>;

  Fit(const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R) : x_(x), nodes_(nodes), R_(R) {
    for (const Vec3& r : R)
      for (int a = 0; a < D; ++a) H_[a] = std::max(H_[a], r[a]);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const Vector p = basis(k);
      A_.noalias() += Weight::value(s(k)) * p * p.transpose();
    }
  }

  /// A g = e_1, phi_k = w_k p_k.g;
  /// A g_,i = e_{1+i} / H_i - A_,i g, phi_k,i = w_k p_k.g_,i + w_k,i p_k.g: x moves, the centre of the basis does not.
  bool shape(std::span<double> phi, std::span<Vec3> gradient) const {
    if (nodes_.size() < M) return false;
    const Eigen::LLT<Matrix> factor(A_);
    if (factor.info() != Eigen::Success) return false;
    const auto pivots = factor.matrixLLT().diagonal();
    const double ratio = pivots.minCoeff() / pivots.maxCoeff();
    if (!(ratio * ratio * largest_condition > 1)) return false;

    const Vector g = factor.solve(Vector::Unit(0));
    Eigen::Matrix<double, M, D> rhs = Eigen::Matrix<double, M, D>::Zero();
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const Vector p = basis(k);
      const double pg = p.dot(g);
      phi[k] = Weight::value(s(k)) * pg;
      if (gradient.empty()) continue;
      gradient[k] = pg * weight_gradient(k);
      for (int i = 0; i < D; ++i) rhs.col(i) -= gradient[k][i] * p;
    }
    if (gradient.empty()) return true;
    for (int i = 0; i < D; ++i) rhs(1 + i, i) += 1 / H_[i];
    const Eigen::Matrix<double, M, D> g_i = factor.solve(rhs);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const Eigen::Matrix<double, 1, D> wpg = Weight::value(s(k)) * basis(k).transpose() * g_i;
      for (int i = 0; i < D; ++i) gradient[k][i] += wpg[i];
    }
    return true;
  }

  double condition() const {
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A_, Eigen::EigenvaluesOnly);
    const double low = eigen.eigenvalues()[0], high = eigen.eigenvalues()[M - 1];
    return low > 1e-16 * high ? high / low : std::numeric_limits<double>::infinity();
  }

 private:
  double s(std::size_t k) const { return std::min(1.0, norm(quotient(nodes_[k] - x_, R_[k]))); }
  Vec3 weight_gradient(std::size_t k) const {
    return Weight::slope(s(k)) * quotient(x_ - nodes_[k], product(R_[k], R_[k]));
  }
  Vector basis(std::size_t k) const {
    Vec3 u;
    Vector p;
    p[0] = 1;
    for (int a = 0; a < D; ++a) p[1 + a] = u[a] = (nodes_[k][a] - x_[a]) / H_[a];
    if constexpr (degree == 2) {
      int m = D;
      for (int a = 0; a < D; ++a)
        for (int b = a; b < D; ++b) p[++m] = u[a] * u[b];
    }
    return p;
  }

  const Vec3 x_;
  std::span<const Vec3> nodes_;
  std::span<const Vec3> R_;
  Vec3 H_;
  Matrix A_ = Matrix::Zero();
};

/// Calls use(fit) with the fit of this dimension, degree and weight.
template <int D, int degree, class Use>
auto with_weight(MlsWeight weight, const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R, Use use) {
  return weight == MlsWeight::quartic ? use(Fit<D, degree, Quartic>(x, nodes, R))
                                      : use(Fit<D, degree, Wendland>(x, nodes, R));
}

template <int D, class Use>
auto with_degree(const MovingLeastSquares& mls, const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R,
                 Use use) {
  return mls.degree == 1 ? with_weight<D, 1>(mls.weight, x, nodes, R, use)
                         : with_weight<D, 2>(mls.weight, x, nodes, R, use);
}

template <class Use>
auto with_fit(const MovingLeastSquares& mls, const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R,
              Use use) {
  return mls.dimension == 1   ? with_degree<1>(mls, x, nodes, R, use)
         : mls.dimension == 2 ? with_degree<2>(mls, x, nodes, R, use)
                              : with_degree<3>(mls, x, nodes, R, use);
}

}  // namespace

bool MovingLeastSquares::evaluate(const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R,
                                  std::span<double> phi, std::span<Vec3> gradient) const {
  return with_fit(*this, x, nodes, R, [&](const auto& fit) { return fit.shape(phi, gradient); });
}

double MovingLeastSquares::condition(const Vec3& x, std::span<const Vec3> nodes, std::span<const Vec3> R) const {
  return with_fit(*this, x, nodes, R, [](const auto& fit) { return fit.condition(); });
}

}  // namespace calor
