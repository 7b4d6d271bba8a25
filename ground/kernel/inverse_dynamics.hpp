// Derivatives of position and yaw to rotor thrusts and body rate, and their exact gradients (docs/planner.md, section
// 3; cross-checked against halfroll.planner.flatness).
//
// Why a template: the same lines run on samples (Pack), on single points (double) and on Taylor models (the proof).
// Chart A throughout: yaw is measured from the least rotation e3 -> n, so only n = -e3 is excluded.
//
// Gradients. Every map below is a map of functions of time, so its variation, differentiated by time, is Leibniz' rule:
//   n = f/|f|          dn = P df,  P = (I - n n')/|f|;   dn' = P' df + P df';   dn'' = P'' df + 2 P' df' + P df''
//   w = A(n) n'        dw = B dn + A dn',  B = d(A n')/dn;   dw' = B' dn + (A' + B) dn' + A dn''
// and a cotangent is carried back through the transposes of these.
#pragma once
#include <array>

#include "pack.hpp"
#include "vehicle.hpp"

namespace halfroll::planner {

template <class S>
using Vec = std::array<S, 3>;

template <class S>
Vec<S> operator+(const Vec<S>& a, const Vec<S>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class S>
Vec<S> operator-(const Vec<S>& a, const Vec<S>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class S>
Vec<S> operator*(const S& a, const Vec<S>& b) {
  return {a * b[0], a * b[1], a * b[2]};
}
template <class S>
S dot(const Vec<S>& a, const Vec<S>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Flat outputs as far as thrust depends on them: W, SI.
template <class S>
struct Flat {
  Vec<S> acceleration, jerk, snap;
  S yaw, yaw_rate, yaw_acceleration;
};

/// A gradient by Flat has the same entries.
template <class S>
using FlatGradient = Flat<S>;

/// Specific force f = acceleration + g e3, its direction n and derivatives.   Eq 19
template <class S>
struct ThrustAxis {
  Vec<S> n, n1, n2;   // n, n', n''
  S size;             // |f|
  S inv, inv1, inv2;  // 1/|f| and its derivatives by time
};

template <class S>
ThrustAxis<S> thrust_axis(const Flat<S>& flat, double gravity) {
  ThrustAxis<S> a;
  const Vec<S> f = {flat.acceleration[0], flat.acceleration[1], flat.acceleration[2] + gravity};
  const S square = dot(f, f);
  a.inv = inverse_sqrt(square);
  a.size = square * a.inv;
  a.n = a.inv * f;
  const S size1 = dot(a.n, flat.jerk);
  a.n1 = a.inv * (flat.jerk - size1 * a.n);
  const S size2 = dot(a.n1, flat.jerk) + dot(a.n, flat.snap);
  a.n2 = a.inv * (flat.snap - (2.0 * size1) * a.n1 - size2 * a.n);
  a.inv1 = -1.0 * (a.inv * a.inv * size1);
  a.inv2 = -1.0 * (a.inv * a.inv * size2 + 2.0 * (a.inv * a.inv1 * size1));
  return a;
}

/// Body rate and acceleration, body axes.   Eqs 13, 15-18
template <class S>
struct BodyRate {
  Vec<S> w, dw;        // with yaw
  Vec<S> tilt, dtilt;  // of the least rotation alone
  S cos_yaw, sin_yaw;
  S inv, k, k1;  // 1/D, n3'/D and its derivative by time, D = 1 + n3
};

template <class S>
BodyRate<S> body_rate(const ThrustAxis<S>& a, const Flat<S>& flat) {
  BodyRate<S> b;
  b.inv = inverse(a.n[2] + 1.0);
  b.k = a.n1[2] * b.inv;
  b.k1 = a.n2[2] * b.inv - b.k * b.k;
  const S spin = a.n[1] * a.n1[0] - a.n[0] * a.n1[1];
  const S spin1 = a.n[1] * a.n2[0] - a.n[0] * a.n2[1];
  b.tilt = {a.n[1] * b.k - a.n1[1], a.n1[0] - a.n[0] * b.k, spin * b.inv};
  b.dtilt = {a.n1[1] * b.k + a.n[1] * b.k1 - a.n2[1], a.n2[0] - a.n1[0] * b.k - a.n[0] * b.k1,
             (spin1 - spin * b.k) * b.inv};
  const S c = b.cos_yaw = cosine(flat.yaw), s = b.sin_yaw = sine(flat.yaw);
  b.w = {c * b.tilt[0] + s * b.tilt[1], c * b.tilt[1] - s * b.tilt[0], b.tilt[2] + flat.yaw_rate};
  b.dw = {c * b.dtilt[0] + s * b.dtilt[1] + flat.yaw_rate * b.w[1],
          c * b.dtilt[1] - s * b.dtilt[0] - flat.yaw_rate * b.w[0], b.dtilt[2] + flat.yaw_acceleration};
  return b;
}

/// Rotor thrusts from specific thrust and body rate.   Eqs 3, 4 inverted
template <class S>
std::array<S, 4> rotor_thrusts(const S& size, const BodyRate<S>& b, const Vehicle& v) {
  const auto& J = v.inertia;
  const S T = (0.25 * v.mass) * size;
  const S x = (0.5 / v.arm) * (J[0] * b.dw[0] + (J[2] - J[1]) * (b.w[1] * b.w[2]));
  const S y = (0.5 / v.arm) * (J[1] * b.dw[1] + (J[0] - J[2]) * (b.w[2] * b.w[0]));
  const S z = (0.25 / v.yaw_coefficient) * (J[2] * b.dw[2] + (J[1] - J[0]) * (b.w[0] * b.w[1]));
  return {T + x - z, T + y + z, T - x - z, T - y + z};
}

/// All of it: what thrusts and attitude are at some flat outputs.
template <class S>
struct Dynamics {
  Flat<S> flat;
  ThrustAxis<S> axis;
  BodyRate<S> body;
  std::array<S, 4> thrust;  // [N] of each rotor
};

template <class S>
Dynamics<S> dynamics(const Flat<S>& flat, const Vehicle& vehicle) {
  Dynamics<S> at;
  at.flat = flat;
  at.axis = thrust_axis(flat, vehicle.gravity);
  at.body = body_rate(at.axis, flat);
  at.thrust = rotor_thrusts(at.axis.size, at.body, vehicle);
  return at;
}

/// Gradient by Flat of (u . dw + v . w), u and v being constants: the reverse sweep through body_rate and thrust_axis.
template <class S>
FlatGradient<S> pull_back(const Vec<S>& u, const Vec<S>& v, const Dynamics<S>& at) {
  const ThrustAxis<S>& a = at.axis;
  const BodyRate<S>& b = at.body;
  const Flat<S>& flat = at.flat;
  FlatGradient<S> g;
  // yaw: w = R'tilt + yaw_rate e3,  dw = R'dtilt + yaw_rate (w2, -w1, 0) + yaw_acceleration e3
  const S v0 = v[0] - flat.yaw_rate * u[1], v1 = v[1] + flat.yaw_rate * u[0];
  g.yaw_rate = u[0] * b.w[1] - u[1] * b.w[0] + v[2];
  g.yaw_acceleration = u[2];
  g.yaw =
      u[0] * (b.dw[1] + flat.yaw_rate * b.w[0]) - u[1] * (b.dw[0] - flat.yaw_rate * b.w[1]) + v0 * b.w[1] - v1 * b.w[0];
  const S c = b.cos_yaw, s = b.sin_yaw;
  const Vec<S> p = {c * u[0] - s * u[1], s * u[0] + c * u[1], u[2]};  // on dtilt
  const Vec<S> q = {c * v0 - s * v1, s * v0 + c * v1, v[2]};          // on tilt
  // tilt: rows of A are (0, -1, n2/D), (1, 0, -n1/D), (n2/D, -n1/D, 0)
  const S h1 = a.n[0] * b.inv, h2 = a.n[1] * b.inv;
  const S h1d = a.n1[0] * b.inv - h1 * b.k, h2d = a.n1[1] * b.inv - h2 * b.k;  // their derivatives by time
  const S m1 = a.n1[0] * b.inv, m2 = a.n1[1] * b.inv;
  const S m1d = a.n2[0] * b.inv - m1 * b.k, m2d = a.n2[1] * b.inv - m2 * b.k;
  const S w3 = b.tilt[2] * b.inv, w3d = b.dtilt[2] * b.inv - w3 * b.k;
  // B' and B transposed: rows of B are (0, k, -h2 k), (-k, 0, h1 k), (-m2, m1, -w3)
  const auto Bt = [&](const S& k, const S& h1k, const S& h2k, const S& m1_, const S& m2_, const S& w3_,
                      const Vec<S>& r) -> Vec<S> {
    return {-1.0 * (k * r[1]) - m2_ * r[2], k * r[0] + m1_ * r[2], h1k * r[1] - h2k * r[0] - w3_ * r[2]};
  };
  const auto At = [&](const Vec<S>& r) -> Vec<S> {
    return {r[1] + h2 * r[2], -1.0 * r[0] - h1 * r[2], h2 * r[0] - h1 * r[1]};
  };
  const Vec<S> Atd_p = {h2d * p[2], -1.0 * (h1d * p[2]), h2d * p[0] - h1d * p[1]};
  const Vec<S> on_n2 = At(p);
  const Vec<S> on_n1 = Atd_p + Bt(b.k, h1 * b.k, h2 * b.k, m1, m2, w3, p) + At(q);
  const Vec<S> on_n = Bt(b.k1, h1d * b.k + h1 * b.k1, h2d * b.k + h2 * b.k1, m1d, m2d, w3d, p) +
                      Bt(b.k, h1 * b.k, h2 * b.k, m1, m2, w3, q);
  // direction: P = (I - n n')/|f|
  const auto P = [&](const Vec<S>& r) { return a.inv * (r - dot(a.n, r) * a.n); };
  const auto Pd = [&](const Vec<S>& r) {
    const S nr = dot(a.n, r);
    return a.inv1 * (r - nr * a.n) - a.inv * (nr * a.n1 + dot(a.n1, r) * a.n);
  };
  const auto Pdd = [&](const Vec<S>& r) {
    const S nr = dot(a.n, r), n1r = dot(a.n1, r);
    return a.inv2 * (r - nr * a.n) - (2.0 * a.inv1) * (nr * a.n1 + n1r * a.n) -
           a.inv * (nr * a.n2 + (2.0 * n1r) * a.n1 + dot(a.n2, r) * a.n);
  };
  g.snap = P(on_n2);
  const Vec<S> once = Pd(on_n2);
  g.jerk = once + once + P(on_n1);
  g.acceleration = Pdd(on_n2) + Pd(on_n1) + P(on_n);
  return g;
}

}  // namespace halfroll::planner
