#include "model.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <optional>
#include <set>
#include <utility>

#include "app/interrupts.hpp"
#include "app/run.hpp"
#include "app/schema.hpp"
#include "callbacks.hpp"
#include "session.hpp"
#include "solve/integrator.hpp"

namespace calor::python {
namespace {

Case read_case(const std::string& path, const std::vector<std::string>& overrides, const py::dict& functions) {
  start_session();
  return Case::read(path, schema(), overrides, callbacks_of(functions));
}

/// What Python's handlers of signals have raised, KeyboardInterrupt as a rule: a run ends after its step as that of the
/// command does, with all results up to there, before it is passed on.
std::optional<py::error_already_set> interrupt;

int interrupted() {
  if (!interrupt && PyErr_CheckSignals() != 0) interrupt.emplace();
  return interrupt ? SIGINT : 0;
}

/// Gathers entries with the numbers that points have in the results.
class Triplets final : public JacobianEntries {
 public:
  explicit Triplets(const Order& order) : order_(order) {}
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    for (std::size_t n = 0; n < columns.size(); ++n) add_one(row, columns[n], values[n]);
  }
  void add_one(std::int64_t row, std::int64_t column, double value) {
    row_.push_back(order_[row]);
    column_.push_back(order_[column]);
    value_.push_back(value);
  }
  Entries entries() const {
    return {array_of(std::span<const std::int64_t>(row_)), array_of(std::span<const std::int64_t>(column_)),
            array_of(std::span<const double>(value_))};
  }

 private:
  const Order& order_;
  std::vector<std::int64_t> row_, column_;
  std::vector<double> value_;
};

}  // namespace

CaseModel::CaseModel(const std::string& path, const std::vector<std::string>& overrides, const py::dict& functions)
    : case_(read_case(path, overrides, functions)),
      model_(build_model(case_, MPI_COMM_SELF, phases_)),
      order_(model_.cloud->id),
      start_(calor::start(model_).state) {}

std::vector<std::string> CaseModel::parts() const {
  const Parts& parts = system().material().parts();
  std::vector<std::string> names;
  for (int p = 0; p < parts.count(); ++p) names.push_back(parts[p].material);
  return names;
}

Numbers CaseModel::part() const {
  const std::vector<int> part = system().material().parts().at(cloud().x, cloud().tag);
  return order_.to_results(std::vector<std::int64_t>(part.begin(), part.end()));
}

py::dict CaseModel::facets() const {
  std::vector<std::int64_t> point, face;
  std::vector<double> area;
  std::vector<Vec3> normal;
  for (const Facet& facet : cloud().facets) {
    point.push_back(order_[facet.point]);
    face.push_back(facet.face);
    area.push_back(facet.area);
    normal.push_back(facet.normal);
  }
  py::dict all;
  all["point"] = array_of(std::span<const std::int64_t>(point));
  all["face"] = array_of(std::span<const std::int64_t>(face));
  all["area"] = array_of(std::span<const double>(area));
  all["normal"] = array_of(std::span<const Vec3>(normal));
  return all;
}

Numbers CaseModel::prescribed() const {
  std::vector<std::int64_t> points;
  for (const int i : system().prescribed()) points.push_back(order_[i]);
  std::ranges::sort(points);
  return array_of(std::span<const std::int64_t>(points));
}

Array CaseModel::start() const { return order_.to_results(start_.T); }

Array CaseModel::temperatures(const Array& u) const {
  std::vector<double> of_cloud = local(u);
  return order_.to_results(system().temperatures(of_cloud));
}

Array CaseModel::dofs(const Array& T) const {
  std::vector<double> u(order_.size());
  model_.system->discretisation().dofs->solve(local(T, "T"), u);
  return order_.to_results(u);
}

Entries CaseModel::shape_functions() const {
  Triplets all(order_);
  for (int i = 0; i < cloud().owned; ++i) {
    if (dofs_are_temperatures()) {
      all.add_one(i, i, 1);
      continue;
    }
    const SparseRows& phi = system().dofs().phi();
    all.add(i, phi.columns(i), phi.values(i));
  }
  return all.entries();
}

Entries CaseModel::weights() const {
  const Discretisation& discretisation = system().discretisation();
  const Conduction& conduction = *discretisation.conduction;
  const Location location = conduction.location();
  const std::vector<double> ones(
      location == Evaluation::nodes ? cloud().x.size() : discretisation.locations[location - 1]->x.size(), 1.0);
  const std::vector<double> ones_at_ends(conduction.ends() ? conduction.ends()->x.size() : 0, 1.0);
  const Conductivity at_ends{.k = ones_at_ends, .dk_dT = {}, .theta = {}};
  const Conductivity k{.k = ones, .dk_dT = {}, .theta = {}, .ends = conduction.ends() ? &at_ends : nullptr};
  const std::vector<double> u(cloud().x.size());
  Triplets all(order_);
  conduction.add_jacobian(k, u, all);
  return all.entries();
}

