// Numbers that carry their derivatives by N directions. Why: the Hessian of a weighted sum of limited quantities is the
// forward derivative of its reverse gradient, so second derivatives need no formulas of their own.
#pragma once
#include "pack.hpp"

namespace halfroll::planner {

template <int N>
struct Dual {
  Pack v;
  Pack d[N];
};

template <int N>
Dual<N> constant(const Pack& v) {
  Dual<N> out;
  out.v = v;
  for (Pack& d : out.d) d = splat(0.0);
  return out;
}

/// The variable of direction i.
template <int N>
Dual<N> variable(const Pack& v, int i) {
  Dual<N> out = constant<N>(v);
  out.d[i] = splat(1.0);
  return out;
}

template <int N>
inline Dual<N> operator+(const Dual<N>& a, const Dual<N>& b) {
  Dual<N> out;
  out.v = a.v + b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a.d[i] + b.d[i];
  return out;
}

template <int N>
inline Dual<N> operator-(const Dual<N>& a, const Dual<N>& b) {
  Dual<N> out;
  out.v = a.v - b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a.d[i] - b.d[i];
  return out;
}

template <int N>
inline Dual<N> operator*(const Dual<N>& a, const Dual<N>& b) {
  Dual<N> out;
  out.v = a.v * b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a.v * b.d[i] + b.v * a.d[i];
  return out;
}

template <int N>
inline Dual<N> operator*(double a, const Dual<N>& b) {
  Dual<N> out;
  out.v = a * b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a * b.d[i];
  return out;
}

template <int N>
inline Dual<N> operator+(const Dual<N>& a, double b) {
  Dual<N> out = a;
  out.v = out.v + b;
  return out;
}

/// f(a), given f and f' at its value.
template <int N>
inline Dual<N> chained(const Dual<N>& a, const Pack& f, const Pack& slope) {
  Dual<N> out;
  out.v = f;
  for (int i = 0; i < N; ++i) out.d[i] = slope * a.d[i];
  return out;
}

template <int N>
inline Dual<N> inverse(const Dual<N>& a) {
  const Pack f = inverse(a.v);
  return chained(a, f, -1.0 * (f * f));
}
template <int N>
inline Dual<N> inverse_sqrt(const Dual<N>& a) {
  const Pack f = inverse_sqrt(a.v);
  return chained(a, f, -0.5 * (f * f * f));
}
template <int N>
inline Dual<N> sine(const Dual<N>& a) {
  return chained(a, sine(a.v), cosine(a.v));
}
template <int N>
inline Dual<N> cosine(const Dual<N>& a) {
  return chained(a, cosine(a.v), -1.0 * sine(a.v));
}

}  // namespace halfroll::planner
