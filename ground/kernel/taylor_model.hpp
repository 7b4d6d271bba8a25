// Univariate Taylor models: a polynomial of degree 7 in t on [-1, 1] and a remainder that holds whatever was left out.
// Why: with this scalar type the inverse dynamics bound themselves over a whole interval of time, rounding included,
// with an error that falls with the eighth power of the interval's length. Every number is a Pack: four intervals at
// once.
//
// Rounding: kUlp bounds the relative error of a handful of additions and products with a factor to spare; every
// operation adds it, times the sizes that entered, to the remainder. A model that failed has an infinite or NaN
// remainder.
#pragma once
#include <array>
#include <limits>

#include "pack.hpp"

namespace halfroll::planner {

struct TaylorModel {
  static constexpr int kDegree = 7;
  std::array<Pack, kDegree + 1> c{};
  Pack remainder{};

  /// Bound of |polynomial|.
  Pack size() const {
    Pack sum = absolute(c[0]);
    for (int i = 1; i <= kDegree; ++i) sum += absolute(c[i]);
    return sum;
  }
};

/// In each lane.
struct Interval {
  Pack low, high;
};

constexpr double kUlp = 8.0 * std::numeric_limits<double>::epsilon();

inline TaylorModel operator+(const TaylorModel& a, const TaylorModel& b) {
  TaylorModel out;
  for (int i = 0; i <= TaylorModel::kDegree; ++i) out.c[i] = a.c[i] + b.c[i];
  out.remainder = (1.0 + kUlp) * (a.remainder + b.remainder) + kUlp * out.size();
  return out;
}

inline TaylorModel operator-(const TaylorModel& a, const TaylorModel& b) {
  TaylorModel out;
  for (int i = 0; i <= TaylorModel::kDegree; ++i) out.c[i] = a.c[i] - b.c[i];
  out.remainder = (1.0 + kUlp) * (a.remainder + b.remainder) + kUlp * out.size();
  return out;
}

inline TaylorModel operator*(double k, const TaylorModel& a) {
  TaylorModel out;
  for (int i = 0; i <= TaylorModel::kDegree; ++i) out.c[i] = k * a.c[i];
  out.remainder = (std::abs(k) * (1.0 + kUlp)) * a.remainder + kUlp * out.size();
  return out;
}

inline TaylorModel operator+(const TaylorModel& a, const Pack& k) {
  TaylorModel out = a;
  out.c[0] += k;
  out.remainder += kUlp * absolute(out.c[0]);
  return out;
}
inline TaylorModel operator+(const TaylorModel& a, double k) { return a + splat(k); }

TaylorModel operator*(const TaylorModel& a, const TaylorModel& b);

/// 1/a; fails where a may reach zero.
TaylorModel inverse(const TaylorModel& a);
/// 1/sqrt(a); fails where a may not be positive.
TaylorModel inverse_sqrt(const TaylorModel& a);
TaylorModel sine(const TaylorModel& a);
TaylorModel cosine(const TaylorModel& a);

/// Bounds over t in [-1, 1]: the polynomial lies between its Bernstein coefficients. What failed has no bounds.
Interval range(const TaylorModel& a);

}  // namespace halfroll::planner
