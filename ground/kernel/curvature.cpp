#include "dynamic_samples.hpp"
#include "row_values.hpp"

namespace halfroll::planner {
namespace {

using Directed = Dual<1>;  // one direction at a time: with all of them the code outgrows the processor's caches
using Hessian = std::array<std::array<Pack, kDynamicEntries>, kDynamicEntries>;

/// What four samples weigh the rotor thrusts, and the square of the body rate.
struct Weights {
  Pack rotor[4] = {}, rate_squared{};
};

/// Along one axis of the acceleration, or of the jerk. What does not depend on it has a derivative that is zero when
/// this is compiled, and costs nothing.
enum class Along { kAcceleration, kJerk };
template <Along along>
Flat<Directed> in_direction(const Flat<Pack>& at, int axis) {
  Flat<Directed> q;
  for (int a = 0; a < 3; ++a) {
    q.acceleration[a] = constant<1>(at.acceleration[a]);
    q.jerk[a] = constant<1>(at.jerk[a]);
    q.snap[a] = constant<1>(at.snap[a]);
  }
  q.yaw = constant<1>(at.yaw);
  q.yaw_rate = constant<1>(at.yaw_rate);
  q.yaw_acceleration = constant<1>(at.yaw_acceleration);
  (along == Along::kJerk ? q.jerk : q.acceleration)[axis].d[0] = splat(1.0);
  return q;
}

/// Gradient of the weighted sum G by body acceleration and rate, and the Hessian by the rate:
///   G = on_dw . dw + half w . by_w_twice w + (thrusts)
struct OnBody {
  Pack thrust;
  Vec<Pack> on_dw;
  Pack xy, yz, zx, square;  // of by_w_twice
};

OnBody on_body(const Vehicle& v, const Weights& weights) {
  const Pack(&rotor)[4] = weights.rotor;
  const auto& J = v.inertia;
  const Pack x = 0.5 / v.arm * (rotor[0] - rotor[2]), y = 0.5 / v.arm * (rotor[1] - rotor[3]);
  const Pack z = 0.25 / v.yaw_coefficient * (rotor[1] + rotor[3] - rotor[0] - rotor[2]);
  return {0.25 * v.mass * (rotor[0] + rotor[1] + rotor[2] + rotor[3]),
          {J[0] * x, J[1] * y, J[2] * z},
          (J[1] - J[0]) * z,
          (J[2] - J[1]) * x,
          (J[0] - J[2]) * y,
          2.0 * weights.rate_squared};
}

/// G's gradient by the rate. as: turns a weight into a number like those of the rate.
template <class S, class As>
Vec<S> by_rate(const OnBody& on, const Vec<S>& w, const As& as) {
  return {as(on.xy) * w[1] + as(on.zx) * w[2] + as(on.square) * w[0],
          as(on.xy) * w[0] + as(on.yz) * w[2] + as(on.square) * w[1],
          as(on.zx) * w[0] + as(on.yz) * w[1] + as(on.square) * w[2]};
}

/// Columns of acceleration or jerk: the reverse sweep for G's gradient, on numbers that carry their derivative.
template <Along along>
void store_columns(const Flat<Pack>& here, const Vehicle& v, const OnBody* const (&on)[2], Hessian* const (&H)[2]) {
  constexpr int kFirst = along == Along::kJerk ? 3 : 0;  // what is above it is known by symmetry
  const auto as = [](const Pack& s) { return constant<1>(s); };
  for (int axis = 0; axis < 3; ++axis) {
    const Dynamics<Directed> at = dynamics(in_direction<along>(here, axis), v);
    for (int sum = 0; sum < 2 && on[sum]; ++sum) {
      const Vec<Pack>& u = on[sum]->on_dw;
      FlatGradient<Directed> g =
          pull_back<Directed>({as(u[0]), as(u[1]), as(u[2])}, by_rate(*on[sum], at.body.w, as), at);
      g.acceleration = g.acceleration + as(on[sum]->thrust) * at.axis.n;
      const std::array<Directed, kDynamicEntries> gradient = by_entry(g);
      const int column = kFirst + axis;
      for (int e = kFirst; e < kDynamicEntries; ++e) (*H[sum])[e][column] = (*H[sum])[column][e] = gradient[e].d[0];
    }
  }
}

/// What is left, by yaw and its rate: yaw turns w and dw like vectors of the horizontal plane.
void store_yaw(const Dynamics<Pack>& at, const OnBody& on, Hessian& H) {
  constexpr int kSnap = 6, kYaw = 9, kYawRate = 10;
  const auto as = [](const Pack& s) { return s; };
  const Vec<Pack>&w = at.body.w, &dw = at.body.dw, &u = on.on_dw;
  const Vec<Pack> turned = {w[1], -1.0 * w[0], Pack{}};
  const Vec<Pack> pull = by_rate(on, w, as), pull_turned = by_rate(on, turned, as);
  H[kYaw][kYaw] = dot(turned, pull_turned) - u[0] * dw[0] - u[1] * dw[1] - pull[0] * w[0] - pull[1] * w[1];
  H[kYaw][kYawRate] = H[kYawRate][kYaw] = pull_turned[2] - u[0] * w[0] - u[1] * w[1];
  H[kYawRate][kYawRate] = on.square;
  const Vec<Pack> by_snap = pull_back<Pack>({-1.0 * u[1], u[0], Pack{}}, {Pack{}, Pack{}, Pack{}}, at).snap;
  for (int a = 0; a < 3; ++a) H[kSnap + a][kYaw] = H[kYaw][kSnap + a] = by_snap[a];
}

/// Of `still` and of the rate of `leading`: by Leibniz, with derivatives one order higher. What the rate of the Hessian
/// itself adds is left out: it takes as long as all the rest, and saves no steps.
void store_hessian(const Hessian& still, const Hessian& leading, int entries, int i, Eigen::MatrixXd& hessians) {
  const auto lead = [&](int e, int f) {
    return e < 0 || f < 0 || e >= kDynamicEntries || f >= kDynamicEntries ? Pack{} : leading[e][f];
  };
  for (int e = 0; e < entries; ++e) {
    for (int f = 0; f <= e; ++f) {
      Pack sum = lead(e, kBelow[f]) + lead(kBelow[e], f);
      if (e < kDynamicEntries) sum += still[e][f];
      store(&hessians(i, dynamic_pair(e, f)), sum);
    }
  }
}

HALFROLL_WIDE void fill(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
                        Eigen::MatrixXd& hessians) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const double least = least_root(constraints);
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Flat<Pack> here = load_flat<Pack>(flat, i);
    const Dynamics<Pack> at = dynamics(here, v);
    Weights still, leading;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const RotorTerms& terms = rows[r].terms;
      const Pack weight = load(&weights(i, static_cast<int>(r)));
      if (rows[r].of_rotor()) {
        still.rotor[terms.rotor] += share_of(terms, at.thrust[terms.rotor], least) * weight;
        leading.rotor[terms.rotor] += terms.lead * weight;
      }
      if (rows[r].quantity == Quantity::kRateSquared) still.rate_squared = weight;
    }
    const OnBody on_still = on_body(v, still), on_leading = on_body(v, leading);
    Hessian of_still{}, of_rates{};
    const OnBody* const on[2] = {&on_still, constraints.limits_rates() ? &on_leading : nullptr};
    Hessian* const H[2] = {&of_still, &of_rates};
    store_columns<Along::kAcceleration>(here, v, on, H);
    store_columns<Along::kJerk>(here, v, on, H);
    for (int sum = 0; sum < 2 && on[sum]; ++sum) store_yaw(at, *on[sum], *H[sum]);
    store_hessian(of_still, of_rates, constraints.dynamic_entries(), i, hessians);
  }
}

}  // namespace

void curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
               Eigen::MatrixXd& hessians) {
  const int last = constraints.dynamic_entries() - 1;
  hessians.setZero(flat[0].rows(), dynamic_pair(last, last) + 1);
  if (!constraints.limits().vertical) fill(constraints, flat, weights, hessians);  // else linear
}

}  // namespace halfroll::planner
