#include "dynamic_samples.hpp"
#include "row_values.hpp"

namespace halfroll::planner {
namespace {

constexpr int kDirections = 8;  // snap and yaw acceleration enter linearly: the other entries are directions enough
constexpr std::array<int, kDirections> kDirection = {0, 1, 2, 3, 4, 5, 9, 10};

using Directed = Dual<kDirections>;
using Hessian = std::array<std::array<Pack, kDynamicEntries>, kDynamicEntries>;

/// What four samples weigh the rotor thrusts, and the square of the body rate.
struct Weights {
  Pack rotor[4] = {}, rate_squared{};
};

Flat<Directed> in_directions(const Flat<Pack>& at) {
  Flat<Directed> q;
  for (int a = 0; a < 3; ++a) {
    q.acceleration[a] = variable<kDirections>(at.acceleration[a], a);
    q.jerk[a] = variable<kDirections>(at.jerk[a], 3 + a);
    q.snap[a] = constant<kDirections>(at.snap[a]);
  }
  q.yaw = variable<kDirections>(at.yaw, 6);
  q.yaw_rate = variable<kDirections>(at.yaw_rate, 7);
  q.yaw_acceleration = constant<kDirections>(at.yaw_acceleration);
  return q;
}

/// Of the weighted sum: the reverse sweep for its gradient, on numbers that carry their derivatives.
Hessian hessian(const Dynamics<Directed>& at, const Vehicle& v, const Weights& weights) {
  const auto constant_of = [](const Pack& s) { return constant<kDirections>(s); };
  const Pack(&rotor)[4] = weights.rotor;
  const Vec<Directed>& w = at.body.w;
  const auto& J = v.inertia;
  const Directed on_thrust = constant_of(0.25 * v.mass * (rotor[0] + rotor[1] + rotor[2] + rotor[3]));
  const Directed on_x = constant_of(0.5 / v.arm * (rotor[0] - rotor[2]));
  const Directed on_y = constant_of(0.5 / v.arm * (rotor[1] - rotor[3]));
  const Directed on_z = constant_of(0.25 / v.yaw_coefficient * (rotor[1] + rotor[3] - rotor[0] - rotor[2]));
  const Directed on_rate = constant_of(2.0 * weights.rate_squared);
  const Directed cx = (J[2] - J[1]) * on_x, cy = (J[0] - J[2]) * on_y, cz = (J[1] - J[0]) * on_z;
  const Vec<Directed> by_dw = {J[0] * on_x, J[1] * on_y, J[2] * on_z};
  const Vec<Directed> by_w = {cy * w[2] + cz * w[1] + on_rate * w[0], cx * w[2] + cz * w[0] + on_rate * w[1],
                              cx * w[1] + cy * w[0] + on_rate * w[2]};
  FlatGradient<Directed> g = pull_back(by_dw, by_w, at);
  g.acceleration = g.acceleration + on_thrust * at.axis.n;
  const std::array<Directed, kDynamicEntries> gradient = by_entry(g);
  Hessian H{};
  for (int d = 0; d < kDirections; ++d) {
    const int column = kDirection[d];
    for (int e = 0; e < kDynamicEntries; ++e) H[e][column] = H[column][e] = gradient[e].d[d];
  }
  return H;
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
    const Dynamics<Directed> at = dynamics(in_directions(load_flat<Pack>(flat, i)), v);
    Weights still, leading;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const RotorTerms& terms = rows[r].terms;
      const Pack weight = load(&weights(i, static_cast<int>(r)));
      if (rows[r].of_rotor()) {
        still.rotor[terms.rotor] += share_of(terms, at.thrust[terms.rotor].v, least) * weight;
        leading.rotor[terms.rotor] += terms.lead * weight;
      }
      if (rows[r].quantity == Quantity::kRateSquared) still.rate_squared = weight;
    }
    const Hessian of_rates = constraints.limits_rates() ? hessian(at, v, leading) : Hessian{};
    store_hessian(hessian(at, v, still), of_rates, constraints.dynamic_entries(), i, hessians);
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