Array CaseModel::conductivity(const Array& T, double t) const {
  std::vector<double> k(order_.size());
  system().material().conductivity(t, local(T, "T"), k, {});
  return order_.to_results(k);
}

Array CaseModel::heat_capacity(const Array& T) const {
  std::vector<double> rho_c(order_.size());
  system().material().enthalpy(local(T, "T"), {}, rho_c);
  return order_.to_results(rho_c);
}

Array CaseModel::energy(const Array& u) const {
  std::vector<double> E(order_.size());
  system().energy(local(u), E);
  return order_.to_results(E);
}

Array CaseModel::capacity(const Array& u) const {
  std::vector<double> C(order_.size());
  system().capacity(local(u), C);
  return order_.to_results(C);
}

Array CaseModel::rate(const Array& u, double t) const {
  std::vector<double> of_cloud = local(u), F(order_.size()), power(accounts().size());
  system_at(t).rate(t, of_cloud, F, power);
  return order_.to_results(F);
}

Array CaseModel::residual(const Array& u, double t, double rate_factor, const std::optional<Array>& known) const {
  std::vector<double> of_cloud = local(u), R(order_.size());
  const std::vector<double> before = known ? local(*known, "known") : std::vector<double>{};
  system_at(t).residual(t, of_cloud, rate_factor, before, R);
  return order_.to_results(R);
}

Entries CaseModel::jacobian(const Array& u, double t, double capacity_factor, double rate_factor) const {
  std::vector<double> of_cloud = local(u), F(order_.size()), power(accounts().size());
  system_at(t).rate(t, of_cloud, F, power);  // sources that depend on time are made ready for it by this
  const petsc::Matrix J = system().create_jacobian();
  system().jacobian(t, of_cloud, capacity_factor, rate_factor, J);
  Triplets all(order_);
  for (PetscInt row = 0; row < static_cast<PetscInt>(order_.size()); ++row) {
    PetscInt count = 0;
    const PetscInt* column = nullptr;
    const PetscScalar* value = nullptr;
    petsc::check(MatGetRow(J, row, &count, &column, &value));
    for (PetscInt n = 0; n < count; ++n) all.add_one(row, column[n], value[n]);
    petsc::check(MatRestoreRow(J, row, &count, &column, &value));
  }
  return all.entries();
}

Array CaseModel::heat_flux(const Array& u, double t) const {
  std::vector<double> of_cloud = local(u);
  std::vector<Vec3> q(order_.size());
  system_at(t).heat_flux(t, of_cloud, q);
  return order_.to_results(q);
}

std::vector<double> CaseModel::heat_flows(const Array& u, double t) const {
  std::vector<double> of_cloud = local(u);
  return system_at(t).heat_flows(t, of_cloud);
}

Array CaseModel::solve() const {
  if (!is_steady(case_))
    case_.root().refuse("time", "the case is transient", "march to the times you want, or take [steady] for [time]");
  State state = start_;
  solve_steady(case_, system(), state);
  return order_.to_results(system().temperatures(state.T));
}

Array CaseModel::march(const std::vector<double>& times) const {
  if (is_steady(case_))
    case_.root().refuse("steady", "the case is steady", "solve it, or take [time] in place of [steady]");
  const bool are_finite = std::ranges::all_of(times, [](double t) { return std::isfinite(t); });
  if (!are_finite || !std::ranges::is_sorted(times) || (!times.empty() && times.front() < 0))
    throw py::value_error("times are finite and ascend from 0 s");
  std::set<double> stops(times.begin(), times.end());
  for (const double event : system().events())
    if (!times.empty() && event > 0 && event < times.back()) stops.insert(event);
  State state = start_;
  const std::unique_ptr<Integrator> integrator = make_integrator(case_, system(), state);
  const auto go_on = [](const State&) {  // unless somebody has pressed Ctrl-C
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    return true;
  };
  std::vector<std::vector<double>> rows;
  auto next = times.begin();
  for (const double stop : stops) {
    system().apply(state.t * (1 + 1e-12));
    if (stop > state.t) integrator->advance(system(), state, stop, go_on);
    const std::vector<double> T = system().temperatures(state.T);
    for (; next != times.end() && *next == stop; ++next) rows.push_back(T);
  }
  Array out({static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(order_.size())});
  for (std::size_t n = 0; n < rows.size(); ++n)
    for (std::size_t i = 0; i < order_.size(); ++i) out.mutable_at(n, order_[i]) = rows[n][i];
  return out;
}

bool run_case(const std::string& path, const std::vector<std::string>& overrides, const py::dict& functions,
              const std::string& folder) {
  const Case c = read_case(path, overrides, functions);
  interrupt.reset();
  ask_for_interrupts(interrupted);
  const RunResult result = run(c, MPI_COMM_SELF, {.folder = folder, .quiet = true});
  if (auto raised = std::exchange(interrupt, {})) throw std::move(*raised);
  return result.passed();
}

}  // namespace calor::python
