#include "conduction/zeta_rows.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "conduction/constraint.hpp"

namespace calor {
namespace {

/// For every place of the term its part of the area that its point has on the same face: the flux of a face with
/// several facets is their mean.
std::vector<double> shares_of_faces(const Cloud& cloud, const SurfaceTerm& term) {
  std::vector<double> share(term.point.size(), 0);
  if (term.is_plate) return share;  // what goes through the cell of a wall point, which holds no heat, is left out
  for (std::size_t p = 0; p < term.point.size(); ++p) {
    double face_area = 0;
    auto facet = std::ranges::lower_bound(cloud.facets, term.point[p], {}, &Facet::point);
    for (; facet != cloud.facets.end() && facet->point == term.point[p]; ++facet)
      if (facet->face == cloud.facets[term.facet[p]].face) face_area += facet->area;
    share[p] = term.area[p] / face_area;
  }
  return share;
}

}  // namespace

ZetaRows::ZetaRows(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G,
                   const Conditions& conditions)
    : cloud_(cloud), fluxes_(conditions.fluxes), exchange_(cloud.owned), exchange_derivative_(cloud.owned) {
  const std::vector<int> prescribed = points_of(conditions.temperatures);
  std::vector<PetscInt> width;  // of the rows, in this rank's columns and in others'
  for (auto facet = cloud.facets.begin(); facet != cloud.facets.end();) {
    const int i = facet->point;
    // One normal per face, then their sum: at an edge the rows of its faces are added.
    std::map<int, Vec3> area;
    double whole = 0;
    for (; facet != cloud.facets.end() && facet->point == i; ++facet) {
      area[facet->face] += facet->area * facet->normal;
      whole += facet->area;
    }
    if (std::ranges::binary_search(prescribed, i)) continue;
    Vec3 normals;
    for (const auto& [face, a] : area) normals += (1 / norm(a)) * a;
    point_.push_back(i);
    area_.push_back(whole);
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      weights_.column.push_back(j);
      weights_.value.push_back(G[n] / cloud.full_volume[i] * dot(cloud.x[j] - cloud.x[i], normals));
    }
    width.push_back(static_cast<PetscInt>(neighbours.row[i + 1] - neighbours.row[i]) + 1);
    weights_.close_row();
  }
  for (const SurfaceTerm& term : fluxes_) share_.push_back(shares_of_faces(cloud, term));

  const auto count = static_cast<PetscInt>(point_.size());
  std::vector<double> number(cloud.local(), -1);
  auto next = static_cast<double>(offset(cloud.comm, count));
  for (const int i : point_) number[i] = next++;
  cloud.halo.update(number);
  number_.assign(number.begin(), number.end());

  matrix_ = petsc::create_matrix(cloud.comm, width, width);
  change_ = petsc::create_vector(matrix_), right_ = petsc::create_vector(matrix_);
  petsc::check(KSPCreate(cloud.comm, solver_.out()));
  petsc::check(KSPSetOperators(solver_, matrix_, matrix_));
  petsc::factorise(solver_, total(cloud.comm, count), false);
  petsc::check(KSPSetOptionsPrefix(solver_, "wall_"));
  petsc::check(KSPSetFromOptions(solver_));
}

Traits ZetaRows::traits() const {
  return {.is_symmetric = false, .is_constant = std::ranges::all_of(fluxes_, [](const SurfaceTerm& term) {
                                   return !term.flux->depends_on_temperature() || term.flux->linear_in_temperature();
                                 })};
}

double ZetaRows::difference(std::size_t n, std::span<const double> T) const {
  double sum = 0;
  for (std::int64_t m = weights_.row[n]; m < weights_.row[n + 1]; ++m)
    sum += weights_.value[m] * (T[weights_.column[m]] - T[point_[n]]);
  return sum;
}

void ZetaRows::find_exchange(Evaluation& at) {
  std::ranges::fill(exchange_, 0);
  std::ranges::fill(exchange_derivative_, 0);
  std::vector<double> T, q, dq_dT;
  for (std::size_t f = 0; f < fluxes_.size(); ++f) {
    const SurfaceTerm& term = fluxes_[f];
    const std::size_t count = term.point.size();
    if (count == 0) continue;
    T.resize(count), q.resize(count), dq_dT.resize(count);
    for (std::size_t p = 0; p < count; ++p) T[p] = at.T()[term.point[p]];
    term.flux->evaluate({.x = term.x, .t = at.t(), .T = T}, q, dq_dT);
    for (std::size_t p = 0; p < count; ++p) {
      exchange_[term.point[p]] += share_[f][p] * q[p];
      exchange_derivative_[term.point[p]] += share_[f][p] * dq_dT[p];
    }
  }
}

