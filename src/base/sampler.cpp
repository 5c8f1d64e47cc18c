#include "base/sampler.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"

namespace calor {
namespace {

constexpr double widest_ramp = 0.01, widest_part = 0x1p-15;  // K; of the highest temperature
constexpr int narrowest = 64;                                // pieces to a ramp
constexpr double accuracy_narrow = 1e-6;                     // of pieces narrower than ramps: those of kinks

/// What of the pieces lies in the interval, with their integrals.
SampledInterval inside(const std::vector<Piece>& all) {
  Broken broken;
  for (std::size_t n = 0; n < all.size(); ++n) {
    const double end = n + 1 < all.size() ? all[n + 1].begin : 1;
    if (end <= 0 || all[n].begin >= 1) continue;
    Piece piece = all[n];
    piece.begin = std::max(piece.begin, 0.0);
    piece.cubic.before = broken.area - piece.cubic.at<Ask::integral>(piece.begin - piece.origin);
    broken.area = piece.cubic.at<Ask::integral>(std::min(end, 1.0) - piece.origin);
    broken.pieces.push_back(piece);
  }
  return {{}, std::make_shared<const Broken>(std::move(broken))};
}

}  // namespace

const Piece& Broken::at(double s) const {
  const auto behind = std::upper_bound(pieces.begin() + 1, pieces.end(), s,
                                       [](double place, const Piece& p) { return place < p.begin; });
  return *std::prev(behind);
}

double Sampler::ramp(double level) { return std::min(widest_ramp, level * widest_part); }

Sampler::Sampler(const std::function<double(double)>& f, double step, double largest, double ramp)
    : f_(f), step_(step), largest_(largest), ramp_(ramp / step) {}

bool Sampler::is_smooth(double knot) const { return fits(knot, 0, 1, cubic(knot, 0, 1)); }

SampledInterval Sampler::interval(double knot) {
  const Cubic whole = cubic(knot, 0, 1);
  if (fits(knot, 0, 1, whole)) return {whole, nullptr};
  knot_ = knot;
  pieces_.clear();
  jumps_.clear();
  if (beyond(knot, -margin())) split(-margin(), 0);
  split(0, 1);
  if (beyond(knot, 1 + margin())) split(1, 1 + margin());
  return broken();
}

double Sampler::sample(double knot, double s) const {
  const double x = (knot + s) * step_, y = f_(x);
  if (!std::isfinite(y)) {
    throw Error(Fault::numbers, "a function to be tabulated is not finite at " + std::to_string(x),
                "make it finite over the whole range of temperatures");
  }
  return y;
}

std::optional<double> Sampler::beyond(double knot, double s) const {
  try {
    return sample(knot, s);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// The cubic through the function at 0, 1/4, 3/4 and 1 of a piece; its error has its maximum in the middle.
Cubic Sampler::cubic(double knot, double a, double b) const {
  const double width = b - a;
  const double f0 = sample(knot, a);
  const double d1 = sample(knot, a + 0.25 * width) - f0;
  const double d2 = sample(knot, a + 0.75 * width) - f0;
  const double d3 = sample(knot, b) - f0;
  return {.c0 = f0,
          .c1 = (8 * d1 - 8. / 3 * d2 + d3) / width,
          .c2 = (-56 * d1 + 40 * d2 - 16 * d3) / 3 / (width * width),
          .c3 = (32 * d1 - 32 * d2 + 16 * d3) / 3 / (width * width * width)};
}

bool Sampler::fits(double knot, double a, double b, const Cubic& c) const {
  const double width = b - a, relative = width < ramp_ / 4 ? accuracy_narrow : accuracy;
  const auto is_near = [&](double s, double f) {
    return std::abs(c.at<Ask::value>(s - a) - f) <= relative * std::max(largest_, std::abs(f));
  };
  // An odd number, so that the middle is one of them.
  const int places = static_cast<int>(std::ceil(width * step_ / scan)) | 1;
  for (int n = 0; n < places; ++n) {
    const double s = a + (n + 0.5) / places * width;
    if (!is_near(s, sample(knot, s))) return false;
  }
  if (width < 1) return true;
  for (const double s : {-margin(), 1 + margin()}) {
    const auto f = beyond(knot, s);
    if (f && !is_near(s, *f)) return false;
  }
  return true;
}

void Sampler::split(double a, double b) {
  const Cubic c = cubic(knot_, a, b);
  if (fits(knot_, a, b, c)) {
    pieces_.push_back({a, a, c});
  } else if (b - a > ramp_ / narrowest) {
    split(a, 0.5 * (a + b));
    split(0.5 * (a + b), b);
  } else {
    const double fa = sample(knot_, a);
    pieces_.push_back({a, a, {.c0 = fa, .c1 = (sample(knot_, b) - fa) / (b - a)}});
    if (const auto jump = jump_between(a, b)) jumps_.push_back(*jump);
  }
}

/// The place of a jump between two places, if most of the change is one.
std::optional<double> Sampler::jump_between(double a, double b) const {
  double fa = sample(knot_, a), fb = sample(knot_, b);
  const double whole = std::abs(fb - fa);
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = 0.5 * (a + b), f = sample(knot_, middle);
    if (std::abs(f - fa) >= std::abs(fb - f))
      b = middle, fb = f;
    else
      a = middle, fa = f;
  }
  if (std::abs(fb - fa) < 0.5 * whole) return std::nullopt;
  return b;
}

/// The pieces, with a ramp about every jump: half of it on either side, so that the integral is that of the jump.
SampledInterval Sampler::broken() const {
  std::vector<Piece> all;
  std::size_t next = 0;  // piece
  for (std::size_t j = 0; j < jumps_.size(); ++j) {
    double half = ramp_ / 2;
    if (j > 0) half = std::min(half, 0.5 * (jumps_[j] - jumps_[j - 1]));
    if (j + 1 < jumps_.size()) half = std::min(half, 0.5 * (jumps_[j + 1] - jumps_[j]));
    const double a = jumps_[j] - half, b = jumps_[j] + half;
    if (!(a < b)) continue;  // up and down at one place
    for (; next < pieces_.size() && pieces_[next].begin < a; ++next) all.push_back(pieces_[next]);
    const auto fa = beyond(knot_, a), fb = beyond(knot_, b);
    const Cubic ramp{.c0 = fa ? *fa : fb.value_or(0), .c1 = fa && fb ? (*fb - *fa) / (b - a) : 0};
    all.push_back({a, a, ramp});
    while (next < pieces_.size() && pieces_[next].begin < b) ++next;
    if (next > 0) all.push_back({b, pieces_[next - 1].origin, pieces_[next - 1].cubic});
  }
  all.insert(all.end(), pieces_.begin() + static_cast<std::ptrdiff_t>(next), pieces_.end());
  return inside(all);
}

}  // namespace calor
