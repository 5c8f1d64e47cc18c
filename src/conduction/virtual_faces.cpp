#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/components.hpp"
#include "conduction/correction.hpp"
#include "conduction/faces.hpp"
#include "conduction/fingerprint.hpp"
#include "conduction/linear_algebra.hpp"
#include "conduction/sph.hpp"

namespace calor {

namespace {

constexpr double smoothing = 1;
/// Of the diagonal: the second moments are over-determined, so they must not be hard.
constexpr double softness = 1e-3;
/// Steps of the fit and the least eigenvalue that it damps. What they leave of the moments shows in no error: on
/// jittered squares and cubes 15 steps down to 0.08 leave errors within 5 % of those of 2000, on meshes of rings 30
/// down to 0.02 leave 3 % more.
constexpr int steps_of_fit = 120;
constexpr double least_of_fit = 0.00125;
constexpr int most_polish_iterations = 20000;

/// Area vectors of the directed pairs, a_ij = -a_ji to the last bit, from potentials at the points, psi_i (a vector)
/// and m_i (a tensor, m_i[b] for the axis b):
///   a_ij = a0_ij + w_ij [psi_i - psi_j + 1/2 (m_i + m_j) x_ji].
/// With Q the map from a to (sum_j a_ij, 1/2 sum_j a_ij (x) x_ji), the potentials solve
/// (Q w Q^T + soft rows) z = goal - Q a0: the least change of a in the metric 1/w.
class AreaVectors {
 public:
  AreaVectors(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> w)
      : cloud_(cloud),
        neighbours_(neighbours),
        w_(w),
        a_(w.size()),
        psi_(cloud.local()),
        m_{psi_, psi_, psi_},
        diagonal_(cloud.owned),
        soft_(cloud.owned) {
    for (int i = 0; i < cloud.owned; ++i) {
      soft_[i] = soft(i);
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const Vec3 s = cloud.mean_metric(i, neighbours.column[n]), xi = quotient(offset(i, n), s);
        a_[n] = w[n] / dot(xi, xi) * quotient(xi, s);
        diagonal_[i] += w[n];
      }
    }
  }

  const std::vector<Vec3>& values() const { return a_; }

  /// Towards closed cells, sum_j a_ij = -A_i, with the moments of the coordinates, 1/2 sum_j a_ij (x) x_ji = V_i I.
  void fit() {
    std::vector<Rows> r(cloud_.owned), p(r.size(), Rows::Zero()), z(p);
    std::vector<Block> inverse(r.size());
    for (int i = 0; i < cloud_.owned; ++i) r[i] = lack(i), inverse[i] = inverse_of_block(i);
    // The blocks bound the matrix by twice themselves, as every pair does to its two points.
    ChebyshevSteps steps({.least = least_of_fit, .largest = 2});
    while (steps.step < steps_of_fit) {
      steps.advance();
      for (int i = 0; i < cloud_.owned; ++i) {
        p[i] = inverse[i] * r[i] + steps.beta * p[i];
        z[i] += steps.alpha * p[i];
      }
      if (steps.step == steps_of_fit) break;  // what remains is of no use
      set_potentials(p);
      for (int i = 0; i < cloud_.owned; ++i) r[i] -= steps.alpha * effect(i, p[i]);
    }
    set_potentials(z);
    change();
  }