void ZetaRows::residual(Evaluation& at, std::span<double> c) {
  find_exchange(at);
  const std::span<const double> k = at.at(Evaluation::nodes).k();
  for (std::size_t n = 0; n < point_.size(); ++n) {
    const int i = point_[n];
    c[i] = area_[n] * (exchange_[i] - k[i] * difference(n, at.u()));
  }
}

void ZetaRows::add_jacobian(Evaluation& at, JacobianEntries& J) {
  find_exchange(at);
  const std::span<const double> k = at.at(Evaluation::nodes).k(), dk_dT = at.at(Evaluation::nodes).dk_dT();
  std::vector<std::int32_t> columns;
  std::vector<double> values;
  for (std::size_t n = 0; n < point_.size(); ++n) {
    const int i = point_[n];
    columns.clear(), values.clear();
    double diagonal = exchange_derivative_[i];
    if (!dk_dT.empty()) diagonal -= dk_dT[i] * difference(n, at.u());
    for (std::int64_t m = weights_.row[n]; m < weights_.row[n + 1]; ++m) {
      const double value = k[i] * weights_.value[m];
      columns.push_back(weights_.column[m]);
      values.push_back(-area_[n] * value);
      diagonal += value;
    }
    J.add(i, columns, values);
    J.add_nodal(i, area_[n] * diagonal);
  }
}

void ZetaRows::scale(Evaluation& at, std::span<double> scale) {
  const std::span<const double> k = at.at(Evaluation::nodes).k();
  for (std::size_t n = 0; n < point_.size(); ++n) {
    double sum = 0;
    for (const double w : weights_.values(n)) sum += std::abs(w);
    scale[point_[n]] = area_[n] * k[point_[n]] * sum;
  }
}

void ZetaRows::assemble(Evaluation& at) {
  class Entries final : public JacobianEntries {
   public:
    Entries(Mat matrix, const std::vector<PetscInt>& number) : rows_(matrix, number), number_(number) {}
    void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
      rows_.add(number_[row], columns, values);
    }

   private:
    petsc::RowAdder rows_;
    const std::vector<PetscInt>& number_;
  };
  petsc::check(MatZeroEntries(matrix_));
  Entries entries(matrix_, number_);
  add_jacobian(at, entries);
  petsc::assemble(matrix_);
  assembled_with_ = exchange_derivative_;
  is_assembled_ = true;
}

double ZetaRows::newton_step(Evaluation& at, std::span<double> T) {
  std::vector<double> c(cloud_.owned);
  bool is_old = false;
  collective_try(cloud_.comm, [&] {
    residual(at, c);
    const MaterialField& material = at.at(Evaluation::nodes).material();
    const bool k_changes = material.conductivity_depends_on_T() || material.conductivity_depends_on_time();
    is_old = !is_assembled_ || k_changes || assembled_with_ != exchange_derivative_;
    at.at(Evaluation::nodes).dk_dT();
  });
  if (any(cloud_.comm, is_old)) assemble(at);

  std::vector<double> change;
  for (const int i : point_) change.push_back(-c[i]);
  petsc::copy(change, right_);
  petsc::solve(solver_, right_, change_);
  petsc::copy(change_, change);
  double largest = 0;
  for (std::size_t n = 0; n < point_.size(); ++n) {
    T[point_[n]] += change[n];
    largest = std::max(largest, std::abs(change[n]));
  }
  return max(cloud_.comm, largest);
}

void ZetaRows::impose(Evaluation& at, double t, std::span<double> T, std::span<double> /*E*/,
                      std::span<double> /*heat*/) {
  constexpr int most_iterations = 40;
  const bool is_linear = !at.at(Evaluation::nodes).material().conductivity_depends_on_T() && traits().is_constant;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    cloud_.halo.update(T);
    at.begin(t, T);
    const double change = newton_step(at, T);
    double largest = 0;
    for (int i = 0; i < cloud_.owned; ++i) largest = std::max(largest, std::abs(T[i]));
    if (is_linear || change <= 1e-13 * max(cloud_.comm, largest)) return;
  }
  throw Error(Fault::numbers, "the temperatures of the wall points did not converge",
              "use correction = \"consistent\", whose wall points hold heat");
}

std::unique_ptr<ZetaRows> zeta_rows(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G,
                                    const Conditions& conditions) {
  auto rows = std::make_unique<ZetaRows>(cloud, neighbours, G, conditions);
  return any(cloud.comm, !rows->points().empty()) ? std::move(rows) : nullptr;
}

}  // namespace calor
