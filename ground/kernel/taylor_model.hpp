// Univariate Taylor models: a polynomial of degree 7 in t on [-1, 1] and a remainder that holds whatever was left out.
// Why: with this scalar type the inverse dynamics bound themselves over a whole interval of time, rounding included,
// with an error that falls with the eighth power of the interval's length.
//
// Rounding: kUlp bounds the relative error of a handful of additions and products with a factor to spare; every
// operation adds it, times the sizes that entered, to the remainder. A model that failed has an infinite or NaN
// remainder.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace halfroll::planner {

struct TaylorModel {
  static constexpr int kDegree = 7;
  std::array<double, kDegree + 1> c{};
  double remainder = 0.0;

  static TaylorModel failed() {
    TaylorModel bad;
    bad.remainder = std::numeric_limits<double>::infinity();
    return bad;
  }
  /// Bound of |polynomial|.
  double size() const {
    double sum = 0.0;
    for (double coefficient : c) sum += std::abs(coefficient);
    return sum;
  }
};

struct Interval {
  double low, high;
};

constexpr double kUlp = 8.0 * std::numeric_limits<double>::epsilon();

inline TaylorModel operator+(const TaylorModel& a, const TaylorModel& b) {
  TaylorModel out;
  for (int i = 0; i <= TaylorModel::kDegree; ++i) out.c[i] = a.c[i] + b.c[i];
  out.remainder = (a.remainder + b.remainder) * (1.0 + kUlp) + kUlp * out.size();
  return out;
}

inline TaylorModel operator*(double k, const TaylorModel& a) {
  TaylorModel out;
  for (int i = 0; i <= TaylorModel::kDegree; ++i) out.c[i] = k * a.c[i];
  out.remainder = std::abs(k) * a.remainder * (1.0 + kUlp) + kUlp * out.size();
  return out;
}

inline TaylorModel operator-(const TaylorModel& a, const TaylorModel& b) { return a + -1.0 * b; }

inline TaylorModel operator+(const TaylorModel& a, double k) {
  TaylorModel out = a;
  out.c[0] += k;
  out.remainder += kUlp * std::abs(out.c[0]);
  return out;
}

inline TaylorModel operator*(const TaylorModel& a, const TaylorModel& b) {
  constexpr int P = TaylorModel::kDegree;
  TaylorModel out;
  double beyond = 0.0, tail = 0.0;  // products of degree > 7;  |b_j| summed over j > P - i
  for (int i = 0; i <= P; ++i) {
    for (int j = 0; j <= P - i; ++j) out.c[i + j] += a.c[i] * b.c[j];
    if (i > 0) tail += std::abs(b.c[P - i + 1]);
    beyond += std::abs(a.c[i]) * tail;
  }
  const double size_a = a.size(), size_b = b.size();
  out.remainder =
      (beyond + size_a * b.remainder + size_b * a.remainder + a.remainder * b.remainder) * (1.0 + 4.0 * kUlp) +
      4.0 * kUlp * size_a * size_b;
  return out;
}

/// a^exponent for a > 0, exponent < 0: a0^e times the binomial series of (1 + u)^e, |u| <= U < 0.7, Lagrange's
/// remainder.
inline TaylorModel power(const TaylorModel& a, double exponent) {
  constexpr int P = TaylorModel::kDegree;
  const double centre = a.c[0];
  if (!(centre > 0.0)) return TaylorModel::failed();
  TaylorModel u = (1.0 / centre) * a;
  u.remainder += kUlp;  // of its constant term, which is 1 but for rounding
  u.c[0] = 0.0;
  const double U = (u.size() + u.remainder) * (1.0 + kUlp);
  if (!(U < 0.7)) return TaylorModel::failed();
  std::array<double, P + 2> binomial{1.0};
  for (int i = 1; i <= P + 1; ++i) binomial[i] = binomial[i - 1] * (exponent - i + 1) / i;
  TaylorModel series;
  series.c[0] = binomial[P];
  for (int i = P - 1; i >= 0; --i) series = series * u + binomial[i];
  series.remainder +=
      std::abs(binomial[P + 1]) * std::pow(U, P + 1) * std::pow(1.0 - U, exponent - P - 1) * (1.0 + 1e-12);
  return std::pow(centre, exponent) * series;
}

inline TaylorModel inverse(const TaylorModel& a) { return power(a, -1.0); }
inline TaylorModel inverse_sqrt(const TaylorModel& a) { return power(a, -0.5); }

/// sin(a + shift), the series about its centre; |sin| <= 1 bounds the remainder.
inline TaylorModel sine(const TaylorModel& a, double shift = 0.0) {
  constexpr int P = TaylorModel::kDegree;
  TaylorModel u = a;
  u.c[0] = 0.0;
  const double U = (u.size() + u.remainder) * (1.0 + kUlp);
  if (!(U < 1.5)) return TaylorModel::failed();
  const double at = a.c[0] + shift;
  const std::array<double, 4> cycle = {std::sin(at), std::cos(at), -std::sin(at), -std::cos(at)};
  double factorial = 1.0;
  for (int i = 2; i <= P; ++i) factorial *= i;
  double next = U / (factorial * (P + 1));  // U^8/8!
  for (int i = 0; i < P; ++i) next *= U;
  TaylorModel series;
  for (int i = P; i >= 0; --i) {
    series = series * u + cycle[i % 4] / factorial;
    if (i > 0) factorial /= i;
  }
  series.remainder += next * (1.0 + kUlp) + kUlp * (1.0 + std::abs(at));
  return series;
}
inline TaylorModel cosine(const TaylorModel& a) { return sine(a, 1.57079632679489661923); }

/// Bounds over t in [-1, 1]: the polynomial lies between its Bernstein coefficients.
Interval range(const TaylorModel& a);

}  // namespace halfroll::planner
