#include "dynamic_rows.hpp"

#include "dynamic_samples.hpp"

namespace halfroll::planner {
namespace {

/// Gradients of the four rotor thrusts.
template <class S>
std::array<std::array<S, kDynamicEntries>, 4> thrust_gradients(const Dynamics<S>& at, const Vehicle& v) {
  const auto& J = v.inertia;
  const Vec<S>& w = at.body.w;
  const S zero = 0.0 * at.axis.size;
  const auto constant_one = [&](double k) { return zero + k; };
  // torque_x = Jx dw1 + (Jz - Jy) w2 w3, and so on: u is its gradient by dw, the second argument by w
  const double kx = 0.5 / v.arm * (J[2] - J[1]), ky = 0.5 / v.arm * (J[0] - J[2]);
  const auto x =
      by_entry(pull_back<S>({constant_one(0.5 / v.arm * J[0]), zero, zero}, {zero, kx * w[2], kx * w[1]}, at));
  const auto y =
      by_entry(pull_back<S>({zero, constant_one(0.5 / v.arm * J[1]), zero}, {ky * w[2], zero, ky * w[0]}, at));
  const double yaw = 0.25 / v.yaw_coefficient, kz = yaw * (J[1] - J[0]);
  const auto z = by_entry(pull_back<S>({zero, zero, constant_one(yaw * J[2])}, {kz * w[1], kz * w[0], zero}, at));
  std::array<std::array<S, kDynamicEntries>, 4> rotors;
  for (int e = 0; e < kDynamicEntries; ++e) {
    const S thrust = e < 3 ? (0.25 * v.mass) * at.axis.n[e] : zero;  // gradient of |f| is n
    rotors[0][e] = thrust + x[e] - z[e];
    rotors[1][e] = thrust + y[e] + z[e];
    rotors[2][e] = thrust - x[e] - z[e];
    rotors[3][e] = thrust - y[e] + z[e];
  }
  return rotors;
}

Pack rotor_row(const RotorTerms& terms, const Pack& f, const Pack& rate, double least) {
  const Pack sum = terms.share * f + terms.lead * rate;
  return terms.root == 0.0 ? sum : sum - root_of(terms.root, f, least).value;
}

/// Gradient of a rotor's row, by the entries of its Row: of f' it is, for each derivative, the rate of f's gradient by
/// it, and f's gradient by the one below (Leibniz).
template <class S>
void store_rotor_row(const Row& row, const S& f, const std::array<S, kDynamicEntries>& gradient, double least,
                     Eigen::MatrixXd& slope, int i) {
  const RotorTerms& terms = row.terms;
  const Pack share = share_of(terms, value_of(f), least);
  for (int e = 0; e < static_cast<int>(row.entries.size()); ++e) {
    Pack sum{};
    if (e < kDynamicEntries) sum = share * value_of(gradient[e]) + terms.lead * rate_of(gradient[e]);
    if (terms.lead != 0.0 && kBelow[e] >= 0) sum = sum + terms.lead * value_of(gradient[kBelow[e]]);
    store(&slope(i, e), sum);
  }
}

template <class S>
void evaluate_as(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const double least = least_root(constraints);
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Dynamics<S> at = dynamics(load_flat<S>(flat, i), v);
    for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
      double* out = &values(i, r);
      const int rotor = rows[r].terms.rotor;
      if (rotor >= 0)
        store(out, rotor_row(rows[r].terms, value_of(at.thrust[rotor]), rate_of(at.thrust[rotor]), least));
      if (rows[r].quantity == Quantity::kForce) store(out, v.mass * value_of(at.axis.size));
      if (rows[r].quantity == Quantity::kUprightness) store(out, value_of(at.axis.n[2]));
      if (rows[r].quantity == Quantity::kRateSquared) store(out, value_of(dot(at.body.w, at.body.w)));
    }
  }
}

