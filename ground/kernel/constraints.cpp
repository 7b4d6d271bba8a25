#include "constraints.hpp"

#include <cmath>

#include "dual.hpp"
#include "inverse_dynamics.hpp"

namespace halfroll::planner {
namespace {

const std::vector<Entry> kDynamics = {{0, 2}, {1, 2}, {2, 2}, {0, 3}, {1, 3}, {2, 3},
                                      {0, 4}, {1, 4}, {2, 4}, {3, 0}, {3, 1}, {3, 2}};

Vec<Pack> load3(const FlatSamples& flat, int derivative, int i) {
  return {load(&flat[derivative](i, 0)), load(&flat[derivative](i, 1)), load(&flat[derivative](i, 2))};
}

Flat<Pack> load_flat(const FlatSamples& flat, int i) {
  return {load3(flat, 2, i),    load3(flat, 3, i),    load3(flat, 4, i),
          load(&flat[0](i, 3)), load(&flat[1](i, 3)), load(&flat[2](i, 3))};
}

void store_dynamics(const FlatGradient<Pack>& g, Eigen::MatrixXd& slope, int i) {
  for (int a = 0; a < 3; ++a) {
    store(&slope(i, a), g.acceleration[a]);
    store(&slope(i, 3 + a), g.jerk[a]);
    store(&slope(i, 6 + a), g.snap[a]);
  }
  store(&slope(i, 9), g.yaw);
  store(&slope(i, 10), g.yaw_rate);
  store(&slope(i, 11), g.yaw_acceleration);
}

FlatGradient<Pack> combined(const Vec<Pack>& thrust, double moment, const FlatGradient<Pack>& m, double yaw,
                            const FlatGradient<Pack>& z) {
  const auto mix = [&](const Vec<Pack>& a, const Vec<Pack>& b) -> Vec<Pack> {
    return splat(moment) * a + splat(yaw) * b;
  };
  return {thrust + mix(m.acceleration, z.acceleration),
          mix(m.jerk, z.jerk),
          mix(m.snap, z.snap),
          moment * m.yaw + yaw * z.yaw,
          moment * m.yaw_rate + yaw * z.yaw_rate,
          moment * m.yaw_acceleration + yaw * z.yaw_acceleration};
}

}  // namespace

std::pair<const char*, const char*> describe(Quantity quantity) {
  switch (quantity) {
    case Quantity::kRotor1: return {"rotor 1", "N"};
    case Quantity::kRotor2: return {"rotor 2", "N"};
    case Quantity::kRotor3: return {"rotor 3", "N"};
    case Quantity::kRotor4: return {"rotor 4", "N"};
    case Quantity::kForce: return {"thrust", "N"};
    case Quantity::kForceZ: return {"vertical thrust", "N"};
    case Quantity::kRateSquared: return {"body rate squared", "rad²/s²"};
    case Quantity::kSpeedSquared: return {"speed squared", "m²/s²"};
    case Quantity::kHeight: return {"height", "m"};
  }
  return {"", ""};
}

Constraints::Constraints(const Vehicle& vehicle, const Limits& limits, bool any_speed_limit)
    : vehicle_(vehicle), limits_(limits) {
  const std::vector<Entry> velocity = {{0, 1}, {1, 1}, {2, 1}}, acceleration = {{0, 2}, {1, 2}, {2, 2}};
  const double weight = vehicle.mass * vehicle.gravity, scale = limits.rotor_max;
  const int rotors = limits.vertical ? 1 : 4;  // straight up and down all four do the same
  for (int i = 0; i < rotors; ++i) {
    add(static_cast<Quantity>(i), limits.vertical ? std::vector<Entry>{{2, 2}} : kDynamics);
    bound(-1.0, limits.rotor_max, scale);
    bound(1.0, limits.rotor_min, scale);
  }
  if (!limits.vertical && std::isfinite(limits.force_min)) {
    add(Quantity::kForce, acceleration);
    bound(1.0, limits.force_min, 4.0 * scale);
  }
  if (std::isfinite(limits.force_z_min)) {
    add(Quantity::kForceZ, {{2, 2}});
    bound(1.0, limits.force_z_min, weight);
  }
  if (!limits.vertical && std::isfinite(limits.body_rate_max)) {
    add(Quantity::kRateSquared, kDynamics);
    const double square = limits.body_rate_max * limits.body_rate_max;
    bound(-1.0, square, square);
  }
  if (any_speed_limit) {
    add(Quantity::kSpeedSquared, velocity);
    bound(-1.0, kNoLimit, 1.0);
  }
  if (std::isfinite(limits.floor)) {
    add(Quantity::kHeight, {{2, 0}});
    bound(1.0, limits.floor, 1.0);
  }
}

void Constraints::add(Quantity quantity, std::vector<Entry> entries) {
  rows_.push_back({quantity, std::move(entries)});
}

void Constraints::bound(double sign, double limit, double scale) {
  bounds_.push_back({static_cast<int>(rows_.size()) - 1, sign, limit, scale});
}

Bound Constraints::on_piece(int index, double speed_max) const {
  Bound b = bounds_[index];
  if (rows_[b.row].quantity == Quantity::kSpeedSquared) {
    const double fastest = std::isfinite(speed_max) ? speed_max : 1e3;  // no limit: one that is never met
    b.limit = b.scale = fastest * fastest;
  }
  return b;
}

SampleTable::SampleTable(int count) {
  for (int d = 0; d < kGiven; ++d) {
    tables_[d].resize(count, kOrder);
    rows_[d].assign(count * kRow, 0.0);
    for (int i = 0; i < count; ++i) {
      const BasisRow row = hermite_row(static_cast<double>(i) / count, d);
      tables_[d].row(i) = row;
      std::copy_n(row.data(), kOrder, &rows_[d][i * kRow]);
    }
  }
}

HALFROLL_WIDE void sample_piece(const Ends& ends, double duration, const SampleTable& table, FlatSamples& flat) {
  const int count = table.count();
  double power = 1.0;
  for (int d = 0; d < kGiven; ++d, power /= duration) {
    flat[d].resize(count, kAxes);
    const double* basis = table[d].data();
    double* out = flat[d].data();
    for (int i = 0; i < count; i += Pack::kWidth) {
      Pack total[kAxes] = {};
      for (int q = 0; q < kOrder; ++q) {
        const Pack h = load(basis + q * count + i);
        for (int a = 0; a < kAxes; ++a) total[a] += splat(ends(q, a)) * h;
      }
      for (int a = 0; a < kAxes; ++a) store(out + a * count + i, power * total[a]);
    }
  }
}

/// Of all rows that need the dynamics.
HALFROLL_WIDE void evaluate_dynamics(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const int count = static_cast<int>(flat[0].rows());
  for (int i = 0; i < count; i += Pack::kWidth) {
    const Flat<Pack> q = load_flat(flat, i);
    const ThrustAxis<Pack> axis = thrust_axis(q, v.gravity);
    const BodyRate<Pack> rate = body_rate(axis, q);
    const std::array<Pack, 4> f = rotor_thrusts(axis.size, rate, v);
    for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
      const int rotor = static_cast<int>(rows[r].quantity);
      if (rotor < 4) store(&values(i, r), f[rotor]);
      if (rows[r].quantity == Quantity::kForce) store(&values(i, r), v.mass * axis.size);
      if (rows[r].quantity == Quantity::kRateSquared) store(&values(i, r), dot(rate.w, rate.w));
    }
  }
}

