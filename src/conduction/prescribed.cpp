#include "conduction/constraint.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace calor {
namespace {

/// What both kinds share: whose points they are, and the books.
class PrescribedPoints : public Constraint {
 public:
  PrescribedPoints(const Cloud& cloud, std::span<const PrescribedTerm> terms, Capacity& capacity)
      : cloud_(cloud), terms_(terms), capacity_(capacity), points_(points_of(terms)), held_E_(points_.size()) {
    for (const PrescribedTerm& term : terms) {
      is_constant_ = is_constant_ && !term.temperature.depends_on_time();
      std::vector<int>& at = index_.emplace_back();
      for (int i : term.point) at.push_back(static_cast<int>(std::ranges::lower_bound(points_, i) - points_.begin()));
    }
  }

  std::span<const int> points() const override { return points_; }
  bool is_massless() const override { return false; }
  void scale(Evaluation& /*at*/, std::span<double> /*scale*/) override {}  // by the heat capacity itself

  void impose(Evaluation& at, double t, std::span<double> u, std::span<double> E, std::span<double> heat) override {
    hold(at, t, u);
    for (std::size_t m = 0; m < terms_.size(); ++m) {
      const PrescribedTerm& term = terms_[m];
      double reaction = 0;
      for (std::size_t n = 0; n < term.point.size(); ++n)
        reaction += term.share[n] * (held_E_[index_[m][n]] - E[term.point[n]]);
      heat[term.account] += reaction;
    }
    for (std::size_t n = 0; n < points_.size(); ++n) E[points_[n]] = held_E_[n];
  }

 protected:
  /// Sets u and the enthalpies of the points to those of the prescribed temperatures. Collective.
  virtual void hold(Evaluation& at, double t, std::span<double> u) = 0;

  /// Calls use(n, share of the term, T*) for the points of every term, n their index in points().
  template <class Use>
  void for_each_term(double t, const Use& use) {
    for (std::size_t m = 0; m < terms_.size(); ++m) {
      const PrescribedTerm& term = terms_[m];
      if (term.point.empty()) continue;  // held by mirror images
      T_star_.resize(term.x.size());
      term.temperature.evaluate({.x = term.x, .t = t}, T_star_);
      for (std::size_t n = 0; n < T_star_.size(); ++n) use(index_[m][n], term.share[n], T_star_[n]);
    }
  }

  const Cloud& cloud_;
  std::span<const PrescribedTerm> terms_;
  Capacity& capacity_;
  std::vector<int> points_;
  std::vector<std::vector<int>> index_;  ///< for every term: where its points are in points_
  std::vector<double> held_E_;
  bool is_constant_ = true;

 private:
  std::vector<double> T_star_;
};

/// The degrees of freedom are the temperatures themselves: they are set. Their rows of the Jacobian hold the heat
/// capacities of the start, in the unit of the other rows.
class FixedPoints final : public PrescribedPoints {
 public:
  using PrescribedPoints::PrescribedPoints;
  bool fixes_dofs() const override { return true; }
  Traits traits() const override { return {.fixes_level = !points_.empty()}; }
  std::span<const std::int32_t> coupled(std::size_t /*n*/) const override { return {}; }

  void residual(Evaluation& /*at*/, std::span<double> c) override {
    for (int i : points_) c[i] = 0;
  }
  void add_jacobian(Evaluation& at, JacobianEntries& J) override {
    if (C_.empty()) {
      C_.resize(cloud_.owned);
      capacity_.evaluate(at, {}, C_);
    }
    for (int i : points_) J.add_nodal(i, -C_[i]);
  }
  void set_known(double t, std::span<double> u) override {
    for (int i : points_) u[i] = 0;
    for_each_term(t, [&](int n, double share, double T_star) { u[points_[n]] += share * T_star; });
  }

 private:
  void hold(Evaluation& at, double t, std::span<double> u) override {
    if (!is_held_) {
      collective_try(cloud_.comm, [&] {
        set_known(t, u);
        at.begin(t, u);
        find_enthalpies(at);
      });
      is_held_ = is_constant_;
      held_T_.clear();
      for (int i : points_) held_T_.push_back(u[i]);
    }
    for (std::size_t n = 0; n < points_.size(); ++n) u[points_[n]] = held_T_[n];
  }

