// Sine, cosine and arctangent in float arithmetic alone. Why: libm's differ between C libraries, and host, module and
// board must fly the same bits. Polynomials after Cephes (S. Moshier), least-squares on the reduced interval.
//
// Absolute error at most 2e-6 for |x| <= 1000 (tests/cpp/core/trig_test.cpp measures 3e-7). Arguments that are not
// finite, or beyond 1e5 where a float no longer tells where in a turn it is, count as 0: a NaN never gets out.
#pragma once
#include <cmath>
#include <limits>

namespace halfroll {

inline constexpr float kPi = 3.14159265358979F;

namespace trig {

/// x = quarter_turns * pi/2 + rest, rest in [-pi/4, pi/4].
struct Reduced {
  int quarter_turns;
  float rest;
};

inline Reduced reduce(float x) {
  if (!(std::abs(x) <= 1e5F)) return {0, 0.F};
  const int k = static_cast<int>(x * (2.F / kPi) + (x < 0.F ? -0.5F : 0.5F));
  const auto turns = static_cast<float>(k);
  // pi/2 in three parts; the first two are short, so their products are exact in the range of interest
  return {k, ((x - turns * 1.5703125F) - turns * 4.837512969970703125e-4F) - turns * 7.54978995489188216e-8F};
}

inline float sine_of_rest(float r) {
  const float z = r * r;
  return r + r * z * (-1.6666654611e-1F + z * (8.3321608736e-3F - z * 1.9515295891e-4F));
}

inline float cosine_of_rest(float r) {
  const float z = r * r;
  return 1.F - 0.5F * z + z * z * (4.166664568298827e-2F + z * (-1.388731625493765e-3F + z * 2.443315711809948e-5F));
}

/// Arctangent of t in [0, 1].
inline float arctangent_of_ratio(float t) {
  const bool steep = t > 0.41421356F;  // tangent of pi/8
  const float r = steep ? (t - 1.F) / (t + 1.F) : t;
  const float z = r * r;
  const float bend = ((8.05374449538e-2F * z - 1.38776856032e-1F) * z + 1.99777106478e-1F) * z - 3.33329491539e-1F;
  return (steep ? kPi / 4.F : 0.F) + (r + r * z * bend);
}

}  // namespace trig

inline float sine(float x) {
  const trig::Reduced a = trig::reduce(x);
  const float s = (a.quarter_turns & 1) != 0 ? trig::cosine_of_rest(a.rest) : trig::sine_of_rest(a.rest);
  return (a.quarter_turns & 2) != 0 ? -s : s;
}

inline float cosine(float x) {
  const trig::Reduced a = trig::reduce(x);
  const float c = (a.quarter_turns & 1) != 0 ? trig::sine_of_rest(a.rest) : trig::cosine_of_rest(a.rest);
  return ((a.quarter_turns + 1) & 2) != 0 ? -c : c;
}

/// Angle of (x, y) in [-pi, pi]; 0 where there is none (origin, not finite).
inline float arctangent2(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float longer = ax > ay ? ax : ay, shorter = ax > ay ? ay : ax;
  if (!(longer > 0.F && longer <= std::numeric_limits<float>::max()) || !(shorter <= longer)) return 0.F;
  float angle = trig::arctangent_of_ratio(shorter / longer);
  if (ay > ax) angle = kPi / 2.F - angle;
  if (x < 0.F) angle = kPi - angle;
  return y < 0.F ? -angle : angle;
}

/// The same angle in [-pi, pi).
inline float wrapped_angle(float angle) {
  if (!(std::abs(angle) <= 1e5F)) return 0.F;
  const auto turns = static_cast<float>(static_cast<int>(angle / (2.F * kPi) + (angle < 0.F ? -0.5F : 0.5F)));
  return angle - turns * (2.F * kPi);
}

}  // namespace halfroll
