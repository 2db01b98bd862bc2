#include "sim/laws/elementary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace graintruth::sim {

namespace {

// high + low, where low is at most half a unit in the last place of high. Sums and products are
// those of Dekker (1971) and Knuth; no operation may be contracted or reordered, which the options
// of the build see to.
struct Twice {
  double high = 0.0, low = 0.0;
};

Twice fast_sum(double a, double b) {  // |a| >= |b|
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

Twice sum_of(double a, double b) {
  const double sum = a + b, part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

Twice product_of(double a, double b) {
  constexpr double splitter = 134217729.0;  // 2^27 + 1
  const double product = a * b;
  const double ca = splitter * a, a1 = ca - (ca - a), a2 = a - a1;
  const double cb = splitter * b, b1 = cb - (cb - b), b2 = b - b1;
  return {product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
}

Twice operator+(Twice a, Twice b) {
  Twice high = sum_of(a.high, b.high);
  const Twice low = sum_of(a.low, b.low);
  high = fast_sum(high.high, high.low + low.high);
  return fast_sum(high.high, high.low + low.low);
}

Twice operator-(Twice a) { return {-a.high, -a.low}; }
Twice operator-(Twice a, Twice b) { return a + (-b); }

Twice operator*(Twice a, Twice b) {
  const Twice high = product_of(a.high, b.high);
  return fast_sum(high.high, high.low + (a.high * b.low + a.low * b.high));
}

Twice operator/(Twice a, Twice b) {
  const double first = a.high / b.high;
  const Twice rest = a - b * Twice{first};
  const double second = rest.high / b.high;
  const Twice last = rest - b * Twice{second};
  return fast_sum(first, second) + Twice{last.high / b.high};
}

Twice scaled(Twice a, int exponent) {
  return {std::ldexp(a.high, exponent), std::ldexp(a.low, exponent)};
}

double rounded(Twice a) { return a.high + a.low; }

// To some 160 bits
constexpr double log_2[] = {0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56, 0x1.7b57a079a1934p-111};
constexpr Twice two_over_root_pi = {0x1.20dd750429b6dp+0, 0x1.1ae3a914fed80p-56};

// count times a constant that is given in parts, the smallest first
template <std::size_t parts>
Twice multiple_of(const double (&constant)[parts], double count) {
  Twice sum;
  for (std::size_t i = parts; i-- > 0;) sum = sum + product_of(constant[i], count);
  return sum;
}

// e^x = 2^k (e^(r / 2^9))^(2^9),  r = x - k ln 2;  e^s - 1 by its series, |s| < 7e-4
Twice exp_of(Twice x) {
  constexpr int halvings = 9, terms = 10;
  const double k = std::nearbyint(x.high / log_2[0]);
  const Twice s = scaled(x - multiple_of(log_2, k), -halvings);
  Twice less_one = s / Twice{static_cast<double>(terms)};
  for (int n = terms - 1; n >= 1; --n)
    less_one = s * (Twice{1.0} + less_one) / Twice{static_cast<double>(n)};
  // (1 + a)^2 - 1 = a (2 + a) loses nothing of a small a
  for (int i = 0; i < halvings; ++i) less_one = less_one * (Twice{2.0} + less_one);
  return scaled(Twice{1.0} + less_one, static_cast<int>(k));
}

// ln(2^k m) = k ln 2 + 2 artanh((m - 1)/(m + 1)),  m within the root of 2 of 1
Twice log_of(Twice x) {
  constexpr int terms = 24;
  int k = 0;
  if (std::frexp(x.high, &k) < std::numbers::sqrt2 / 2.0) --k;
  const Twice m = scaled(x, -k);
  const Twice s = (m - Twice{1.0}) / (m + Twice{1.0}), square = s * s;
  Twice sum;
  for (int n = terms; n >= 0; --n) sum = sum * square + Twice{1.0} / Twice{2.0 * n + 1.0};
  return multiple_of(log_2, static_cast<double>(k)) + scaled(s * sum, 1);
}

// Of y >= 0 and x > 0, y <= x: from an angle that is nearly right, by the tangent of the rest
//   tan(a - a0) = (y cos a0 - x sin a0)/(x cos a0 + y sin a0)
double angle_below_half_right(double y, double x) {
  const double ratio = y / x;
  const double angle = ratio * (std::numbers::pi / 4.0 + 0.273 * (1.0 - ratio));  // to 0.004
  const auto [sine, cosine] = steady_sine_and_cosine(angle);
  const double u = (y * cosine - x * sine) / (x * cosine + y * sine), square = u * u;
  return angle + u * (1.0 - square * (1.0 / 3.0 - square * (1.0 / 5.0 - square / 7.0)));
}

}  // namespace

double exact_exp(double x) { return rounded(exp_of({x})); }

double exact_log(double x) { return rounded(log_of({x})); }

double exact_log1p(double x) {
  // Where 1 + x has more digits than two doubles hold, the series is x - x^2/2
  if (std::abs(x) < 0x1p-60) return x;
  return rounded(log_of(sum_of(1.0, x)));
}

double exact_pow(double x, double y) {
  if (y == 0.0 || x == 1.0) return 1.0;
  if (x == 0.0) return y > 0.0 ? 0.0 : std::numeric_limits<double>::infinity();
  return rounded(exp_of(log_of({x}) * Twice{y}));
}

// Newton's method on y^3 = x, in the end with the rest in twice the precision
double exact_cbrt(double x) {
  if (x == 0.0 || !std::isfinite(x)) return x;
  int exponent = 0;
  std::frexp(x, &exponent);
  const int third = (exponent + 3 * 400) / 3 - 400;  // rounds down
  const double m = std::ldexp(std::abs(x), -3 * third);
  double y = 0.7 + 0.4 * m;
  for (int i = 0; i < 6; ++i) y -= (y * y * y - m) / (3.0 * y * y);
  const Twice square = product_of(y, y);
  const Twice better = Twice{y} - (square * Twice{y} - Twice{m}) / (Twice{3.0} * square);
  return std::copysign(std::ldexp(rounded(better), third), x);
}

// 2/sqrt(pi) sum (-1)^n x^(2n+1)/(n! (2n+1)) as 2/sqrt(pi) e^(-x^2) sum 2^n x^(2n+1)/(2n+1)!!,
// whose terms have one sign
double exact_erf(double x) {
  if (x == 0.0) return x;
  const Twice square = product_of(x, x);
  Twice term{x}, sum{x};
  for (int n = 1; std::abs(term.high) > 0x1p-110 * std::abs(sum.high); ++n) {
    term = term * scaled(square, 1) / Twice{2.0 * n + 1.0};
    sum = sum + term;
  }
  return rounded(two_over_root_pi * exp_of(-square) * sum);
}

// sin r = r - r^3/3! + ...,  cos r = 1 - r^2/2! + ...,  r = x - k pi/2 within pi/4
SineAndCosine steady_sine_and_cosine(double x) {
  // pi/2 in parts of 33 bits, so that k times each is exact, and what is left
  constexpr double first = 0x1.921fb544p+0, second = 0x1.0b4611a6p-34, rest = 0x1.3198a2e037073p-69;
  const double k = std::nearbyint(x / first);
  const double a = x - k * first, b = k * second, c = a - b;
  const double lost = k * rest - ((a - c) - b);
  const double r = c - lost, low = (c - r) - lost, z = r * r;
  double s = 1.0 / 355687428096000.0, t = 1.0 / 6402373705728000.0;  // 1/17!, 1/18!
  for (const double factorial :
       {-1307674368000.0, 6227020800.0, -39916800.0, 362880.0, -5040.0, 120.0, -6.0})
    s = s * z + 1.0 / factorial;
  t = -t;
  for (const double factorial :
       {20922789888000.0, -87178291200.0, 479001600.0, -3628800.0, 40320.0, -720.0, 24.0})
    t = t * z + 1.0 / factorial;
  const double sine = r + (z * r * s + low * (1.0 - 0.5 * z));
  const double half = 0.5 * z, one = 1.0 - half;
  const double cosine = one + (((1.0 - one) - half) + (z * z * t - r * low));
  switch (static_cast<long long>(k) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

double steady_sin(double x) { return steady_sine_and_cosine(x).sine; }

double steady_cos(double x) { return steady_sine_and_cosine(x).cosine; }

double steady_tan(double x) {
  const auto [sine, cosine] = steady_sine_and_cosine(x);
  return sine / cosine;
}

double steady_atan2(double y, double x) {
  const bool is_below = std::signbit(y), is_left = std::signbit(x);
  y = std::abs(y);
  x = std::abs(x);
  double angle = 0.0;
  if (y > x) {
    angle = 0.5 * std::numbers::pi - angle_below_half_right(x, y);
  } else if (y > 0.0) {
    angle = angle_below_half_right(y, x);
  }
  if (is_left) angle = std::numbers::pi - angle;
  return is_below ? -angle : angle;
}

double steady_asin(double x) { return steady_atan2(x, std::sqrt((1.0 - x) * (1.0 + x))); }

double steady_acos(double x) { return steady_atan2(std::sqrt((1.0 - x) * (1.0 + x)), x); }

}  // namespace graintruth::sim
