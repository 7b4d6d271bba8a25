#include "dynamic_samples.hpp"
#include "row_values.hpp"

namespace halfroll::planner {
namespace {

constexpr int kDirections = 8;  // snap and yaw acceleration enter linearly: the other entries are directions enough
constexpr std::array<int, kDirections> kDirection = {0, 1, 2, 3, 4, 5, 9, 10};

/// Weights of the rotor thrusts, and with S = Moving of their rates too: the derivative by time of (weight thrust) is
/// weight' thrust + weight thrust'.
void weigh(const RotorTerms& terms, const Pack& weight, const Pack& share, Pack& out) {
  if (terms.lead == 0.0) out += share * weight;
}
void weigh(const RotorTerms& terms, const Pack& weight, const Pack& share, Moving& out) {
  out.d[0] += share * weight;
  out.v += terms.lead * weight;
}
void only_value(const Pack& weight, Pack& out) { out = weight; }
void only_value(const Pack& weight, Moving& out) { out.d[0] = weight; }

/// Of the sum: by derivatives of the entries, and for a rate also of those one below (Leibniz).
void store_hessian(const std::array<std::array<Pack, kDynamicEntries>, kDynamicEntries>& H, int i,
                   Eigen::MatrixXd& hessians) {
  for (int e = 0; e < kDynamicEntries; ++e) {
    for (int f = 0; f <= e; ++f) store(&hessians(i, dynamic_pair(e, f)), H[e][f]);
  }
}
void store_hessian(const std::array<std::array<Moving, kDynamicEntries>, kDynamicEntries>& H, int i,
                   Eigen::MatrixXd& hessians) {
  const auto value = [&](int e, int f) {
    return e < 0 || f < 0 || e >= kDynamicEntries || f >= kDynamicEntries ? Pack{} : H[e][f].v;
  };
  for (int e = 0; e < kRateEntries; ++e) {
    for (int f = 0; f <= e; ++f) {
      Pack sum = value(e, kBelow[f]) + value(kBelow[e], f);
      if (e < kDynamicEntries) sum += H[e][f].d[0];
      store(&hessians(i, dynamic_pair(e, f)), sum);
    }
  }
}

template <class S>
void add_curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
                   Eigen::MatrixXd& hessians) {
  using D = Dual<kDirections, S>;
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const double x = 0.5 / v.arm, y = 0.5 / v.arm, z = 0.25 / v.yaw_coefficient;
  const double least = least_root(constraints);
  const auto constant_of = [](const S& s) { return constant<kDirections>(s); };
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Flat<S> at = load_flat<S>(flat, i);
    Flat<D> q;
    for (int a = 0; a < 3; ++a) {
      q.acceleration[a] = variable<kDirections>(at.acceleration[a], a);
      q.jerk[a] = variable<kDirections>(at.jerk[a], 3 + a);
      q.snap[a] = constant_of(at.snap[a]);
    }
    q.yaw = variable<kDirections>(at.yaw, 6);
    q.yaw_rate = variable<kDirections>(at.yaw_rate, 7);
    q.yaw_acceleration = constant_of(at.yaw_acceleration);

    const Dynamics<D> all = dynamics(q, v);
    const BodyRate<D>& b = all.body;
    S rotor[4] = {}, rate{};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const RotorTerms& terms = rows[r].terms;
      const Pack weight = load(&weights(i, static_cast<int>(r)));
      if (rows[r].of_rotor()) {
        weigh(terms, weight, share_of(terms, value_of(all.thrust[terms.rotor].v), least), rotor[terms.rotor]);
      }
      if (rows[r].quantity == Quantity::kRateSquared) only_value(weight, rate);
    }
    const D on_thrust = constant_of(0.25 * v.mass * (rotor[0] + rotor[1] + rotor[2] + rotor[3]));
    const D on_x = constant_of(x * (rotor[0] - rotor[2]));
    const D on_y = constant_of(y * (rotor[1] - rotor[3]));
    const D on_z = constant_of(z * (rotor[1] + rotor[3] - rotor[0] - rotor[2]));
    const D on_rate = constant_of(2.0 * rate);
    const auto& J = v.inertia;
    const D cx = (J[2] - J[1]) * on_x, cy = (J[0] - J[2]) * on_y, cz = (J[1] - J[0]) * on_z;
    const Vec<D> by_dw = {J[0] * on_x, J[1] * on_y, J[2] * on_z};
    const Vec<D> by_w = {cy * b.w[2] + cz * b.w[1] + on_rate * b.w[0], cx * b.w[2] + cz * b.w[0] + on_rate * b.w[1],
                         cx * b.w[1] + cy * b.w[0] + on_rate * b.w[2]};
    FlatGradient<D> g = pull_back(by_dw, by_w, all);
    g.acceleration = g.acceleration + on_thrust * all.axis.n;
    const std::array<D, kDynamicEntries> gradient = by_entry(g);
    std::array<std::array<S, kDynamicEntries>, kDynamicEntries> H{};
    for (int d = 0; d < kDirections; ++d) {
      const int column = kDirection[d];
      for (int e = 0; e < kDynamicEntries; ++e) H[e][column] = H[column][e] = gradient[e].d[d];
    }
    store_hessian(H, i, hessians);
  }
}

}  // namespace

HALFROLL_WIDE void add_curvature_still(const Constraints& constraints, const FlatSamples& flat,
                                       const Eigen::MatrixXd& weights, Eigen::MatrixXd& hessians) {
  add_curvature<Pack>(constraints, flat, weights, hessians);
}
/// Not one flat function for each processor: that would take minutes to compile.
void add_curvature_moving(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
                          Eigen::MatrixXd& hessians) {
  add_curvature<Moving>(constraints, flat, weights, hessians);
}

void curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
               Eigen::MatrixXd& hessians) {
  hessians.setZero(flat[0].rows(),
                   dynamic_pair(constraints.dynamic_entries() - 1, constraints.dynamic_entries() - 1) + 1);
  if (constraints.limits().vertical) return;  // linear
  if (constraints.limits_rates()) {
    add_curvature_moving(constraints, flat, weights, hessians);
  } else {
    add_curvature_still(constraints, flat, weights, hessians);
  }
}

}  // namespace halfroll::planner