void evaluate(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const int count = static_cast<int>(flat[0].rows());
  values.resize(count, static_cast<int>(rows.size()));
  for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
    auto column = values.col(r).array();
    switch (rows[r].quantity) {
      case Quantity::kForceZ: column = v.mass * (flat[2].col(2).array() + v.gravity); break;
      case Quantity::kSpeedSquared: column = flat[1].leftCols<3>().rowwise().squaredNorm(); break;
      case Quantity::kHeight: column = flat[0].col(2).array(); break;
      case Quantity::kRotor1:
        if (constraints.limits().vertical) column = 0.25 * v.mass * (flat[2].col(2).array() + v.gravity);
        break;
      default: break;  // below
    }
  }
  if (!constraints.limits().vertical) evaluate_dynamics(constraints, flat, values);
}

HALFROLL_WIDE void differentiate_dynamics(const Constraints& constraints, const FlatSamples& flat,
                                          std::vector<Eigen::MatrixXd>& slopes) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const auto& J = v.inertia;
  const int count = static_cast<int>(flat[0].rows());
  const Pack zero = splat(0.0);
  for (int i = 0; i < count; i += Pack::kWidth) {
    const Flat<Pack> q = load_flat(flat, i);
    const ThrustAxis<Pack> axis = thrust_axis(q, v.gravity);
    const BodyRate<Pack> b = body_rate(axis, q);
    // torque_x = Jx dw1 + (Jz - Jy) w2 w3, and so on: u is its gradient by dw, the second argument by w
    const auto x = pull_back<Pack>(
        {splat(0.5 / v.arm * J[0]), zero, zero},
        {zero, (0.5 / v.arm * (J[2] - J[1])) * b.w[2], (0.5 / v.arm * (J[2] - J[1])) * b.w[1]}, axis, b, q);
    const auto y = pull_back<Pack>(
        {zero, splat(0.5 / v.arm * J[1]), zero},
        {(0.5 / v.arm * (J[0] - J[2])) * b.w[2], zero, (0.5 / v.arm * (J[0] - J[2])) * b.w[0]}, axis, b, q);
    const double yaw = 0.25 / v.yaw_coefficient;
    const auto z = pull_back<Pack>({zero, zero, splat(yaw * J[2])},
                                   {(yaw * (J[1] - J[0])) * b.w[1], (yaw * (J[1] - J[0])) * b.w[0], zero}, axis, b, q);
    const Vec<Pack> thrust = splat(0.25 * v.mass) * axis.n;  // gradient of |f| is n
    for (std::size_t r = 0; r < rows.size(); ++r) {
      switch (rows[r].quantity) {
        case Quantity::kRotor1: store_dynamics(combined(thrust, 1.0, x, -1.0, z), slopes[r], i); break;
        case Quantity::kRotor2: store_dynamics(combined(thrust, 1.0, y, 1.0, z), slopes[r], i); break;
        case Quantity::kRotor3: store_dynamics(combined(thrust, -1.0, x, -1.0, z), slopes[r], i); break;
        case Quantity::kRotor4: store_dynamics(combined(thrust, -1.0, y, 1.0, z), slopes[r], i); break;
        case Quantity::kForce:
          for (int a = 0; a < 3; ++a) store(&slopes[r](i, a), v.mass * axis.n[a]);
          break;
        case Quantity::kRateSquared:
          store_dynamics(pull_back<Pack>({zero, zero, zero}, splat(2.0) * b.w, axis, b, q), slopes[r], i);
          break;
        default: break;
      }
    }
  }
}

