#include "base/curve.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "base/knots.hpp"

namespace calor {
namespace {

/// Slopes at the points of a monotone cubic (Fritsch & Carlson, SIAM J. Numer. Anal. 17, 1980).
std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> h(n - 1), secant(n - 1), slope(n);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h[i] = x[i + 1] - x[i];
    secant[i] = (y[i + 1] - y[i]) / h[i];
  }
  if (n == 2) return {secant[0], secant[0]};

  // Slopes of the parabola through three neighbours, zero where they would not be monotone ...
  const auto at_end = [](double h0, double h1, double secant0, double secant1) {
    const double d = ((2 * h0 + h1) * secant0 - h0 * secant1) / (h0 + h1);
    return d * secant0 > 0 ? d : 0;
  };
  slope.front() = at_end(h[0], h[1], secant[0], secant[1]);
  slope.back() = at_end(h[n - 2], h[n - 3], secant[n - 2], secant[n - 3]);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (secant[i - 1] * secant[i] > 0) slope[i] = (h[i] * secant[i - 1] + h[i - 1] * secant[i]) / (h[i - 1] + h[i]);
  }
  // ... and brought into the circle of radius 3 where they are too steep.
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (secant[i] == 0) continue;
    const double steepness = std::hypot(slope[i] / secant[i], slope[i + 1] / secant[i]);
    if (steepness > 3) {
      slope[i] *= 3 / steepness;
      slope[i + 1] *= 3 / steepness;
    }
  }
  return slope;
}

class Points final : public Curve::Knots {
 public:
  Points(std::vector<double> x, const std::vector<double>& y, Interpolation interpolation) : x_(std::move(x)) {
    const std::size_t n = x_.size();
    const std::vector<double> slope =
        interpolation == Interpolation::cubic ? monotone_slopes(x_, y) : std::vector<double>(n);
    // Interval i lies to the left of point i; the first and the last one reach to infinity.
    from_.push_back(x_.front());
    cubics_.push_back({.c0 = y.front()});
    for (std::size_t i = 0; i + 1 < n; ++i) {
      const double h = x_[i + 1] - x_[i];
      const double secant = (y[i + 1] - y[i]) / h;
      Cubic c{.c0 = y[i], .c1 = secant, .before = integral_at(x_[i])};
      if (interpolation == Interpolation::cubic) {
        c.c1 = slope[i];
        c.c2 = (3 * secant - 2 * slope[i] - slope[i + 1]) / h;
        c.c3 = (slope[i] + slope[i + 1] - 2 * secant) / (h * h);
      }
      from_.push_back(x_[i]);
      cubics_.push_back(c);
    }
    const double end = integral_at(x_.back());
    from_.push_back(x_.back());
    cubics_.push_back({.c0 = y.back(), .before = end});

    constexpr std::size_t buckets_per_knot = 8;
    below_.resize(buckets_per_knot * n);
    buckets_per_x_ = below_.size() / (x_.back() - x_.front());
    std::size_t knot = 0;
    for (std::size_t b = 0; b < below_.size(); ++b) {
      while (knot < n && bucket(x_[knot]) < b) ++knot;
      below_[b] = knot;
    }
    x_.push_back(std::numeric_limits<double>::quiet_NaN());  // not <= anything

    // So far from the first point on; from zero on is what was promised.
    double origin = 0;
    const double zero = 0;
    evaluate(Ask::integral, {&zero, 1}, {&origin, 1});
    for (Cubic& c : cubics_) c.before -= origin;
  }

  void evaluate(Ask ask, std::span<const double> x, std::span<double> out) const override {
    if (ask == Ask::value) evaluate<Ask::value>(x, out);
    if (ask == Ask::derivative) evaluate<Ask::derivative>(x, out);
    if (ask == Ask::integral) evaluate<Ask::integral>(x, out);
  }

