// Numbers that carry their derivatives by N directions. Why: the Hessian of a weighted sum of limited quantities is the
// forward derivative of its reverse gradient, so second derivatives need no formulas of their own; and with time as the
// one direction, the inverse dynamics give the rates of the rotor thrusts, on samples and on Taylor models alike.
#pragma once
#include "pack.hpp"

namespace halfroll::planner {

template <int N, class S = Pack>
struct Dual {
  S v;
  S d[N];
};

template <int N, class S>
Dual<N, S> constant(const S& v) {
  Dual<N, S> out;
  out.v = v;
  for (S& d : out.d) d = S{};
  return out;
}

template <int N, class S>
inline Dual<N, S> operator+(const Dual<N, S>& a, const Dual<N, S>& b) {
  Dual<N, S> out;
  out.v = a.v + b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a.d[i] + b.d[i];
  return out;
}

template <int N, class S>
inline Dual<N, S> operator-(const Dual<N, S>& a, const Dual<N, S>& b) {
  Dual<N, S> out;
  out.v = a.v - b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a.d[i] - b.d[i];
  return out;
}

template <int N, class S>
inline Dual<N, S> operator*(const Dual<N, S>& a, const Dual<N, S>& b) {
  Dual<N, S> out;
  out.v = a.v * b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a.v * b.d[i] + b.v * a.d[i];
  return out;
}

template <int N, class S>
inline Dual<N, S> operator*(double a, const Dual<N, S>& b) {
  Dual<N, S> out;
  out.v = a * b.v;
  for (int i = 0; i < N; ++i) out.d[i] = a * b.d[i];
  return out;
}

template <int N, class S>
inline Dual<N, S> operator+(const Dual<N, S>& a, double b) {
  Dual<N, S> out = a;
  out.v = out.v + b;
  return out;
}

/// f(a), given f and f' at its value.
template <int N, class S>
inline Dual<N, S> chained(const Dual<N, S>& a, const S& f, const S& slope) {
  Dual<N, S> out;
  out.v = f;
  for (int i = 0; i < N; ++i) out.d[i] = slope * a.d[i];
  return out;
}

template <int N, class S>
inline Dual<N, S> inverse(const Dual<N, S>& a) {
  const S f = inverse(a.v);
  return chained(a, f, -1.0 * (f * f));
}
template <int N, class S>
inline Dual<N, S> inverse_sqrt(const Dual<N, S>& a) {
  const S f = inverse_sqrt(a.v);
  return chained(a, f, -0.5 * (f * f * f));
}
template <int N, class S>
inline Dual<N, S> sine(const Dual<N, S>& a) {
  return chained(a, sine(a.v), cosine(a.v));
}
template <int N, class S>
inline Dual<N, S> cosine(const Dual<N, S>& a) {
  return chained(a, cosine(a.v), -1.0 * sine(a.v));
}

}  // namespace halfroll::planner