template <class S>
void differentiate_as(const Constraints& constraints, const FlatSamples& flat, std::vector<Eigen::MatrixXd>& slopes) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const double least = least_root(constraints);
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Dynamics<S> at = dynamics(load_flat<S>(flat, i), v);
    const auto gradients = thrust_gradients(at, v);
    const Vec<Pack> n = {value_of(at.axis.n[0]), value_of(at.axis.n[1]), value_of(at.axis.n[2])};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const int rotor = rows[r].terms.rotor;
      if (rotor >= 0) store_rotor_row(rows[r], at.thrust[rotor], gradients[rotor], least, slopes[r], i);
      for (int a = 0; a < 3; ++a) {
        if (rows[r].quantity == Quantity::kForce) store(&slopes[r](i, a), v.mass * n[a]);
        if (rows[r].quantity == Quantity::kUprightness) {  // (e3 - n3 n)/|f|
          store(&slopes[r](i, a), value_of(at.axis.inv) * (splat(a == 2 ? 1.0 : 0.0) - n[2] * n[a]));
        }
      }
      if (rows[r].quantity == Quantity::kRateSquared) {
        const S zero = 0.0 * at.axis.size;
        const Vec<S>& w = at.body.w;
        const auto g = by_entry(pull_back<S>({zero, zero, zero}, {2.0 * w[0], 2.0 * w[1], 2.0 * w[2]}, at));
        for (int e = 0; e < kDynamicEntries; ++e) store(&slopes[r](i, e), value_of(g[e]));
      }
    }
  }
}

// Compiled for each processor, with all that the templates above call.
HALFROLL_WIDE void evaluate_still(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  evaluate_as<Pack>(constraints, flat, values);
}
HALFROLL_WIDE void evaluate_moving(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  evaluate_as<Moving>(constraints, flat, values);
}
HALFROLL_WIDE void differentiate_still(const Constraints& constraints, const FlatSamples& flat,
                                       std::vector<Eigen::MatrixXd>& slopes) {
  differentiate_as<Pack>(constraints, flat, slopes);
}
HALFROLL_WIDE void differentiate_moving(const Constraints& constraints, const FlatSamples& flat,
                                        std::vector<Eigen::MatrixXd>& slopes) {
  differentiate_as<Moving>(constraints, flat, slopes);
}

/// Straight up and down: one rotor's thrust and its rate.
Moving vertical_thrust(const Vehicle& v, const FlatSamples& flat, int i) {
  Moving f;
  f.v = 0.25 * v.mass * (load(&flat[2](i, 2)) + v.gravity);
  f.d[0] = 0.25 * v.mass * load(&flat[3](i, 2));
  return f;
}

void evaluate_vertical(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  const auto& rows = constraints.rows();
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Moving f = vertical_thrust(constraints.vehicle(), flat, i);
    for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
      if (rows[r].of_rotor()) store(&values(i, r), rotor_row(rows[r].terms, f.v, f.d[0], least_root(constraints)));
    }
  }
}

void differentiate_vertical(const Constraints& constraints, const FlatSamples& flat,
                            std::vector<Eigen::MatrixXd>& slopes) {
  const auto& rows = constraints.rows();
  const double by_acceleration = 0.25 * constraints.vehicle().mass;
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Pack f = vertical_thrust(constraints.vehicle(), flat, i).v;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (!rows[r].of_rotor()) continue;
      const RotorTerms& terms = rows[r].terms;
      store(&slopes[r](i, 0), by_acceleration * share_of(terms, f, least_root(constraints)));
      if (rows[r].entries.size() > 1) store(&slopes[r](i, 1), splat(by_acceleration * terms.lead));
    }
  }
}

}  // namespace

void evaluate_dynamics(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  if (constraints.limits().vertical) return evaluate_vertical(constraints, flat, values);
  constraints.limits_rates() ? evaluate_moving(constraints, flat, values) : evaluate_still(constraints, flat, values);
}

void differentiate_dynamics(const Constraints& constraints, const FlatSamples& flat,
                            std::vector<Eigen::MatrixXd>& slopes) {
  if (constraints.limits().vertical) return differentiate_vertical(constraints, flat, slopes);
  constraints.limits_rates() ? differentiate_moving(constraints, flat, slopes)
                             : differentiate_still(constraints, flat, slopes);
}

}  // namespace halfroll::planner