  ValueRange reach() const override {
    const std::vector<double> at = kinks();
    ValueRange found = everywhere;
    if (std::ranges::count(at, from_.front())) found.low = from_.front();
    if (std::ranges::count(at, from_.back())) found.high = from_.back();
    return found;
  }
  std::vector<double> kinks() const override {
    std::vector<double> found;
    for (std::size_t i = 0; i + 1 < x_.size(); ++i) {
      const double left = cubics_[i].at<Ask::derivative>(x_[i] - from_[i]);
      const double right = cubics_[i + 1].c1;
      const double rounding = 1e-12 * (std::abs(left) + std::abs(right));
      if (std::abs(left - right) > rounding) found.push_back(x_[i]);
    }
    return found;
  }

 private:
  /// Integral of the intervals so far.
  double integral_at(double x) const { return cubics_.back().at<Ask::integral>(x - from_.back()); }

  template <Ask ask>
  void evaluate(std::span<const double> x, std::span<double> out) const {
    for (std::size_t i = 0; i < x.size(); ++i) {
      std::size_t interval = below_[bucket(x[i])];
      while (x_[interval] <= x[i]) ++interval;  // ends at the sentinel at the latest
      out[i] = cubics_[interval].at<ask>(x[i] - from_[interval]);
    }
  }

  /// Equal buckets over the table; rounding cannot put a smaller x into a higher one. NaN goes into the last.
  std::size_t bucket(double x) const {
    const double b = (x - x_.front()) * buckets_per_x_;
    const auto last = static_cast<double>(below_.size() - 1);
    const double inside = b < last ? b : last;
    return static_cast<std::size_t>(inside > 0 ? inside : 0);
  }

  std::vector<double> x_;     ///< the knots and, as a sentinel, NaN
  std::vector<double> from_;  ///< left knots of the intervals
  std::vector<Cubic> cubics_;
  std::vector<std::uint32_t> below_;  ///< of each bucket: how many knots lie in the buckets below it
  double buckets_per_x_;
};

}  // namespace

Curve Curve::constant(double value) {
  Curve curve;
  curve.constant_ = value;
  return curve;
}

Curve Curve::through(std::vector<double> x, std::vector<double> y, Interpolation interpolation) {
  if (x.size() != y.size() || x.size() < 2) throw std::invalid_argument("a table needs at least two rows");
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) {
      throw std::invalid_argument("row " + std::to_string(i + 1) + " of the table is not finite");
    }
    if (i > 0 && !(x[i] > x[i - 1])) {
      throw std::invalid_argument("the first column of the table does not increase at row " + std::to_string(i + 1));
    }
  }
  Curve curve;
  curve.knots_ = std::make_shared<Points>(std::move(x), y, interpolation);
  return curve;
}

void Curve::values(std::span<const double> x, std::span<double> out) const {
  if (knots_) return knots_->evaluate(Ask::value, x, out);
  std::fill(out.begin(), out.end(), constant_);
}

void Curve::derivatives(std::span<const double> x, std::span<double> out) const {
  if (knots_) return knots_->evaluate(Ask::derivative, x, out);
  std::fill(out.begin(), out.end(), 0.0);
}

void Curve::integrals(std::span<const double> x, std::span<double> out) const {
  if (knots_) return knots_->evaluate(Ask::integral, x, out);
  for (std::size_t i = 0; i < x.size(); ++i) out[i] = constant_ * x[i];
}

double Curve::value(double x) const {
  double y = 0;
  values({&x, 1}, {&y, 1});
  return y;
}

double Curve::derivative(double x) const {
  double y = 0;
  derivatives({&x, 1}, {&y, 1});
  return y;
}

double Curve::integral(double x) const {
  double y = 0;
  integrals({&x, 1}, {&y, 1});
  return y;
}

bool Curve::is_constant() const { return !knots_; }

ValueRange Curve::reach() const { return knots_ ? knots_->reach() : Knots::everywhere; }

std::vector<double> Curve::kinks() const { return knots_ ? knots_->kinks() : std::vector<double>{}; }

}  // namespace calor
