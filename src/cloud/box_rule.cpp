#include "cloud/box_rule.hpp"

#include <algorithm>
#include <cmath>

namespace calor {
namespace {

/// Gauss points and weights on [0, 1].
struct Gauss {
  std::vector<double> x, weight;
};
const Gauss& gauss(int n) {
  static const std::array<Gauss, 3> rules = {
      Gauss{{0.21132486540518712, 0.78867513459481288}, {0.5, 0.5}},
      Gauss{{0.11270166537925831, 0.5, 0.88729833462074169}, {5. / 18, 8. / 18, 5. / 18}},
      Gauss{{0.06943184420297371, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629},
            {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693}}};
  return rules[n - 2];
}

/// Two rules that agree to this part of the function's size: the better one is good to some 1e-8.
constexpr double agreement = 2e-6;
/// For functions that are integrated again and again, the same with an error of some 3e-5; and rules of the third
/// degree that agree well enough.
constexpr double repeated_agreement = 1e-3, quick_agreement = 3e-5;
/// Grids that look for jumps end this part of a length inside, so that an edge on the side of a cell is none of it.
constexpr double inset = 1e-9;
/// Halvings of an interval of the grid that tell a jump from a steep place, and those that end at round-off.
constexpr int rough = 16, exact = 60;
constexpr int most_splits = 3;

int grid_points(int dimension) { return dimension == 1 ? 17 : dimension == 2 ? 9 : 4; }
int most_halvings(int dimension) { return dimension == 1 ? 8 : dimension == 2 ? 5 : 2; }

/// Do the slopes of a line's intervals change by less than half of the steepest one from each to the next? A jump makes
/// one interval steep and not its neighbours.
bool bends_little(std::span<const double> s, std::span<const double> f) {
  double steepest = 0, most = 0;
  for (std::size_t k = 1; k < s.size(); ++k) {
    const double slope = (f[k] - f[k - 1]) / (s[k] - s[k - 1]);
    steepest = std::max(steepest, std::abs(slope));
    if (k > 1) most = std::max(most, std::abs(slope - (f[k - 1] - f[k - 2]) / (s[k - 1] - s[k - 2])));
  }
  return most < 0.5 * steepest;
}

std::vector<double> grid_between(int n, double low, double high) {
  std::vector<double> s(n);
  const double edge = inset * (high - low);
  for (int k = 0; k < n; ++k) s[k] = low + edge + (high - low - 2 * edge) * k / (n - 1);
  return s;
}

}  // namespace

double Places::mean() const {
  double sum = 0;
  for (std::size_t n = 0; n < value.size(); ++n) sum += weight[n] * value[n];
  return sum;
}

double BoxRule::value(const Vec3& x) {
  double value = 0;
  f_.f({&x, 1}, {&value, 1});
  return value;
}

bool BoxRule::add(const Vec3& low, const Vec3& high, Places& out) {
  dimension_ = 0;
  for (int a = 0; a < 3; ++a)
    if (high[a] > low[a]) axes_[dimension_++] = a;
  size_ = f_.scale, jumps_ = false;
  const Box box{low, high, 1};
  if (!f_.f) {
    emit_smooth(box, out);
  } else if (dimension_ == 0) {
    out.x.push_back(low), out.weight.push_back(1), out.value.push_back(value(low));
  } else if (f_.may_jump && f_.quick && add_quickly(box, out)) {
    return false;
  } else if (f_.may_jump) {
    add_with_jumps(box, 0, out);
  } else {
    add_smooth(box, 0, out);
  }
  return jumps_;
}

namespace {

/// The product of a Gauss rule over the axes.
void add_product(const Vec3& low, const Vec3& high, double weight, std::span<const int> axes, int n, Places& out) {
  const Gauss& rule = gauss(n);
  int count = 1;
  for (std::size_t k = 0; k < axes.size(); ++k) count *= n;
  for (int index = 0; index < count; ++index) {
    Vec3 x = low;
    double w = weight;
    for (int rest = index; const int a : axes) {
      x[a] = low[a] + rule.x[rest % n] * (high[a] - low[a]);
      w *= rule.weight[rest % n];
      rest /= n;
    }
    out.x.push_back(x), out.weight.push_back(w);
  }
}

}  // namespace

void BoxRule::emit_smooth(const Box& box, Places& out) const {
  add_product(box.low, box.high, box.weight, std::span(axes_).first(dimension_), dimension_ == 3 ? 2 : 3, out);
}

void BoxRule::add_smooth(const Box& box, int depth, Places& out) {
  const std::span<const int> axes = std::span(axes_).first(dimension_);
  const int n = dimension_ == 3 ? 3 : 4;
  Places fine, coarse;
  add_product(box.low, box.high, 1, axes, n, fine);
  add_product(box.low, box.high, 1, axes, n - 1, coarse);
  for (Places* places : {&fine, &coarse}) {
    places->value.resize(places->x.size());
    f_.f(places->x, places->value);
    for (const double v : places->value) size_ = std::max(size_, std::abs(v));
  }
  const double tolerance = (f_.quick ? repeated_agreement : agreement) * size_;
  if (std::abs(fine.mean() - coarse.mean()) <= tolerance || depth == most_halvings(dimension_)) {
    out.x.insert(out.x.end(), fine.x.begin(), fine.x.end());
    for (const double w : fine.weight) out.weight.push_back(box.weight * w);
    out.value.insert(out.value.end(), fine.value.begin(), fine.value.end());
    return;
  }
  const int parts = 1 << dimension_;
  for (int part = 0; part < parts; ++part) {
    Box half{box.low, box.high, box.weight / parts};
    for (int k = 0; k < dimension_; ++k) {
      const int a = axes_[k];
      (part >> k & 1 ? half.low : half.high)[a] = 0.5 * (box.low[a] + box.high[a]);
    }
    add_smooth(half, depth + 1, out);
  }
}

/// Two rules of the third degree, one with the corners and the middle, one with Gauss points: does one of them do? An
/// edge that leaves a corner outside makes them disagree.
bool BoxRule::add_quickly(const Box& box, Places& out) {
  const int corners = 1 << dimension_;
  std::array<Vec3, 9> x;
  std::array<double, 9> f{};
  for (int n = 0; n < corners; ++n) {
    x[n] = box.low;
    for (int k = 0; k < dimension_; ++k)
      if (n >> k & 1) x[n][axes_[k]] = box.high[axes_[k]];
  }
  x[corners] = 0.5 * (box.low + box.high);
  f_.f(std::span(x).first(corners + 1), std::span(f).first(corners + 1));
  const std::size_t known = out.x.size();
  add_product(box.low, box.high, 1, std::span(axes_).first(dimension_), 2, out);
  out.value.resize(out.x.size(), 0);
  if (std::ranges::all_of(f, [&](double value) { return std::abs(value) <= negligible * f_.scale; })) return true;
  f_.f(std::span(out.x).subspan(known), std::span(out.value).subspan(known));
  double outer = 2. / 3 * f[corners], inner = 0;
  for (int n = 0; n < corners; ++n) outer += f[n] / (3 * corners), inner += out.value[known + n] / corners;
  if (std::abs(inner - outer) <= quick_agreement * f_.scale) return true;
  out.x.resize(known), out.weight.resize(known), out.value.resize(known);
  return false;
}

/// Halves the interval with the larger step. That of a smooth function falls to a half every time.
std::optional<BoxRule::Jump> BoxRule::locate(int axis, const Vec3& place, double a, double b, double fa, double fb,
                                             int halvings) {
  const double first = std::abs(fb - fa);
  Vec3 x = place;
  int calm = 0;
  for (int n = 0; n < halvings; ++n) {
    x[axis] = 0.5 * (a + b);
    if (x[axis] <= a || x[axis] >= b) break;
    const double f = value(x), below = std::abs(f - fa), above = std::abs(fb - f);
    calm = std::max(below, above) < 0.6 * std::abs(fb - fa) ? calm + 1 : 0;
    if (calm == 2) return std::nullopt;
    if (below > above)
      b = x[axis], fb = f;
    else
      a = x[axis], fa = f;
  }
  if (std::abs(fb - fa) < 0.1 * first) return std::nullopt;  // steep, as a root at its beginning
  return Jump{place, a, b};
}

void BoxRule::find_on_line(int axis, Vec3 place, std::span<const double> s, std::span<const double> f,
                           std::vector<Jump>& found) {
  if (f_.quick && bends_little(s, f)) return;
  for (std::size_t k = 1; k < s.size(); ++k) {
    if (std::abs(f[k] - f[k - 1]) <= 1e-9 * size_) continue;
    if (const auto jump = locate(axis, place, s[k - 1], s[k], f[k - 1], f[k], rough)) found.push_back(*jump);
  }
}

/// Does the jump lie at the same coordinate a little aside, too? Lines on either side of the middle of a sphere see its
/// surface at one coordinate although it is no plane.
bool BoxRule::is_parallel(int axis, const Box& box, const Jump& jump) {
  Vec3 a = jump.place, b = a;
  a[axis] = jump.a, b[axis] = jump.b;
  const double step = std::abs(value(b) - value(a));
  for (int k = 0; k < dimension_; ++k) {
    const int other = axes_[k];
    if (other == axis) continue;
    const double half = 0.5 * (box.high[other] - box.low[other]);
    a[other] = b[other] = a[other] + 1e-3 * (a[other] < box.low[other] + half ? half : -half);
  }
  return std::abs(value(b) - value(a)) > 0.5 * step;
}

/// Coordinates at which the box is to be split: where jumps lie on planes.
std::vector<double> BoxRule::planes(int axis, const Box& box, const std::vector<Jump>& jumps) {
  std::vector<double> planes;
  const double width = box.high[axis] - box.low[axis], tolerance = 2e-5 * width;
  for (std::size_t k = 0; k < jumps.size();) {
    std::size_t end = k + 1;
    while (end < jumps.size() && jumps[end].at() - jumps[k].at() < tolerance) ++end;
    if (std::any_of(jumps.begin() + k, jumps.begin() + end,
                    [&](const Jump& jump) { return is_parallel(axis, box, jump); })) {
      Vec3 a = jumps[k].place, b = a;
      a[axis] = jumps[k].a, b[axis] = jumps[k].b;
      const auto jump = locate(axis, a, a[axis], b[axis], value(a), value(b), exact);
      const double at = jump.value_or(jumps[k]).at();
      if (at > box.low[axis] + inset * width && at < box.high[axis] - inset * width) planes.push_back(at);
    }
    k = end;
  }
  return planes;
}

void BoxRule::add_with_jumps(const Box& box, int depth, Places& out) {
  const int m = grid_points(dimension_);
  std::array<std::vector<double>, 3> s;
  for (int k = 0; k < dimension_; ++k) s[k] = grid_between(m, box.low[axes_[k]], box.high[axes_[k]]);
  const std::array<int, 3> stride = {1, m, m * m};
  const int count = dimension_ == 1 ? m : stride[dimension_ - 1] * m;
  std::vector<Vec3> x(count, box.low);
  std::vector<double> f(count);
  for (int n = 0; n < count; ++n)
    for (int k = 0; k < dimension_; ++k) x[n][axes_[k]] = s[k][n / stride[k] % m];
  f_.f(x, f);
  const auto [least, most] = std::ranges::minmax(f);
  size_ = std::max({size_, std::abs(least), std::abs(most)});
  if (most - least <= 1e-13 * size_) {
    emit_smooth(box, out);
    out.value.resize(out.x.size(), f[0]);
    return;
  }

  bool jumps_anywhere = false, is_split = false;
  std::array<std::vector<double>, 3> cuts;
  for (int k = 0; k < dimension_; ++k) {
    std::vector<Jump> jumps;
    std::vector<double> line(m);
    for (int n = 0; n < count; ++n) {
      if (n / stride[k] % m != 0) continue;
      for (int i = 0; i < m; ++i) line[i] = f[n + i * stride[k]];
      find_on_line(axes_[k], x[n], s[k], line, jumps);
    }
    std::ranges::sort(jumps, {}, &Jump::at);
    jumps_anywhere = jumps_anywhere || !jumps.empty();
    const int a = axes_[k];
    if (depth < most_splits) cuts[k] = planes(a, box, jumps);
    is_split = is_split || !cuts[k].empty();
    cuts[k].insert(cuts[k].begin(), box.low[a]);
    cuts[k].push_back(box.high[a]);
  }
  if (!jumps_anywhere) return add_smooth(box, 0, out);
  jumps_ = true;
  if (!is_split) return add_curved(box, 0, box.low, box.weight, out);
  for (int k = dimension_; k < 3; ++k) cuts[k] = {0, 1};
  for (std::size_t n2 = 1; n2 < cuts[2].size(); ++n2) {
    for (std::size_t n1 = 1; n1 < cuts[1].size(); ++n1) {
      for (std::size_t n0 = 1; n0 < cuts[0].size(); ++n0) {
        Box part = box;
        for (int k = 0; const std::size_t n : {n0, n1, n2}) {
          if (k < dimension_) {
            const int a = axes_[k];
            part.low[a] = cuts[k][n - 1], part.high[a] = cuts[k][n];
            part.weight *= (part.high[a] - part.low[a]) / (box.high[a] - box.low[a]);
          }
          ++k;
        }
        add_with_jumps(part, depth + 1, out);
      }
    }
  }
}

/// Nested: along one axis after the other between the jumps on a few lines, which for an edge through the sides of the
/// box are the kinks of the inner integral; on the last axis between the jumps of the one line.
void BoxRule::add_curved(const Box& box, int level, Vec3 place, double weight, Places& out) {
  const int axis = axes_[level], m = grid_points(dimension_), inner = dimension_ - 1 - level;
  const double low = box.low[axis], high = box.high[axis], width = high - low;
  const std::vector<double> s = grid_between(m, low, high);
  const int across = dimension_ == 3 ? 3 : m;  // lines, along every axis that is still to come
  int lines = 1;
  for (int k = 0; k < inner; ++k) lines *= across;
  std::vector<Jump> jumps;
  std::vector<Vec3> x(m);
  std::vector<double> f(m);
  for (int line = 0; line < lines; ++line) {
    Vec3 start = place;
    for (int k = 0, rest = line; k < inner; ++k, rest /= across) {
      const int a = axes_[level + 1 + k];
      start[a] = grid_between(across, box.low[a], box.high[a])[rest % across];
    }
    std::ranges::fill(x, start);
    for (int i = 0; i < m; ++i) x[i][axis] = s[i];
    f_.f(x, f);
    find_on_line(axis, start, s, f, jumps);
  }
  std::vector<double> ends = {low};
  std::ranges::sort(jumps, {}, &Jump::at);
  for (const Jump& jump : jumps)
    if (jump.at() - ends.back() > 1e-5 * width) ends.push_back(jump.at());
  ends.push_back(high);
  const Gauss& rule = gauss(inner > 0 && dimension_ == 3 ? 2 : 3);
  for (std::size_t n = 1; n < ends.size(); ++n) {
    const double length = ends[n] - ends[n - 1];
    for (std::size_t g = 0; g < rule.x.size(); ++g) {
      place[axis] = ends[n - 1] + rule.x[g] * length;
      const double w = weight * rule.weight[g] * length / width;
      if (inner > 0)
        add_curved(box, level + 1, place, w, out);
      else
        out.x.push_back(place), out.weight.push_back(w);
    }
  }
  if (level > 0) return;
  const std::size_t known = out.value.size();
  out.value.resize(out.x.size());
  f_.f(std::span(out.x).subspan(known), std::span(out.value).subspan(known));
}

}  // namespace calor