  void find_enthalpies(Evaluation& at) {
    const std::span<const double> T = at.T();
    const bool is_linear = !at.at(Evaluation::nodes).material().capacity_depends_on_T();
    if (is_linear && has_base_) {
      for (std::size_t n = 0; n < points_.size(); ++n)
        held_E_[n] = base_E_[n] + base_C_[n] * (T[points_[n]] - base_T_[n]);
      return;
    }
    std::vector<double> E(cloud_.owned), C(cloud_.owned);
    capacity_.evaluate(at, E, C);
    base_T_.clear(), base_E_.clear(), base_C_.clear();
    for (std::size_t n = 0; n < points_.size(); ++n) {
      const int i = points_[n];
      held_E_[n] = E[i];
      base_T_.push_back(T[i]), base_E_.push_back(E[i]), base_C_.push_back(C[i]);
    }
    has_base_ = true;
  }

  std::vector<double> C_;  ///< of the owned points
  bool is_held_ = false;   ///< for good
  bool has_base_ = false;
  std::vector<double> held_T_;
  std::vector<double> base_T_, base_E_, base_C_;  ///< where the capacity is constant
};

/// Parameters: c_i = C_i (T* - T^h(x_i)), J, with the heat capacities C of the start.
class CollocatedPoints final : public PrescribedPoints {
 public:
  CollocatedPoints(const Cloud& cloud, std::span<const PrescribedTerm> terms, Dofs& dofs, Capacity& capacity)
      : PrescribedPoints(cloud, terms, capacity), dofs_(dofs) {}
  bool fixes_dofs() const override { return false; }
  Traits traits() const override { return {.is_symmetric = false, .fixes_level = !points_.empty()}; }
  std::span<const std::int32_t> coupled(std::size_t n) const override { return dofs_.phi().columns(points_[n]); }

  void residual(Evaluation& at, std::span<double> c) override {
    const std::span<const double> T = at.T();
    for (int i : points_) c[i] = 0;
    for_each_term(
        at.t(), [&](int n, double share, double T_star) { c[points_[n]] += C_[n] * share * (T_star - T[points_[n]]); });
  }
  void add_jacobian(Evaluation& /*at*/, JacobianEntries& J) override {
    for (std::size_t n = 0; n < points_.size(); ++n) J.add_nodal(points_[n], -C_[n]);
  }
  void set_known(double /*t*/, std::span<double> /*u*/) override {}

 private:
  void hold(Evaluation& at, double t, std::span<double> u) override {
    cloud_.halo.update(u);
    at.begin(t, u);
    if (!has_C_) {
      std::vector<double> C(cloud_.owned);
      collective_try(cloud_.comm, [&] { capacity_.evaluate(at, {}, C); });
      for (int i : points_) C_.push_back(C[i]);
      has_C_ = true;  // on all ranks, also on those without such points
    }
    if (!meets(at)) {
      std::vector<double> T(at.T().begin(), at.T().end());
      for (std::size_t n = 0; n < points_.size(); ++n) T[points_[n]] += violation_[n];
      dofs_.solve(T, u);
      cloud_.halo.update(u);
      at.begin(t, u);
    }
    std::vector<double> E(cloud_.owned);
    collective_try(cloud_.comm, [&] { capacity_.evaluate(at, E, {}); });
    for (std::size_t n = 0; n < points_.size(); ++n) held_E_[n] = E[points_[n]];
  }

  /// Are all temperatures met as well as Newton's method leaves them? Fills violation_, K. Collective.
  bool meets(Evaluation& at) {
    constexpr double as_newton_leaves_it = 1e-9;
    std::vector<double> c(cloud_.owned);
    collective_try(cloud_.comm, [&] { residual(at, c); });
    double largest = 0, hottest = 0;
    violation_.clear();
    for (std::size_t n = 0; n < points_.size(); ++n) {
      violation_.push_back(c[points_[n]] / C_[n]);
      largest = std::max(largest, std::abs(violation_[n]));
      hottest = std::max(hottest, std::abs(at.T()[points_[n]]));
    }
    return max(cloud_.comm, largest) <= as_newton_leaves_it * max(cloud_.comm, hottest);
  }

  Dofs& dofs_;
  bool has_C_ = false;
  std::vector<double> C_, violation_;  ///< of points_
};

}  // namespace

std::vector<int> points_of(std::span<const PrescribedTerm> temperatures) {
  std::vector<int> points;
  for (const PrescribedTerm& term : temperatures) points.insert(points.end(), term.point.begin(), term.point.end());
  std::ranges::sort(points);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

std::unique_ptr<Constraint> prescribed_points(const Cloud& cloud, std::span<const PrescribedTerm> temperatures,
                                              Dofs& dofs, Capacity& capacity) {
  if (!any(cloud.comm, !points_of(temperatures).empty())) return nullptr;
  if (dofs.are_temperatures()) return std::make_unique<FixedPoints>(cloud, temperatures, capacity);
  return std::make_unique<CollocatedPoints>(cloud, temperatures, dofs, capacity);
}

}  // namespace calor
