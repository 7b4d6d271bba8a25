// Inverse dynamics on four samples at once, still or with their derivatives by time. Why: limits of rotor rates need
// the rate of everything that limits of thrust need, by the same templates.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "constraints.hpp"
#include "dual.hpp"
#include "inverse_dynamics.hpp"
#include "samples.hpp"

namespace halfroll::planner {

using Moving = Dual<1>;  // four samples and their derivatives by time

inline const Pack& value_of(const Pack& s) { return s; }
inline const Pack& value_of(const Moving& s) { return s.v; }
inline Pack rate_of(const Pack&) { return Pack{}; }
inline const Pack& rate_of(const Moving& s) { return s.d[0]; }

inline void take(const FlatSamples& flat, int derivative, int axis, int i, Pack& out) {
  out = load(&flat[derivative](i, axis));
}
inline void take(const FlatSamples& flat, int derivative, int axis, int i, Moving& out) {
  out.v = load(&flat[derivative](i, axis));
  out.d[0] = load(&flat[derivative + 1](i, axis));
}

template <class S>
Flat<S> load_flat(const FlatSamples& flat, int i) {
  Flat<S> q;
  for (int a = 0; a < 3; ++a) {
    take(flat, 2, a, i, q.acceleration[a]);
    take(flat, 3, a, i, q.jerk[a]);
    take(flat, 4, a, i, q.snap[a]);
  }
  take(flat, 0, 3, i, q.yaw);
  take(flat, 1, 3, i, q.yaw_rate);
  take(flat, 2, 3, i, q.yaw_acceleration);
  return q;
}

/// As the columns of a row by the dynamic entries.
template <class S>
std::array<S, kDynamicEntries> by_entry(const FlatGradient<S>& g) {
  return {g.acceleration[0], g.acceleration[1], g.acceleration[2], g.jerk[0], g.jerk[1],  g.jerk[2],
          g.snap[0],         g.snap[1],         g.snap[2],         g.yaw,     g.yaw_rate, g.yaw_acceleration};
}

/// Of each dynamic entry: the one that is its integral over time; -1: none of them.
constexpr std::array<int, kRateEntries> kBelow = {-1, -1, -1, 0, 1, 2, 3, 4, 5, -1, 9, 10, 6, 7, 8, 11};

/// The root of less thrust than this is taken along its tangent [N].
inline double least_root(const Constraints& constraints) { return 1e-3 * constraints.limits().rotor_max; }

/// sqrt(root f) and its slope; of little or negative thrust along the tangent, for the solver may look there.
struct Root {
  Pack value, slope;
};
inline Root root_of(double root, const Pack& f, double least) {
  Root out;
  for (int i = 0; i < Pack::kWidth; ++i) {
    const double at = std::max(f.v[i], least), size = std::sqrt(root * at);
    out.slope.v[i] = 0.5 * size / at;
    out.value.v[i] = size + out.slope.v[i] * (f.v[i] - at);
  }
  return out;
}

/// Slope of a rotor's row by its thrust.
inline Pack share_of(const RotorTerms& terms, const Pack& f, double least) {
  return terms.root == 0.0 ? splat(terms.share) : splat(terms.share) - root_of(terms.root, f, least).slope;
}

}  // namespace halfroll::planner
