#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/components.hpp"
#include "conduction/correction.hpp"
#include "conduction/faces.hpp"
#include "conduction/linear_algebra.hpp"
#include "conduction/sph.hpp"

namespace calor {

namespace {

constexpr double smoothing = 1;
/// Of the diagonal: the second moments are over-determined, so they must not be hard.
constexpr double softness = 1e-3;
constexpr int most_iterations = 2000, most_polish_iterations = 20000;

/// One Cartesian component c of the area vectors, as potentials at the points:
///   a_ij = a0_ij + w_ij [psi_i - psi_j + 1/2 (m_i + m_j).x_ji],
/// antisymmetric by construction. With Q the map from a to (sum_j a_ij, 1/2 sum_j a_ij x_ji / s_i), the potentials
/// solve (Q w Q^T + soft rows) z = goal - Q a0: the least change of a in the metric 1/w.
class Component {
 public:
  Component(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> w)
      : cloud_(cloud),
        neighbours_(neighbours),
        bodies_(components(cloud, neighbours)),
        D_(cloud.dimension),
        w_(w.begin(), w.end()),
        psi_(cloud.local()),
        m_(cloud.local()),
        diagonal_(cloud.owned),
        diagonal_m_(cloud.owned) {
    for (int i = 0; i < cloud.owned; ++i) {
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const Vec3 r = quotient(offset(i, n), cloud.metric[i]);
        diagonal_[i] += w_[n];
        // The diagonal that neighbours alike in all directions would give, so that the faces turn with the body.
        diagonal_m_[i] += w_[n] * dot(r, r) / (4 * D_);
      }
    }
  }

