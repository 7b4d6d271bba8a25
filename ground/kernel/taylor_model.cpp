#include "taylor_model.hpp"

namespace halfroll::planner {
namespace {

constexpr int P = TaylorModel::kDegree;
constexpr double kRoundings = 4.0 * kUlp;  // of sums of up to 28 products
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kLargestAngle = 1e5;  // that `sine` of a Pack reduces exactly

/// Taylor series of a power of a: k a0 g_k = sum_j ((exponent + 1) j - k) a_j g_(k-j).
struct PowerSeries {
  double weight[P + 1][P + 1] = {};
  explicit PowerSeries(double exponent) {
    for (int k = 1; k <= P; ++k) {
      for (int j = 1; j <= k; ++j) weight[k][j] = ((exponent + 1.0) * j - k) / k;
    }
  }
};

inline void continue_series(const TaylorModel& a, const Pack& inverse_centre, const PowerSeries& series,
                            TaylorModel& out) {
  for (int k = 1; k <= P; ++k) {
    Pack sum{};
    for (int j = 1; j <= k; ++j) sum += series.weight[k][j] * (a.c[j] * out.c[k - j]);
    out.c[k] = inverse_centre * sum;
  }
}

/// Bound of |a - 1|.
inline Pack off_one(const TaylorModel& a) {
  TaylorModel off = a;
  off.c[0] = off.c[0] + -1.0;
  return (1.0 + kUlp) * (off.size() + off.remainder + splat(kUlp));
}

/// Products of degree > 7, in size.
inline Pack beyond(const std::array<Pack, P + 1>& a, const std::array<Pack, P + 1>& b) {
  Pack sum{}, tail{};
  for (int i = 1; i <= P; ++i) {
    tail += absolute(b[P - i + 1]);
    sum += absolute(a[i]) * tail;
  }
  return sum;
}

/// cos a and sin a: the series z of e^(i u), u the polynomial of a. That e^(-i u) z stays near 1 is its proof: it
/// moves by no more than the integral of z' - i u' z, in which everything below degree 7 vanishes.
inline void turn(const TaylorModel& a, TaylorModel& cos, TaylorModel& sin) {
  std::array<Pack, P + 1> rate{};  // j u_j
  Pack rates{};
  for (int j = 1; j <= P; ++j) {
    rate[j] = static_cast<double>(j) * a.c[j];
    rates += absolute(rate[j]);
  }
  cos.c[0] = cosine(a.c[0]);
  sin.c[0] = sine(a.c[0]);
  Pack grown{};
  for (int k = 1; k <= P; ++k) {
    Pack c{}, s{};
    for (int j = 1; j <= k; ++j) {
      c -= rate[j] * sin.c[k - j];
      s += rate[j] * cos.c[k - j];
    }
    cos.c[k] = (1.0 / k) * c;
    sin.c[k] = (1.0 / k) * s;
    grown += absolute(c) + absolute(s);
  }
  const Pack sizes = cos.size() + sin.size();
  const Pack residual =
      (1.0 / (P + 1)) * (beyond(rate, cos.c) + beyond(rate, sin.c)) + kRoundings * (rates * sizes + grown);
  const Pack start = kUlp * (absolute(a.c[0]) + 1.0);
  const Pack error = (1.0 + kUlp) * (residual + start + a.remainder);
  cos.remainder = sin.remainder = select(absolute(a.c[0]).v < kLargestAngle, error, splat(kInfinite));
}

}  // namespace

HALFROLL_WIDE TaylorModel operator*(const TaylorModel& a, const TaylorModel& b) {
  TaylorModel out;
  for (int k = 0; k <= P; ++k) {
    Pack sum = a.c[0] * b.c[k];
    for (int i = 1; i <= k; ++i) sum += a.c[i] * b.c[k - i];
    out.c[k] = sum;
  }
  const Pack size_a = a.size(), size_b = b.size();
  out.remainder = (1.0 + kRoundings) *
                      (beyond(a.c, b.c) + size_a * b.remainder + size_b * a.remainder + a.remainder * b.remainder) +
                  kRoundings * (size_a * size_b);
  return out;
}

/// g, the series to degree 7, and r = a g - 1 say that 1/a = g/(1 + r).
HALFROLL_WIDE TaylorModel inverse(const TaylorModel& a) {
  static const PowerSeries series(-1.0);
  TaylorModel g;
  const Pack inverse_centre = g.c[0] = inverse(a.c[0]);
  continue_series(a, inverse_centre, series, g);
  const Pack r = off_one(a * g);
  g.remainder = (1.0 + kRoundings) * (g.size() * r * inverse(splat(1.0) - r));
  g.remainder = select(r.v < 0.5, g.remainder, splat(kInfinite));
  return g;
}

/// As for the inverse, with r = a g² - 1: 1/sqrt(a) = g/sqrt(1 + r), and 1/sqrt(1 - r) - 1 <= r/(2 - 2 r).
HALFROLL_WIDE TaylorModel inverse_sqrt(const TaylorModel& a) {
  static const PowerSeries series(-0.5);
  TaylorModel g;
  g.c[0] = inverse_sqrt(a.c[0]);
  continue_series(a, g.c[0] * g.c[0], series, g);
  const Pack r = off_one(a * (g * g));
  g.remainder = (0.5 * (1.0 + kRoundings)) * (g.size() * r * inverse(splat(1.0) - r));
  g.remainder = select(r.v < 0.5, g.remainder, splat(kInfinite));
  return g;
}

HALFROLL_WIDE TaylorModel sine(const TaylorModel& a) {
  TaylorModel cos, sin;
  turn(a, cos, sin);
  return sin;
}

HALFROLL_WIDE TaylorModel cosine(const TaylorModel& a) {
  TaylorModel cos, sin;
  turn(a, cos, sin);
  return cos;
}

namespace {

/// Bernstein coefficients of the powers of t on [-1, 1]. They mirror each other: even powers give the same from both
/// ends, odd ones the opposite.
std::array<std::array<double, P + 1>, P + 1> bernstein() {
  double binomial[P + 1][P + 1] = {};
  for (int i = 0; i <= P; ++i) {
    for (int j = 0; j <= i; ++j) binomial[i][j] = j == 0 || j == i ? 1.0 : binomial[i - 1][j - 1] + binomial[i - 1][j];
  }
  std::array<std::array<double, P + 1>, P + 1> matrix{};
  for (int k = 0; k <= P; ++k) {
    for (int j = 0; j <= k; ++j) {  // (2 x - 1)^k
      const double power = binomial[k][j] * std::ldexp((k - j) % 2 == 0 ? 1.0 : -1.0, j);
      for (int i = j; i <= P; ++i) matrix[i][k] += binomial[i][j] / binomial[P][j] * power;
    }
  }
  return matrix;
}

inline Pack lower(const Pack& a, const Pack& b) { return select(a.v < b.v, a, b); }
inline Pack higher(const Pack& a, const Pack& b) { return select(a.v > b.v, a, b); }

}  // namespace

HALFROLL_WIDE Interval range(const TaylorModel& a) {
  static const auto matrix = bernstein();
  Interval interval{splat(kInfinite), splat(-kInfinite)};
  for (int i = 0; i <= P / 2; ++i) {
    Pack even = a.c[0], odd{};
    for (int k = 1; k <= P; k += 2) odd += matrix[i][k] * a.c[k];
    for (int k = 2; k <= P; k += 2) even += matrix[i][k] * a.c[k];
    const Pack one = even + odd, other = even - odd;
    interval.low = lower(interval.low, lower(one, other));
    interval.high = higher(interval.high, higher(one, other));
  }
  const Pack spread = a.remainder + kUlp * 8.0 * a.size();  // |Bernstein coefficient of t^k| <= 1
  const auto known = spread.v < kInfinite;
  return {select(known, interval.low - spread, splat(-kInfinite)),
          select(known, interval.high + spread, splat(kInfinite))};
}

}  // namespace halfroll::planner