void differentiate(const Constraints& constraints, const FlatSamples& flat, std::vector<Eigen::MatrixXd>& slopes) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const int count = static_cast<int>(flat[0].rows());
  slopes.resize(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    slopes[r].resize(count, static_cast<int>(rows[r].entries.size()));
    switch (rows[r].quantity) {
      case Quantity::kForceZ: slopes[r].setConstant(v.mass); break;
      case Quantity::kSpeedSquared: slopes[r] = 2.0 * flat[1].leftCols<3>(); break;
      case Quantity::kHeight: slopes[r].setOnes(); break;
      case Quantity::kRotor1:
        if (constraints.limits().vertical) slopes[r].setConstant(0.25 * v.mass);
        break;
      default: break;  // below
    }
  }
  if (!constraints.limits().vertical) differentiate_dynamics(constraints, flat, slopes);
}

Entry dynamic_entry(int index) { return kDynamics[index]; }

HALFROLL_WIDE void curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
                             Eigen::MatrixXd& hessians) {
  // Snap and yaw acceleration enter linearly: the other entries are directions enough.
  constexpr int kDirections = 8;
  constexpr std::array<int, kDirections> directions = {0, 1, 2, 3, 4, 5, 9, 10};
  using D = Dual<kDirections>;
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const double x = 0.5 / v.arm, y = 0.5 / v.arm, z = 0.25 / v.yaw_coefficient;
  const int count = static_cast<int>(flat[0].rows());
  hessians.setZero(count, kDynamicPairs);
  if (constraints.limits().vertical) return;  // linear
  for (int i = 0; i < count; i += Pack::kWidth) {
    const Flat<Pack> at = load_flat(flat, i);
    Flat<D> q;
    for (int a = 0; a < 3; ++a) {
      q.acceleration[a] = variable<kDirections>(at.acceleration[a], a);
      q.jerk[a] = variable<kDirections>(at.jerk[a], 3 + a);
      q.snap[a] = constant<kDirections>(at.snap[a]);
    }
    q.yaw = variable<kDirections>(at.yaw, 6);
    q.yaw_rate = variable<kDirections>(at.yaw_rate, 7);
    q.yaw_acceleration = constant<kDirections>(at.yaw_acceleration);

    Pack rotor[4], rate = splat(0.0);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const int quantity = static_cast<int>(rows[r].quantity);
      if (quantity < 4) rotor[quantity] = load(&weights(i, static_cast<int>(r)));
      if (rows[r].quantity == Quantity::kRateSquared) rate = load(&weights(i, static_cast<int>(r)));
    }
    const D on_thrust = constant<kDirections>(0.25 * v.mass * (rotor[0] + rotor[1] + rotor[2] + rotor[3]));
    const D on_x = constant<kDirections>(x * (rotor[0] - rotor[2]));
    const D on_y = constant<kDirections>(y * (rotor[1] - rotor[3]));
    const D on_z = constant<kDirections>(z * (rotor[1] + rotor[3] - rotor[0] - rotor[2]));
    const D on_rate = constant<kDirections>(2.0 * rate);

    const ThrustAxis<D> axis = thrust_axis(q, v.gravity);
    const BodyRate<D> b = body_rate(axis, q);
    const auto& J = v.inertia;
    const D cx = (J[2] - J[1]) * on_x, cy = (J[0] - J[2]) * on_y, cz = (J[1] - J[0]) * on_z;
    const Vec<D> by_dw = {J[0] * on_x, J[1] * on_y, J[2] * on_z};
    const Vec<D> by_w = {cy * b.w[2] + cz * b.w[1] + on_rate * b.w[0], cx * b.w[2] + cz * b.w[0] + on_rate * b.w[1],
                         cx * b.w[1] + cy * b.w[0] + on_rate * b.w[2]};
    const FlatGradient<D> g = pull_back(by_dw, by_w, axis, b, q);
    const Vec<D> acceleration = g.acceleration + on_thrust * axis.n;
    const D* gradient[kDynamicEntries] = {&acceleration[0], &acceleration[1], &acceleration[2], &g.jerk[0],
                                          &g.jerk[1],       &g.jerk[2],       &g.snap[0],       &g.snap[1],
                                          &g.snap[2],       &g.yaw,           &g.yaw_rate,      &g.yaw_acceleration};
    for (int d = 0; d < kDirections; ++d) {
      const int f = directions[d];
      for (int e = 0; e < kDynamicEntries; ++e) {
        if (e >= f || e == 6 || e == 7 || e == 8) store(&hessians(i, dynamic_pair(e, f)), gradient[e]->d[d]);
      }
    }
  }
}

}  // namespace halfroll::planner
