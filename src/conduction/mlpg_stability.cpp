#include "conduction/mlpg_stability.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.hpp"
#include "base/petsc.hpp"
#include "cloud/lattice.hpp"
#include "conduction/faces.hpp"

namespace calor {

namespace {

/// A lattice of unit spacing around the origin with the entries of one row of a matrix.
class Stencil {
 public:
  Stencil(int dimension, int half) : D_(dimension), half_(half), side_(2 * half + 1) {
    for (int n = 0; n < size(); ++n) entry_.push_back(0);
  }
  int size() const { return D_ == 1 ? side_ : D_ == 2 ? side_ * side_ : side_ * side_ * side_; }
  Vec3 location(int n) const {
    Vec3 x;
    for (int a = 0; a < D_; ++a, n /= side_) x[a] = n % side_ - half_;
    return x;
  }
  double& entry(int n) { return entry_[n]; }
  double entry(int n) const { return entry_[n]; }

  /// sum_n entry_n cos(k_1 x_1) cos(k_2 x_2) ..: the symbol of a stencil that is even along every axis.
  double symbol(const Vec3& k) const {
    std::array<std::vector<double>, 3> cosine;
    for (int a = 0; a < D_; ++a)
      for (int n = -half_; n <= half_; ++n) cosine[a].push_back(std::cos(k[a] * n));
    double sum = 0;
    for (int n = 0; n < size(); ++n) {
      double product = entry_[n];
      for (int a = 0, m = n; a < D_; ++a, m /= side_) product *= cosine[a][m % side_];
      sum += product;
    }
    return sum;
  }

 private:
  int D_, half_, side_;
  std::vector<double> entry_;
};

/// Adds weight * phi, or weight . grad phi, at x to the stencil.
template <class Add>
void for_each_node(const MovingLeastSquares& mls, double R, const Vec3& x, bool slopes, const Stencil& stencil,
                   const Add& add) {
  std::vector<int> number;
  std::vector<MlsNode> nodes;
  for (int n = 0; n < stencil.size(); ++n) {
    const Vec3 y = stencil.location(n);
    if (dot(x - y, x - y) < R * R * (1 - 1e-9)) number.push_back(n), nodes.push_back({y, {1 / R, 1 / R, 1 / R}});
  }
  MlsPlaces places;  // one place, along every axis
  for (int a = 0; a < (slopes ? 3 : 1); ++a) places.add(x, {double(a == 0), double(a == 1), double(a == 2)});
  std::vector<MlsPlaces::Lanes> phi(nodes.size()), slope(slopes ? nodes.size() : 0);
  if (!mls.evaluate(places, nodes, std::vector<std::uint8_t>(nodes.size(), 0xff), phi, slope)) return;
  for (std::size_t k = 0; k < nodes.size(); ++k)
    add(number[k], phi[k][0], slopes ? Vec3{slope[k][0], slope[k][1], slope[k][2]} : Vec3{});
}

using petsc::check;

/// Adds factor * rows into a matrix.
class Entries final : public JacobianEntries {
 public:
  Entries(const Cloud& cloud, Mat matrix, const std::vector<PetscInt>& number, double factor)
      : cloud_(cloud), rows_(matrix, number), factor_(factor) {}
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    rows_.add(cloud_.global[row], columns, values, factor_);
  }

 private:
  const Cloud& cloud_;
  petsc::RowAdder rows_;
  double factor_;
};

/// C/dt + factor K with rho c = k = 1.
petsc::Matrix stepping_matrix(const Cloud& cloud, const FaceConduction& conduction, double dt, double factor) {
  std::vector<PetscInt> diagonal(cloud.owned, 1), off_diagonal(cloud.owned, 0);
  std::vector<std::int32_t> buffer;
  for (int i = 0; i < cloud.owned; ++i)
    for (const int j : conduction.coupled(i, buffer)) ++(j < cloud.owned ? diagonal : off_diagonal)[i];
  petsc::Matrix matrix = petsc::create_matrix(cloud.comm, diagonal, off_diagonal);
  const std::vector<PetscInt> number(cloud.global.begin(), cloud.global.end());
  petsc::RowAdder capacities(matrix, number);
  const auto hold = [&](int i, const SparseRows& phi, std::size_t r, double volume) {
    capacities.add(cloud.global[i], phi.columns(r), phi.values(r), volume / dt);
  };
  const CellQuadrature* cells = conduction.rows().cells ? &*conduction.rows().cells : nullptr;
  for (int i = 0; i < cloud.owned; ++i) {
    if (!cells) hold(i, conduction.rows().value, i, cloud.volume[i]);
    for (auto q = cells ? cells->cell[i] : 0; cells && q < cells->cell[i + 1]; ++q)
      hold(i, cells->phi, q, cells->volume[q]);
  }
  const std::vector<double> one(conduction.faces().size(), 1.0);
  Entries entries(cloud, matrix, number, -factor);  // conduction gives -K
  conduction.add_jacobian({.mean = Mean::arithmetic, .k = one, .dk_dT = {}, .theta = {}}, {}, entries);
  petsc::assemble(matrix);
  return matrix;
}

double volume_of(const LatticeCell& cell) {
  double sum = 0;
  for (const double v : cell.volume) sum += v;
  return sum;
}

void gather_at_origin(LatticeCell& cell) {
  cell.volume = {volume_of(cell)};
  cell.inside = {{}};
}

}  // namespace

