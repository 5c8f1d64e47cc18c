#include "conduction/face_conduction.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/parallel.hpp"

namespace calor {

FaceConduction::FaceConduction(const Cloud& cloud, Faces faces, FaceRows rows, bool nodal)
    : Conduction(nodal ? Evaluation::nodes : Evaluation::nodes + 1),
      cloud_(cloud),
      faces_(std::move(faces)),
      rows_(std::move(rows)),
      nodal_(nodal) {
  for (std::size_t q = 0; q < faces_.size(); ++q)
    for (const int j : rows_.flux.columns(q)) two_point_ = two_point_ && (j == faces_.a[q] || j == faces_.b[q]);
  two_point_ = !any(cloud.comm, !two_point_);  // a rank of few faces must choose the same solvers as the others
  order_sides();
  find_coupled();
  if (nodal_ && two_point_) pack_pairs();
}

void FaceConduction::order_sides() {
  first_side_.assign(cloud_.owned + 1, 0);
  const auto for_each_side = [&](const auto& use) {
    for (std::size_t q = 0; q < faces_.size(); ++q) {
      if (faces_.a[q] < cloud_.owned) use(faces_.a[q], Side{static_cast<std::int32_t>(q), +1});
      if (faces_.b[q] >= 0 && faces_.b[q] < cloud_.owned) use(faces_.b[q], Side{static_cast<std::int32_t>(q), -1});
    }
  };
  for_each_side([&](int i, Side) { ++first_side_[i + 1]; });
  for (int i = 0; i < cloud_.owned; ++i) first_side_[i + 1] += first_side_[i];
  side_.resize(first_side_.back());
  auto next = first_side_;
  for_each_side([&](int i, Side s) { side_[next[i]++] = s; });
  // By the id of the other cell, so that sums over a cell do not depend on the number of ranks.
  for (int i = 0; i < cloud_.owned; ++i) {
    const auto other = [&](const Side& s) {
      const int j = s.sign > 0 ? faces_.b[s.face] : faces_.a[s.face];
      return std::pair(j < 0 ? -1 : cloud_.id[j], s.face);
    };
    std::sort(side_.begin() + first_side_[i], side_.begin() + first_side_[i + 1],
              [&](const Side& s, const Side& t) { return other(s) < other(t); });
  }
}

void FaceConduction::pack_pairs() {
  Neighbours pairs{.row = {0}, .column = {}};
  std::vector<double> G;
  for (int i = 0; i < cloud_.owned; ++i) {
    for (const Side& s : sides(i)) {
      const std::int32_t a = faces_.a[s.face], b = faces_.b[s.face];
      const auto columns = rows_.flux.columns(s.face);
      const auto at_b = std::ranges::find(columns, b) - columns.begin();
      pairs.column.push_back(s.sign > 0 ? b : a);
      G.push_back(rows_.flux.values(s.face)[at_b]);
    }
    pairs.row.push_back(static_cast<std::int64_t>(G.size()));
  }
  pairs_ = PairRows(std::move(pairs), std::move(G));
}

void FaceConduction::find_coupled() {
  first_coupled_ = {0};
  std::vector<int> seen_by(cloud_.local(), -1);
  for (int i = 0; i < cloud_.owned; ++i) {
    seen_by[i] = i;
    const auto see = [&](std::span<const std::int32_t> columns) {
      for (const std::int32_t j : columns)
        if (std::exchange(seen_by[j], i) != i) coupled_.push_back(j);
    };
    for (const Side& s : sides(i)) {
      see(rows_.flux.columns(s.face));
      if (!nodal_) see(rows_.conduction.phi.columns(s.face));
    }
    if (!nodal_) {
      see(rows_.value.columns(i));
      for (auto q = rows_.cells ? rows_.cells->cell[i] : 0; rows_.cells && q < rows_.cells->cell[i + 1]; ++q)
        see(rows_.cells->phi.columns(q));
    }
    std::sort(coupled_.begin() + first_coupled_.back(), coupled_.end(),
              [&](std::int32_t j, std::int32_t l) { return cloud_.id[j] < cloud_.id[l]; });
    first_coupled_.push_back(static_cast<std::int64_t>(coupled_.size()));
  }
}

double FaceConduction::slope(std::size_t q, std::span<const double> T) const {
  // The rows sum to zero; with differences a uniform temperature gives no flux at all, to the last bit.
  const SparseRows& g = rows_.flux;
  const double T_a = T[faces_.a[q]];
  double sum = 0;
  for (std::int64_t n = g.row[q]; n < g.row[q + 1]; ++n) sum += g.value[n] * (T[g.column[n]] - T_a);
  return sum;
}

double FaceConduction::mean(const Conductivity& k, std::size_t q) const {
  if (!nodal_) return k.k[q];
  const double k_a = k.k[faces_.a[q]], k_b = k.k[faces_.b[q]];
  return k.mean == Mean::harmonic ? 2 * (k_a * k_b) / (k_a + k_b) : 0.5 * (k_a + k_b);
}

double FaceConduction::flow(const Conductivity& k, std::span<const double> T, std::size_t q) const {
  return nodal_ && k.mean == Mean::integral ? slope(q, k.theta) : mean(k, q) * slope(q, T);
}

void FaceConduction::add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const {
  if (nodal_ && two_point_) return pairs_.add_fluxes(k, T, F);
  std::vector<double> f(faces_.size());
  for (std::size_t q = 0; q < f.size(); ++q) f[q] = flow(k, T, q);
  for (int i = 0; i < cloud_.owned; ++i) {
    double sum = 0;
    for (const Side& s : sides(i)) sum += s.sign * f[s.face];
    F[i] += sum;
  }
}

void FaceConduction::add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const {
  std::vector<double> row(cloud_.local(), 0.0), values;
  std::vector<std::int32_t> columns;
  const SparseRows &g = rows_.flux, &phi = rows_.conduction.phi;
  const auto add_conductivity = [&](std::size_t q, double sign) {
    const double by_k = sign * slope(q, T);
    if (!nodal_) {
      for (std::int64_t n = phi.row[q]; n < phi.row[q + 1]; ++n) row[phi.column[n]] += by_k * k.dk_dT[q] * phi.value[n];
      return;
    }
    const int a = faces_.a[q], b = faces_.b[q];
    const double k_a = k.k[a], k_b = k.k[b], total = k_a + k_b;
    const bool harmonic = k.mean == Mean::harmonic;
    row[a] += by_k * k.dk_dT[a] * (harmonic ? 2 * (k_b / total) * (k_b / total) : 0.5);
    row[b] += by_k * k.dk_dT[b] * (harmonic ? 2 * (k_a / total) * (k_a / total) : 0.5);
  };
  for (int i = 0; i < cloud_.owned; ++i) {
    for (const Side& s : sides(i)) {
      const std::size_t q = s.face;
      if (nodal_ && k.mean == Mean::integral) {
        for (std::int64_t n = g.row[q]; n < g.row[q + 1]; ++n)
          row[g.column[n]] += s.sign * g.value[n] * k.k[g.column[n]];
        continue;
      }
      const double factor = s.sign * mean(k, q);
      for (std::int64_t n = g.row[q]; n < g.row[q + 1]; ++n) row[g.column[n]] += factor * g.value[n];
      if (!k.dk_dT.empty()) add_conductivity(q, s.sign);
    }
    const auto others = coupled(i, columns);
    columns.assign(others.begin(), others.end());
    columns.push_back(i);
    values.clear();
    for (const std::int32_t j : columns) values.push_back(std::exchange(row[j], 0.0));
    J.add(i, columns, values);
  }
}

void FaceConduction::add_row_sums(const Conductivity& k, std::span<double> sums) const {
  struct RowSums final : JacobianEntries {
    std::span<double> sums;
    void add(int row, std::span<const std::int32_t>, std::span<const double> values) override {
      for (const double v : values) sums[row] += std::abs(v);
    }
  } entries;
  entries.sums = sums;
  add_jacobian({.mean = k.mean, .k = k.k, .dk_dT = {}, .theta = {}}, {}, entries);
}

void FaceConduction::heat_flux(const Conductivity& k, std::span<const double> T, std::span<const int> points,
                               std::span<Vec3> q) const {
  // q_i = M_i^-1 sum of (flow out of cell i) y with M_i = sum y (x) area, y from the point half way to its neighbour
  // (or to the face): exact for linear T.
  const int D = cloud_.dimension;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const int i = points[p];
    Eigen::Matrix3d M = Eigen::Matrix3d::Identity();
    M.topLeftCorner(D, D).setZero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const Side& s : sides(i)) {
      const std::size_t f = s.face;
      const int j = s.sign > 0 ? faces_.b[f] : faces_.a[f];
      const Vec3 y = j < 0 ? rows_.conduction.x[f] - cloud_.x[i] : 0.5 * (cloud_.x[j] - cloud_.x[i]);
      const Vec3 area = s.sign * faces_.area[f];
      const double outward = -s.sign * flow(k, T, f);
      for (int a = 0; a < D; ++a) {
        b[a] += outward * y[a];
        for (int c = 0; c < D; ++c) M(a, c) += y[a] * area[c];
      }
    }
    const Eigen::Vector3d v = M.partialPivLu().solve(b);
    q[p] = {v[0], v[1], v[2]};
  }
}

std::span<const std::int32_t> FaceConduction::coupled(int i, std::vector<std::int32_t>& /*buffer*/) const {
  return {coupled_.data() + first_coupled_[i], static_cast<std::size_t>(first_coupled_[i + 1] - first_coupled_[i])};
}

}  // namespace calor
