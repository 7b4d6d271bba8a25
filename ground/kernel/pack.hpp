// Four samples at once. Why: the inverse dynamics are written once, for one scalar type; with this one the compiler
// turns every operation into vector instructions.
#pragma once
#include <cmath>
#include <cstring>

// A function that is compiled twice, for every x86 processor and for those with AVX2 and FMA; the loader takes the one
// that fits. All it calls is inlined into it. Sanitizers cannot run before the loader has chosen.
#if defined(__x86_64__) && !defined(__clang__) && __GNUC__ >= 12 && !defined(__SANITIZE_ADDRESS__)
#define HALFROLL_WIDE __attribute__((flatten, target_clones("arch=x86-64-v3", "default")))
#else
#define HALFROLL_WIDE
#endif

namespace halfroll::planner {

struct Pack {
  static constexpr int kWidth = 4;
  typedef double Lanes __attribute__((vector_size(kWidth * sizeof(double))));
  Lanes v;
};

inline Pack splat(double x) { return {Pack::Lanes{x, x, x, x}}; }
inline Pack load(const double* p) {
  Pack pack;
  std::memcpy(&pack.v, p, sizeof pack.v);
  return pack;
}
inline void store(double* p, const Pack& pack) { std::memcpy(p, &pack.v, sizeof pack.v); }

inline Pack operator+(const Pack& a, const Pack& b) { return {a.v + b.v}; }
inline Pack operator-(const Pack& a, const Pack& b) { return {a.v - b.v}; }
inline Pack operator*(const Pack& a, const Pack& b) { return {a.v * b.v}; }
inline Pack operator*(double a, const Pack& b) { return {a * b.v}; }
inline Pack operator+(const Pack& a, double b) { return {a.v + b}; }
inline Pack& operator+=(Pack& a, const Pack& b) {
  a.v += b.v;
  return a;
}
inline Pack& operator-=(Pack& a, const Pack& b) {
  a.v -= b.v;
  return a;
}
/// In each lane `a` where the comparison of two Lanes holds, else `b`.
template <class Mask>
inline Pack select(const Mask& holds, const Pack& a, const Pack& b) {
  return {holds ? a.v : b.v};
}
inline Pack absolute(const Pack& a) { return select(a.v < 0.0, splat(0.0) - a, a); }
inline double sum(const Pack& a) { return (a.v[0] + a.v[1]) + (a.v[2] + a.v[3]); }

inline Pack inverse(const Pack& a) { return {1.0 / a.v}; }
inline Pack inverse_sqrt(const Pack& a) {
  Pack root = a;
  for (int i = 0; i < Pack::kWidth; ++i) root.v[i] = std::sqrt(a.v[i]);
  return inverse(root);
}

/// sin(x + quarter pi/2) to the last bits for |x| < 1e5: Cody-Waite reduction to |r| <= pi/4, then the Taylor series.
inline Pack sine(const Pack& x, long long quarter = 0) {
  typedef long long Integers __attribute__((vector_size(sizeof(Pack::Lanes))));
  constexpr double kRound = 6755399441055744.0;  // 1.5 2^52: adding it leaves the nearest whole number in the low bits
  const Pack::Lanes shifted = x.v * 0.63661977236758134308 + kRound;
  const Pack::Lanes turns = shifted - kRound;
  const Pack::Lanes r = ((x.v - turns * 1.57079632673412561417) - turns * 6.07710050630396597660e-11) -
                        turns * 2.02226624879595063154e-21;
  Integers quadrant;
  std::memcpy(&quadrant, &shifted, sizeof quadrant);
  quadrant += quarter;
  const Pack::Lanes z = r * r;
  const Pack::Lanes odd =
      r + r * z *
              (-1.0 / 6 +
               z * (1.0 / 120 + z * (-1.0 / 5040 +
                                     z * (1.0 / 362880 + z * (-1.0 / 39916800 + z * (1.0 / 6227020800.0 -
                                                                                     z * (1.0 / 1307674368000.0)))))));
  const Pack::Lanes even =
      1.0 +
      z * (-0.5 +
           z * (1.0 / 24 + z * (-1.0 / 720 +
                                z * (1.0 / 40320 + z * (-1.0 / 3628800 +
                                                        z * (1.0 / 479001600 + z * (-1.0 / 87178291200.0 +
                                                                                    z * (1.0 / 20922789888000.0))))))));
  const Pack::Lanes size = (quadrant & 1) != 0 ? even : odd;
  return {(quadrant & 2) != 0 ? -size : size};
}
inline Pack cosine(const Pack& x) { return sine(x, 1); }

// The same operations for one sample.
inline double inverse(double a) { return 1.0 / a; }
inline double inverse_sqrt(double a) { return 1.0 / std::sqrt(a); }
inline double sine(double a) { return std::sin(a); }
inline double cosine(double a) { return std::cos(a); }

}  // namespace halfroll::planner