  /// Solves for component c of a, which holds a0 on entry. Returns the iterations.
  int solve(int c, std::span<double> a) {
    const std::size_t rows = 1 + D_;
    std::vector<double> goal(rows * cloud_.owned), z(goal.size());
    for (int i = 0; i < cloud_.owned; ++i) {
      double* b = goal.data() + rows * i;
      b[0] = -cloud_.plane_area(i)[c];
      b[1 + c] = cloud_.volume[i] / cloud_.metric[i][c];
      for (int k = 0; cloud_.axisymmetric && c == 0 && k < D_; ++k)
        b[1 + k] += cloud_.moment[i][k] / cloud_.metric[i][k];
      subtract_moments(i, a, b);
    }
    const LinearMap normal_matrix = [&](std::span<const double> p, std::span<double> y) {
      set_potentials(p);
      for (int i = 0; i < cloud_.owned; ++i) {
        double sum = 0;
        Vec3 moment;
        for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
          const double change = w_[n] * drop(i, n);
          sum += change;
          moment += change * offset(i, n);
        }
        double* out = y.data() + rows * i;
        out[0] = sum;
        for (int b = 0; b < D_; ++b)
          out[1 + b] = 0.5 * moment[b] / cloud_.metric[i][b] + softness * diagonal_m_[i] * p[rows * i + 1 + b];
      }
    };
    const LinearMap scaling = [&](std::span<const double> r, std::span<double> y) {
      for (int i = 0; i < cloud_.owned; ++i)
        for (std::size_t k = 0; k < rows; ++k)
          y[rows * i + k] = r[rows * i + k] / (k == 0 ? diagonal_[i] : (1 + softness) * diagonal_m_[i]);
    };
    const auto solved = conjugate_gradients(cloud_.comm, normal_matrix, scaling, goal, z,
                                            {.relative = 1e-10, .iterations = most_iterations});
    set_potentials(z);
    for (int i = 0; i < cloud_.owned; ++i)
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) a[n] += w_[n] * drop(i, n);
    return solved.iterations + polish(c, a);
  }

 private:
  Vec3 offset(int i, std::int64_t n) const { return cloud_.x[neighbours_.column[n]] - cloud_.x[i]; }

  /// psi_i - psi_j + 1/2 (m_i + m_j).x_ji: changes its sign, and no bit, with the direction of the pair.
  double drop(int i, std::int64_t n) const {
    const int j = neighbours_.column[n];
    return (psi_[i] - psi_[j]) + 0.5 * dot(m_[i] + m_[j], offset(i, n));
  }

  void set_potentials(std::span<const double> z) {
    for (int i = 0; i < cloud_.owned; ++i) {
      const double* p = z.data() + static_cast<std::size_t>(1 + D_) * i;
      psi_[i] = p[0];
      for (int b = 0; b < D_; ++b) m_[i][b] = p[1 + b] / cloud_.metric[i][b];
    }
    cloud_.halo.update(std::span<double>(psi_));
    cloud_.halo.update(std::span<Vec3>(m_));
  }

  void subtract_moments(int i, std::span<const double> a, double* b) const {
    for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      b[0] -= a[n];
      for (int k = 0; k < D_; ++k) b[1 + k] -= 0.5 * a[n] * offset(i, n)[k] / cloud_.metric[i][k];
    }
  }

  /// What no differences of potentials balance: the mean of R over every body.
  void remove_means(std::span<double> R) const {
    const auto bodies = static_cast<std::size_t>(bodies_.count);
    std::vector<double> columns(2 * bodies * R.size());
    for (std::size_t i = 0; i < R.size(); ++i) {
      double* row = columns.data() + 2 * bodies * i + 2 * static_cast<std::size_t>(bodies_.of[i]);
      row[0] = R[i], row[1] = 1;
    }
    const auto s = sums(cloud_.comm, columns, static_cast<int>(2 * bodies));
    for (std::size_t i = 0; i < R.size(); ++i) R[i] -= s[2 * bodies_.of[i]] / s[2 * bodies_.of[i] + 1];
  }

  /// The hard rows alone, to round-off: a graph Laplacian in psi.
  int polish(int c, std::span<double> a) {
    std::ranges::fill(m_, Vec3{});
    std::vector<double> R(cloud_.owned), z(R.size());
    for (int i = 0; i < cloud_.owned; ++i) {
      R[i] = -cloud_.plane_area(i)[c];
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) R[i] -= a[n];
    }
    remove_means(R);
    const auto set = [&](std::span<const double> p) {
      std::ranges::copy(p, psi_.begin());
      cloud_.halo.update(std::span<double>(psi_));
    };
    const LinearMap laplacian = [&](std::span<const double> p, std::span<double> y) {
      set(p);
      for (int i = 0; i < cloud_.owned; ++i) {
        y[i] = 0;
        for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n)
          y[i] += w_[n] * (psi_[i] - psi_[neighbours_.column[n]]);
      }
    };
    const LinearMap scaling = [&](std::span<const double> r, std::span<double> y) {
      for (std::size_t i = 0; i < r.size(); ++i) y[i] = r[i] / diagonal_[i];
    };
    double size = 0;
    for (int i = 0; i < cloud_.owned; ++i) size = std::max(size, face_size(cloud_, i)[c]);
    size = max(cloud_.comm, size) * std::sqrt(static_cast<double>(cloud_.count));
    const auto solved =
        conjugate_gradients(cloud_.comm, laplacian, scaling, R, z,
                            {.relative = 1e-13, .absolute = 1e-15 * size, .iterations = most_polish_iterations});
    set(z);
    for (int i = 0; i < cloud_.owned; ++i)
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n)
        a[n] += w_[n] * (psi_[i] - psi_[neighbours_.column[n]]);
    return solved.iterations;
  }

  const Cloud& cloud_;
  const Neighbours& neighbours_;
  const Components bodies_;
  const int D_;
  std::vector<double> w_;  // of the directed pairs
  std::vector<double> psi_;
  std::vector<Vec3> m_;
  std::vector<double> diagonal_, diagonal_m_;  // of the rows of psi and m
};

/// 2 V_i V_j F |xi|^2 of the kernel in the metric, xi = x_ji / s_ij, scaled to sum_j w_ij = 2 D V_i.
std::vector<double> kernel_moments(const Cloud& cloud, const Neighbours& neighbours) {
  std::vector<double> w(neighbours.column.size());
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      const double square = square_in_spacings(cloud, neighbours, i, n);
      w[n] = cloud.volume[i] * cloud.volume[j] / cell_size(cloud, i, j) *
             cubic_spline_F(std::sqrt(square), smoothing, cloud.dimension) * square;
      if (cloud.axisymmetric) w[n] /= cloud.section(i, j);
    }
  }
  scale_sums(cloud, neighbours, std::span(cloud.volume).first(cloud.owned), w);
  return w;
}

