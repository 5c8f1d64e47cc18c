// Is there a part of the body that hangs on no temperature, as behind a crack that cuts it off?
#include <numeric>

#include "base/parallel.hpp"
#include "conduction/heat_term.hpp"
#include "solve/heat_system.hpp"

namespace calor {
namespace {

/// Sets of local points that heat flows between, from the entries of a Jacobian that are not 0: a pair across a contact
/// that conducts nothing is none, whatever the pattern of the matrix. By path halving.
class Sets final : public JacobianEntries {
 public:
  explicit Sets(int count) : parent_(count), conducts_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    int set = of(row);
    for (std::size_t n = 0; n < columns.size(); ++n) {
      if (values[n] == 0) continue;
      conducts_[row] = 1;
      if (parent_[columns[n]] != set) parent_[set] = of(columns[n]), set = parent_[set];
    }
  }
  /// Does any heat flow to point i? Within an insulator temperatures stay as they are.
  bool conducts(int i) const { return conducts_[i] != 0; }
  int of(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

 private:
  std::vector<int> parent_;
  std::vector<char> conducts_;
};

}  // namespace

std::optional<Vec3> HeatSystem::loose_part(std::span<const double> T) {
  // What fixes a level: constraints, and exchange that grows with the temperature. Half a kelvin off: radiation at 0 K
  // does not grow.
  std::vector<double> warmer(T.begin(), T.end()), u(cloud_.local()), fixing(cloud_.owned);
  for (double& value : warmer) value += 0.5;
  discretisation_.dofs->solve(warmer, u);
  cloud_.halo.update(u);
  at_->begin(0, u);
  for (const auto& term : exchange_) term->prepare(0);
  collective_try(cloud_.comm, [&] {
    for (const auto& term : exchange_) term->add_row_sums(*at_, fixing);
    for (const auto& term : discretisation_.walls) term->add_row_sums(*at_, fixing);
  });
  for (const auto& constraint : discretisation_.constraints)
    if (constraint->traits().fixes_level)
      for (const int i : constraint->points()) fixing[i] = 1;

  Sets sets(static_cast<int>(cloud_.local()));
  collective_try(cloud_.comm, [&] { discretisation_.conduction->add_jacobian(*at_, sets); });

  // 1 for points of fixed parts; what one rank finds goes on to its neighbours until nothing changes.
  std::vector<double> is_fixed(cloud_.local()), of_set(cloud_.local());
  for (int i = 0; i < cloud_.owned; ++i) is_fixed[i] = fixing[i] > 0 ? 1 : 0;
  for (bool changes = true; changes;) {
    for (std::size_t i = 0; i < is_fixed.size(); ++i)
      if (is_fixed[i] > 0) of_set[sets.of(static_cast<int>(i))] = 1;
    bool changed = false;
    for (int i = 0; i < cloud_.owned; ++i) {
      if (is_fixed[i] > 0 || of_set[sets.of(i)] == 0) continue;
      is_fixed[i] = 1, changed = true;
    }
    changes = any(cloud_.comm, changed);
    cloud_.halo.update(is_fixed);
  }

  std::vector<Vec3> loose;
  for (int i = 0; i < cloud_.owned && loose.empty(); ++i)
    if (is_fixed[i] == 0 && sets.conducts(i)) loose.push_back(cloud_.x[i]);
  loose = gather(cloud_.comm, loose);
  return loose.empty() ? std::nullopt : std::optional(loose.front());
}

}  // namespace calor
