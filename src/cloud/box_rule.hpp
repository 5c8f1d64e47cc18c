#pragma once
// Quadrature of boxes for functions that are smooth, or smooth between jumps anywhere.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/vec3.hpp"
#include "cloud/integrand.hpp"

namespace calor {

/// Places of a domain, their weights, which add up to 1, and the integrand there; no values where there is none.
struct Places {
  std::vector<Vec3> x;
  std::vector<double> weight, value;

  void clear() { x.clear(), weight.clear(), value.clear(); }
  double mean() const;  ///< of the integrand
};

/// The integrand must outlive it.
class BoxRule {
 public:
  explicit BoxRule(const Integrand& f) : f_(f) {}

  /// Appends the places of a box; axes along which it has no length are left out. Without an integrand: Gauss points
  /// for smooth functions. A smooth integrand has Gauss points, of halves where two rules disagree. One that jumps is
  /// looked at on a grid: jumps that lie on a plane across an axis split the box there, to round-off; other ones are
  /// found on every line of a nested integration. Does it jump?
  bool add(const Vec3& low, const Vec3& high, Places& out);

 private:
  struct Box {
    Vec3 low, high;
    double weight;  ///< its part of the whole
  };
  /// A jump between two places that differ in one coordinate, a and b.
  struct Jump {
    Vec3 place;
    double a, b;
    double at() const { return 0.5 * (a + b); }
  };

  double value(const Vec3& x);
  bool add_quickly(const Box& box, Places& out);
  void emit_smooth(const Box& box, Places& out) const;
  void add_smooth(const Box& box, int depth, Places& out);
  void add_with_jumps(const Box& box, int depth, Places& out);
  void add_curved(const Box& box, int level, Vec3 place, double weight, Places& out);

  void find_on_line(int axis, Vec3 place, std::span<const double> s, std::span<const double> f,
                    std::vector<Jump>& found);
  std::optional<Jump> locate(int axis, const Vec3& place, double a, double b, double fa, double fb, int halvings);
  bool is_parallel(int axis, const Box& box, const Jump& jump);
  std::vector<double> planes(int axis, const Box& box, const std::vector<Jump>& jumps);

  const Integrand& f_;
  int dimension_ = 0;
  std::array<int, 3> axes_ = {};  ///< along which the box has a length
  bool jumps_ = false;
  double size_ = 0;  ///< the largest value seen in the box, or the scale
};

}  // namespace calor
