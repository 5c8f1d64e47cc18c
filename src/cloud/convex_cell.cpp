#include "cloud/convex_cell.hpp"

#include <algorithm>
#include <cmath>

namespace calor {

void ConvexCell::set(const Vec3& low_of_body, const Vec3& high_of_body, int dimension) {
  Vec3 low = low_of_body, high = high_of_body;
  for (int a = dimension; a < 3; ++a) low[a] = -0.5, high[a] = 0.5;
  sides_.clear();
  faces_ = 0;
  dimension_ = dimension;
  size_ = norm(high_of_body - low_of_body);
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    for (const bool upper : {false, true}) {
      const auto corner = [&](bool at_b, bool at_c) {
        Vec3 x;
        x[a] = (upper ? high : low)[a], x[b] = (at_b ? high : low)[b], x[c] = (at_c ? high : low)[c];
        return x;
      };
      constexpr bool around[5][2] = {{false, false}, {true, false}, {true, true}, {false, true}, {false, false}};
      for (int k = 0; k < 4; ++k) {
        const Vec3 p = corner(around[k][0], around[k][1]), q = corner(around[k + 1][0], around[k + 1][1]);
        sides_.push_back(upper ? Side{p, q, faces_} : Side{q, p, faces_});
      }
      ++faces_;
    }
  }
}

bool ConvexCell::cut(const Vec3& n, double offset) {
  // A corner that lies on the plane, as in lattices, is on the same side for all of its faces, whatever the rounding.
  const double on_plane = 1e-11 * size_ * norm(n);
  const auto beyond = [&](const Vec3& x) { return dot(x, n) - offset; };
  if (std::ranges::none_of(sides_, [&](const Side& s) { return beyond(s.from) > on_plane; })) return false;

  cut_.clear(), fresh_.clear();
  const Side* leaves = nullptr;  // of the face at hand: the sides that cross the plane outwards and inwards
  const Side* returns = nullptr;
  Vec3 out, in;
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    const Side& s = sides_[k];
    const double b_from = beyond(s.from), b_to = beyond(s.to);
    const auto crossing = [&] { return s.from + b_from / (b_from - b_to) * (s.to - s.from); };
    if (b_from <= on_plane && b_to <= on_plane) {
      cut_.push_back(s);
    } else if (b_from <= on_plane) {
      out = crossing(), leaves = &s;
      cut_.push_back({s.from, out, s.face});
    } else if (b_to <= on_plane) {
      in = crossing(), returns = &s;
      cut_.push_back({in, s.to, s.face});
    }
    if (k + 1 < sides_.size() && sides_[k + 1].face == s.face) continue;
    if (leaves && returns) {
      cut_.push_back({out, in, s.face});
      fresh_.push_back({in, out, faces_});
    }
    leaves = returns = nullptr;
  }
  ++faces_;
  cut_.insert(cut_.end(), fresh_.begin(), fresh_.end());
  sides_.swap(cut_);
  return true;
}

double ConvexCell::reach() const {
  double largest = 0;
  for (const Side& s : sides_) {
    double square = 0;
    for (int a = 0; a < dimension_; ++a) square += s.from[a] * s.from[a];
    largest = std::max(largest, square);
  }
  return std::sqrt(largest);
}

ConvexCell::Moments ConvexCell::moments() const {
  // Tetrahedra of the origin, a corner p of a face and a side q, r of that.
  Moments m;
  for (std::size_t k = 0, first = 0; k < sides_.size(); ++k) {
    if (sides_[k].face != sides_[first].face) first = k;
    const Vec3 &p = sides_[first].from, &q = sides_[k].from, &r = sides_[k].to, sum = p + q + r;
    const double volume = dot(p, cross(q, r)) / 6;
    m.volume += volume;
    m.first += 0.25 * volume * sum;
    constexpr int axes[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (int c = 0; c < 6; ++c) {
      const auto [a, b] = axes[c];
      m.second[c] += 0.05 * volume * (p[a] * p[b] + q[a] * q[b] + r[a] * r[b] + sum[a] * sum[b]);
    }
  }
  return m;
}

}  // namespace calor