void require_closed_surface(const Cloud& cloud) {
  // The faces would come out all the same, with a source of error that nothing else shows.
  constexpr double open = 1e-3;
  const CloudCheck is = check(cloud);
  if (is.area_sum > open || is.moment_sum > open)
    throw Error(
        Fault::bad_case,
        fmt::format("the surface of the cloud is not closed: its boundary areas add up to {:.2g} of their size, "
                    "their moments to {:.2g}",
                    is.area_sum, is.moment_sum),
        "correct the boundary areas of the points: both sums must vanish");
}

void measure(const Cloud& cloud, const Neighbours& neighbours, std::span<const Vec3> area, FaceReport& report) {
  const int D = cloud.dimension;
  std::vector<double> squares(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    Vec3 total = cloud.plane_area(i);
    std::array<Vec3, 3> moment = {};
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 r = cloud.x[neighbours.column[n]] - cloud.x[i];
      total += area[n];
      for (int c = 0; c < D; ++c) moment[c] += 0.5 * area[n][c] * r;
    }
    if (cloud.axisymmetric) moment[0] -= cloud.moment[i];
    report.residual = std::max(report.residual, norm(quotient(total, face_size(cloud, i))));
    for (int c = 0; c < D; ++c) {
      Vec3 off = (1 / cloud.volume[i]) * moment[c];
      off[c] -= 1;
      for (int b = 0; b < D; ++b) off[b] *= cloud.metric[i][c] / cloud.metric[i][b];
      squares[i] += dot(off, off) / (D * D);
    }
  }
  report.residual = max(cloud.comm, report.residual);
  report.moment_error = std::sqrt(sum(cloud.comm, squares) / static_cast<double>(cloud.count));
}

}  // namespace

double virtual_face_support() { return sph_support(smoothing); }

Faces virtual_faces(const Cloud& cloud, FaceReport& report) {
  report = {};
  require_closed_surface(cloud);
  const Neighbours neighbours = find_neighbours(cloud, sph_support(smoothing));
  require_neighbours(cloud, neighbours);
  report.pairs = total(cloud.comm, static_cast<std::int64_t>(neighbours.column.size()));
  const std::vector<double> w = kernel_moments(cloud, neighbours);

  Component component(cloud, neighbours, w);
  std::vector<Vec3> area(w.size());
  std::vector<double> a(w.size());
  for (int c = 0; c < cloud.dimension; ++c) {
    for (int i = 0; i < cloud.owned; ++i) {
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const int j = neighbours.column[n];
        const Vec3 s = cloud.mean_metric(i, j), xi = quotient(cloud.x[j] - cloud.x[i], s);
        a[n] = w[n] / dot(xi, xi) * xi[c] / s[c];
      }
    }
    report.iterations += component.solve(c, a);
    for (std::size_t n = 0; n < a.size(); ++n) area[n][c] = a[n];
  }
  measure(cloud, neighbours, area, report);
  constexpr double open = 1e-2;  // a surface that closes but for its digits leaves far less at every cell
  if (!(report.residual <= open))
    throw Error(
        Fault::numbers,
        fmt::format("no faces close the cells of this cloud: they are open by {:.2g} of a face", report.residual),
        "give the places where points see few others more of them: a smaller spacing");

  Faces faces;
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      const bool outward = cloud.id[i] < cloud.id[j];
      if (j < cloud.owned && !outward) continue;
      faces.x.push_back(0.5 * (cloud.x[i] + cloud.x[j]));
      faces.area.push_back(outward ? area[n] : -area[n]);
      faces.a.push_back(outward ? i : j);
      faces.b.push_back(outward ? j : i);
    }
  }
  return faces;
}

}  // namespace calor