LatticeCell lattice_box(int D, bool one_point) {
  LatticeCell cell;
  const double g = 0.5 / std::sqrt(3.0);
  const auto corner = [&](int q) {
    Vec3 x;
    for (int a = 0; a < D; ++a) x[a] = q >> a & 1 ? g : -g;
    return x;
  };
  const int corners = 1 << D;
  for (int q = 0; q < corners; ++q) {
    cell.inside.push_back(corner(q));
    cell.volume.push_back(1.0 / corners);
    for (int a = 0; a < D; ++a) {  // the corner's share of the face towards it
      Vec3 x = corner(q), area;
      area[a] = std::copysign(2.0 / corners, x[a]);
      x[a] = std::copysign(0.5, x[a]);
      cell.face.push_back(x);
      cell.area.push_back(area);
    }
  }
  if (one_point) gather_at_origin(cell);
  return cell;
}

LatticeCell lattice_sphere(int D, double radius, bool one_point) {
  LatticeCell cell;
  const UnitSphere unit = unit_sphere(D, {});
  for (std::size_t q = 0; q < unit.on.size(); ++q) {
    cell.face.push_back(radius * unit.on[q]);
    cell.area.push_back(std::pow(radius, D - 1) * unit.area[q] * unit.on[q]);
  }
  for (std::size_t q = 0; q < unit.inside.size(); ++q) {
    cell.inside.push_back(radius * unit.inside[q]);
    cell.volume.push_back(std::pow(radius, D) * unit.volume[q]);
  }
  if (one_point) gather_at_origin(cell);
  return cell;
}

Vec3 stretched_conductivity(const Lattice& lattice) {
  if (lattice.largest_dx() - lattice.least_dx() <= 1e-9 * lattice.largest_dx()) return {1, 1, 1};
  Vec3 k;
  for (int a = 0; a < lattice.box().dimension; ++a) k[a] = std::pow(lattice.least_dx() / lattice.dx(a), 2);
  return k;
}

LatticeSymbols lattice_symbols(const MovingLeastSquares& mls, double R, const LatticeCell& cell,
                               const Vec3& conductivity) {
  const int D = mls.dimension;
  const double size = volume_of(cell);
  double farthest = 0;
  for (const Vec3& x : cell.face) farthest = std::max(farthest, norm(x));
  Stencil C(D, static_cast<int>(std::ceil(R + farthest))), K = C;
  for (std::size_t q = 0; q < cell.inside.size(); ++q)
    for_each_node(mls, R, cell.inside[q], false, C,
                  [&](int n, double phi, const Vec3&) { C.entry(n) += cell.volume[q] / size * phi; });
  for (std::size_t q = 0; q < cell.face.size(); ++q)
    for_each_node(mls, R, cell.face[q], true, K, [&](int n, double, const Vec3& slope) {
      K.entry(n) -= dot(product(conductivity, cell.area[q]), slope) / size;
    });

  LatticeSymbols out{.least_capacity = 1, .least_rate = std::numeric_limits<double>::infinity(), .kappa = 0};
  double all = 0;
  for (int a = 0; a < D; ++a) all += conductivity[a];
  for (int n = 0; n < K.size(); ++n) out.kappa -= K.entry(n) * dot(K.location(n), K.location(n)) / (2 * all);
  const bool alike = conductivity == Vec3{1, 1, 1};
  constexpr int waves = 24;
  for (int w = 1; w < std::pow(waves + 1, D); ++w) {
    Vec3 k;
    for (int a = 0, m = w; a < D; ++a, m /= waves + 1) k[a] = std::numbers::pi * (m % (waves + 1)) / waves;
    if (alike && (k.x < k.y || k.y < k.z)) continue;
    const double c = C.symbol(k);
    out.least_capacity = std::min(out.least_capacity, c);
    out.least_rate = std::min(out.least_rate, K.symbol(k) / c);
  }
  return out;
}

double start_up_growth(const Cloud& cloud, const FaceConduction& conduction, double factor) {
  constexpr int steps = 60, watched = 20;
  double d = std::numeric_limits<double>::max();
  for (int i = 0; i < cloud.owned; ++i)
    for (int a = 0; a < 3; ++a) d = std::min(d, cloud.metric[i][a]);
  d = min(cloud.comm, d);
  const double dt = 0.1 * d * d / factor;
  const petsc::Matrix A = stepping_matrix(cloud, conduction, dt, 0.5), B = stepping_matrix(cloud, conduction, dt, -0.5);
  const petsc::Vector unknowns = petsc::create_vector(A), right = petsc::create_vector(A);
  petsc::LinearSolver solver;
  check(KSPCreate(cloud.comm, solver.out()));
  check(KSPSetOperators(solver, A, A));
  check(KSPSetType(solver, KSPBCGS));
  check(KSPSetTolerances(solver, 1e-8, 1e-300, PETSC_DEFAULT, 400));
  check(KSPSetInitialGuessNonzero(solver, PETSC_TRUE));
  PC jacobi = nullptr;
  check(KSPGetPC(solver, &jacobi));
  check(PCSetType(jacobi, PCJACOBI));

  std::vector<double> T(cloud.local());
  const std::span<double> owned = std::span(T).first(cloud.owned);
  const auto size = [&] {
    cloud.halo.update(std::span<double>(T));
    std::vector<double> values(cloud.owned);
    conduction.rows().value.apply(T, values);
    return std::sqrt(dot(cloud.comm, values, values));
  };
  for (int i = 0; i < cloud.owned; ++i) T[i] = 2 * hashed_uniform(1, static_cast<std::uint64_t>(cloud.id[i])).x - 1;
  const double start = size();
  petsc::copy(owned, unknowns);
  double before = start, now = start;
  for (int step = 1; step <= steps; ++step) {
    check(MatMult(B, unknowns, right));
    const bool solved = petsc::solve(solver, right, unknowns);
    petsc::copy(unknowns, owned);
    now = size();
    if (!solved || !(now < 10 * start)) return std::numeric_limits<double>::infinity();
    if (step == steps - watched) before = now;
  }
  return now / before;
}

}  // namespace calor
