#include "cloud/convex_cell.hpp"

#include <algorithm>

namespace calor {

void ConvexCell::set(const Vec3& low, const Vec3& high) {
  sides_.clear();
  faces_ = 0;
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

bool ConvexCell::cut_half_way_to(const Vec3& r) {
  const double half = 0.5 * dot(r, r);
  // A corner that lies on the plane, as in lattices, is on the same side for all of its faces, whatever the rounding.
  const double on_plane = 1e-10 * half;
  const auto beyond = [&](const Vec3& x) { return dot(x, r) - half; };
  if (std::ranges::none_of(sides_, [&](const Side& s) { return beyond(s.from) > on_plane; })) return false;

  cut_.clear(), fresh_.clear();
  const Side* leaves = nullptr;  // of the face at hand: the sides that cross the plane outwards and inwards
  const Side* returns = nullptr;
  Vec3 out, in;
  for (std::size_t n = 0; n < sides_.size(); ++n) {
    const Side& s = sides_[n];
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
    if (n + 1 < sides_.size() && sides_[n + 1].face == s.face) continue;
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

double ConvexCell::volume() const {
  // Tetrahedra of the origin, a corner of a face and a side of that.
  double sum = 0;
  for (std::size_t n = 0, first = 0; n < sides_.size(); ++n) {
    if (sides_[n].face != sides_[first].face) first = n;
    const Vec3& apex = sides_[first].from;
    sum += dot(apex, cross(sides_[n].from, sides_[n].to));
  }
  return sum / 6;
}

double ConvexCell::square_reach(int dimension) const {
  double largest = 0;
  for (const Side& s : sides_) {
    double square = 0;
    for (int a = 0; a < dimension; ++a) square += s.from[a] * s.from[a];
    largest = std::max(largest, square);
  }
  return largest;
}

}  // namespace calor