  /// Closes the cells to round-off: a graph Laplacian in psi. Returns the iterations.
  int close(const Components& bodies) {
    for (std::vector<Vec3>& m : m_) std::ranges::fill(m, Vec3{});
    std::vector<Vec3> R(cloud_.owned), z(R.size());
    Vec3 size;
    for (int i = 0; i < cloud_.owned; ++i) {
      R[i] = -cloud_.plane_area(i);
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) R[i] -= a_[n];
      const Vec3 face = face_size(cloud_, i);
      for (int c = 0; c < cloud_.dimension; ++c) size[c] = std::max(size[c], face[c]);
    }
    remove_means(bodies, R);
    const auto set = [&](std::span<const double> p) {
      for (int i = 0; i < cloud_.owned; ++i) psi_[i] = {p[3 * i], p[3 * i + 1], p[3 * i + 2]};
      cloud_.halo.update(std::span<Vec3>(psi_));
    };
    const LinearMap laplacian = [&](std::span<const double> p, std::span<double> y) {
      set(p);
      for (int i = 0; i < cloud_.owned; ++i) {
        Vec3 sum;
        for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n)
          sum += w_[n] * (psi_[i] - psi_[neighbours_.column[n]]);
        for (int c = 0; c < 3; ++c) y[3 * i + c] = sum[c];
      }
    };
    const LinearMap scaling = [&](std::span<const double> r, std::span<double> y) {
      for (std::size_t k = 0; k < r.size(); ++k) y[k] = r[k] / diagonal_[k / 3];
    };
    const double largest = max(cloud_.comm, std::max({size.x, size.y, size.z})),
                 round_off = 1e-15 * largest * std::sqrt(static_cast<double>(cloud_.count));
    const auto numbers = [](std::vector<Vec3>& v) { return std::span(&v.data()->x, 3 * v.size()); };
    const auto solved =
        conjugate_gradients(cloud_.comm, laplacian, scaling, numbers(R), numbers(z),
                            {.relative = 1e-13, .absolute = round_off, .iterations = most_polish_iterations});
    set(numbers(z));
    change();
    return solved.iterations;
  }

 private:
  /// Of a point: a row of psi and one of every m[b], a column a component of the area vectors.
  using Rows = Eigen::Matrix<double, 4, 3>;
  using Block = Eigen::Matrix<double, 4, 4>;

  Vec3 offset(int i, std::int64_t n) const { return cloud_.x[neighbours_.column[n]] - cloud_.x[i]; }

  static Rows rows(const Vec3& sum, const std::array<Vec3, 3>& moment) {
    Rows out;
    for (int c = 0; c < 3; ++c) out.col(c) << sum[c], moment[0][c], moment[1][c], moment[2][c];
    return out;
  }

  /// What the area vectors of a point lack.
  Rows lack(int i) const {
    Vec3 sum = -cloud_.plane_area(i);
    std::array<Vec3, 3> moment = {};
    for (int b = 0; b < cloud_.dimension; ++b) moment[b][b] = cloud_.volume[i];
    for (int b = 0; cloud_.axisymmetric && b < 2; ++b) moment[b].x += cloud_.moment[i][b];
    for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      const Vec3 half = 0.5 * offset(i, n);
      sum -= a_[n];
      for (int b = 0; b < 3; ++b) moment[b] -= half[b] * a_[n];
    }
    return rows(sum, moment);
  }

  /// The soft row of m[b]: of the diagonal that neighbours alike in all directions would give, so that the faces turn
  /// with the body.
  Vec3 soft(int i) const {
    double trace = 0;
    for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      const Vec3 xi = quotient(offset(i, n), cloud_.metric[i]);
      trace += w_[n] * dot(xi, xi);
    }
    const Vec3& s = cloud_.metric[i];
    return softness * trace / (4 * cloud_.dimension) * product(s, s);
  }

  Block inverse_of_block(int i) const {
    Block B = Block::Zero();
    for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      const Vec3 half = 0.5 * offset(i, n);
      const Eigen::Vector4d v(1, half.x, half.y, half.z);
      B += w_[n] * v * v.transpose();
    }
    for (int b = 0; b < 3; ++b)
      if (b < cloud_.dimension)
        B(1 + b, 1 + b) += soft_[i][b];
      else
        B(1 + b, 1 + b) = 1;
    return B.llt().solve(Block::Identity());
  }

  /// psi_i - psi_j + 1/2 (m_i + m_j) x_ji: changes its sign, and no bit, with the direction of the pair.
  Vec3 drop(int i, std::int64_t n) const {
    const int j = neighbours_.column[n];
    const Vec3 half = 0.5 * offset(i, n);
    return (psi_[i] - psi_[j]) +
           (half.x * (m_[0][i] + m_[0][j]) + half.y * (m_[1][i] + m_[1][j]) + half.z * (m_[2][i] + m_[2][j]));
  }

  /// A row of the matrix times the potentials, which are p at the point.
  Rows effect(int i, const Rows& p) const {
    Vec3 sum;
    std::array<Vec3, 3> moment = {};
    for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      const Vec3 half = 0.5 * offset(i, n), change = w_[n] * drop(i, n);
      sum += change;
      for (int b = 0; b < 3; ++b) moment[b] += half[b] * change;
    }
    Rows out = rows(sum, moment);
    for (int b = 0; b < cloud_.dimension; ++b) out.row(1 + b) += soft_[i][b] * p.row(1 + b);
    return out;
  }

  void set_potentials(const std::vector<Rows>& z) {
    for (int i = 0; i < cloud_.owned; ++i) {
      psi_[i] = {z[i](0, 0), z[i](0, 1), z[i](0, 2)};
      for (int b = 0; b < 3; ++b) m_[b][i] = {z[i](1 + b, 0), z[i](1 + b, 1), z[i](1 + b, 2)};
    }
    cloud_.halo.update(std::span<Vec3>(psi_));
    for (std::vector<Vec3>& m : m_) cloud_.halo.update(std::span<Vec3>(m));
  }

  void change() {
    for (int i = 0; i < cloud_.owned; ++i)
      for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) a_[n] += w_[n] * drop(i, n);
  }

  /// What no differences of potentials balance: the mean of R over every body.
  void remove_means(const Components& bodies, std::span<Vec3> R) const {
    const auto count = static_cast<std::size_t>(bodies.count);
    std::vector<double> columns(4 * count * R.size());
    for (std::size_t i = 0; i < R.size(); ++i) {
      double* row = columns.data() + 4 * (count * i + static_cast<std::size_t>(bodies.of[i]));
      row[0] = R[i].x, row[1] = R[i].y, row[2] = R[i].z, row[3] = 1;
    }
    const auto s = sums(cloud_.comm, columns, static_cast<int>(4 * count));
    for (std::size_t i = 0; i < R.size(); ++i) {
      const double* of_body = s.data() + 4 * static_cast<std::size_t>(bodies.of[i]);
      R[i] -= 1 / of_body[3] * Vec3{of_body[0], of_body[1], of_body[2]};
    }
  }

  const Cloud& cloud_;
  const Neighbours& neighbours_;
  const std::span<const double> w_;  // of the directed pairs
  std::vector<Vec3> a_;
  std::vector<Vec3> psi_;
  std::array<std::vector<Vec3>, 3> m_;
  std::vector<double> diagonal_;  // of the rows of psi
  std::vector<Vec3> soft_;        // of the soft rows of m, axis by axis
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

/// Area vectors and iterations from the cloud's cache, or by `solve`; `from`: all that they follow from.
void keep_areas(const Cloud& cloud, const Fingerprint& from, std::vector<Vec3>& area, FaceReport& report,
                const std::function<void()>& solve) {
  std::vector<double> components, iterations;
  cloud.cache->get(cloud.comm, "faces", Cache::Owner::rank, from, {&components, &iterations}, [&] {
    solve();
    components.clear();
    for (const Vec3& a : area) components.insert(components.end(), {a.x, a.y, a.z});
    iterations = {static_cast<double>(report.iterations)};
  });
  area.clear();
  for (auto c = components.begin(); c != components.end(); c += 3) area.push_back({c[0], c[1], c[2]});
  report.iterations = static_cast<int>(iterations[0]);
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

  std::vector<Vec3> area;
  const auto solve = [&] {
    AreaVectors vectors(cloud, neighbours, w);
    vectors.fit();
    report.iterations = vectors.close(components(cloud, neighbours));
    area = vectors.values();
  };
  if (cloud.cache)
    keep_areas(cloud, fingerprint(cloud, neighbours).add(w), area, report, solve);
  else
    solve();
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
