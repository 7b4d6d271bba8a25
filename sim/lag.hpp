// First-order lags, exactly. Why: a step of any length must leave a lag where the differential equation does, and the
// same place on every C library, so no std::exp.
#pragma once

namespace halfroll::sim {

/// 1 - e^(-x), the share of the way to its target that a lag covers in x time constants; x >= 0, to 1e-15.
inline double covered(double x) {
  int halvings = 0;
  for (; x > 0.125; x *= 0.5) ++halvings;
  double term = x, sum = x;
  for (int k = 2; k < 14; ++k) sum += term *= -x / k;
  for (; halvings > 0; --halvings) sum *= 2.0 - sum;  // 1 - (1 - s)^2
  return sum;
}

/// The same for a step of `seconds`; a lag of 0 arrives at once.
inline double covered(double seconds, double lag) { return seconds < 700.0 * lag ? covered(seconds / lag) : 1.0; }

}  // namespace halfroll::sim
