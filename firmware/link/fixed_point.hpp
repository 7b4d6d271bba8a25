// Numbers with 60 bits after the point, in 64-bit integers. Why: geodesy needs more than a float's 24 bits, and a
// double costs a call into a software library on a microcontroller, whose sine is not the host's.
#pragma once
#include <cstdint>

namespace halfroll::link::fixed {

using Q60 = std::int64_t;  // in units of 2^-60
inline constexpr Q60 kOne = Q60{1} << 60U;

/// Product, rounded down, of numbers that multiply to less than 4 in magnitude and are less than 4 themselves.
constexpr Q60 times(Q60 a, Q60 b) {
  constexpr std::int64_t kLow = (std::int64_t{1} << 30U) - 1;
  const std::int64_t a1 = a >> 30, a0 = a & kLow, b1 = b >> 30, b0 = b & kLow;
  return a1 * b1 + ((a1 * b0 + a0 * b1 + ((a0 * b0) >> 30)) >> 30);
}

/// a / b, towards zero, for |a| <= b < 2^32.
constexpr Q60 ratio(std::int64_t a, std::int64_t b) {
  constexpr std::int64_t kHalfWay = std::int64_t{1} << 30U;
  const std::int64_t wide = a * kHalfWay;
  return wide / b * kHalfWay + wide % b * kHalfWay / b;
}

struct Turn {
  Q60 sine, cosine;
};

/// Of an angle in [-1, 1] quarter turns, by Taylor's series: error below 1e-15.
constexpr Turn turn(Q60 quarters) {
  constexpr Q60 kQuarter = 1811004864519280711;  // pi/2
  const Q60 angle = times(quarters, kQuarter), square = times(angle, angle);
  Turn out{0, 0};
  Q60 odd = angle, even = kOne;
  for (int k = 1; k < 24; k += 2) {
    out.sine += odd;
    out.cosine += even;
    even = -times(even, square) / (k * (k + 1));
    odd = -times(odd, square) / ((k + 1) * (k + 2));
  }
  return out;
}

/// 1 / sqrt(x) for x in [0.99, 1], by Newton's method.
constexpr Q60 inverse_root(Q60 x) {
  Q60 y = kOne;
  for (int i = 0; i < 4; ++i) y += times(y, kOne - times(x, times(y, y))) / 2;
  return y;
}

}  // namespace halfroll::link::fixed
