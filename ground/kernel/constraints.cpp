#include "constraints.hpp"

#include <cmath>

#include "dual.hpp"
#include "inverse_dynamics.hpp"

namespace halfroll::planner {
namespace {

// A rotor's thrust depends on the first kDynamicEntries, its rate on all.
const std::vector<Entry> kDynamics = {{0, 2}, {1, 2}, {2, 2}, {0, 3}, {1, 3}, {2, 3},
                                      {0, 4}, {1, 4}, {2, 4}, {3, 0}, {3, 1}, {3, 2}};
const std::vector<Entry> kRateDynamics = {{0, 2}, {1, 2}, {2, 2}, {0, 3}, {1, 3}, {2, 3}, {0, 4}, {1, 4},
                                          {2, 4}, {3, 0}, {3, 1}, {3, 2}, {0, 5}, {1, 5}, {2, 5}, {3, 3}};
constexpr std::array<int, kRateEntries> kBelow = {-1, -1, -1, 0, 1, 2, 3, 4, 5, -1, 9, 10, 6, 7, 8, 11};  // one order
constexpr double kLeastRoot = 1e-3;  // of the largest thrust: the root of less is taken along its tangent

using Moving = Dual<1>;  // four samples and their derivatives by time

const Pack& value_of(const Pack& s) { return s; }
const Pack& value_of(const Moving& s) { return s.v; }
Pack rate_of(const Pack&) { return Pack{}; }
const Pack& rate_of(const Moving& s) { return s.d[0]; }

void take(const FlatSamples& flat, int derivative, int axis, int i, Pack& out) {
  out = load(&flat[derivative](i, axis));
}
void take(const FlatSamples& flat, int derivative, int axis, int i, Moving& out) {
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

/// Gradients of the four rotor thrusts.
template <class S>
std::array<std::array<S, kDynamicEntries>, 4> thrust_gradients(const ThrustAxis<S>& axis, const BodyRate<S>& b,
                                                               const Flat<S>& q, const Vehicle& v) {
  const auto& J = v.inertia;
  const S zero = 0.0 * axis.size;
  const auto constant_one = [&](double k) { return zero + k; };
  // torque_x = Jx dw1 + (Jz - Jy) w2 w3, and so on: u is its gradient by dw, the second argument by w
  const double kx = 0.5 / v.arm * (J[2] - J[1]), ky = 0.5 / v.arm * (J[0] - J[2]);
  const auto x = by_entry(
      pull_back<S>({constant_one(0.5 / v.arm * J[0]), zero, zero}, {zero, kx * b.w[2], kx * b.w[1]}, axis, b, q));
  const auto y = by_entry(
      pull_back<S>({zero, constant_one(0.5 / v.arm * J[1]), zero}, {ky * b.w[2], zero, ky * b.w[0]}, axis, b, q));
  const double yaw = 0.25 / v.yaw_coefficient, kz = yaw * (J[1] - J[0]);
  const auto z =
      by_entry(pull_back<S>({zero, zero, constant_one(yaw * J[2])}, {kz * b.w[1], kz * b.w[0], zero}, axis, b, q));
  std::array<std::array<S, kDynamicEntries>, 4> rotors;
  for (int e = 0; e < kDynamicEntries; ++e) {
    const S thrust = e < 3 ? (0.25 * v.mass) * axis.n[e] : zero;  // gradient of |f| is n
    rotors[0][e] = thrust + x[e] - z[e];
    rotors[1][e] = thrust + y[e] + z[e];
    rotors[2][e] = thrust - x[e] - z[e];
    rotors[3][e] = thrust - y[e] + z[e];
  }
  return rotors;
}

/// sqrt(root f) and its slope; of little or negative thrust along the tangent, for the solver may look there.
struct Root {
  Pack value, slope;
};
Root root_of(double root, const Pack& f, double least) {
  Root out;
  for (int i = 0; i < Pack::kWidth; ++i) {
    const double at = std::max(f.v[i], least), size = std::sqrt(root * at);
    out.slope.v[i] = 0.5 * size / at;
    out.value.v[i] = size + out.slope.v[i] * (f.v[i] - at);
  }
  return out;
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
  const Pack share =
      terms.root == 0.0 ? splat(terms.share) : splat(terms.share) - root_of(terms.root, value_of(f), least).slope;
  for (int e = 0; e < static_cast<int>(row.entries.size()); ++e) {
    Pack sum{};
    if (e < kDynamicEntries) sum = share * value_of(gradient[e]) + terms.lead * rate_of(gradient[e]);
    if (terms.lead != 0.0 && kBelow[e] >= 0) sum = sum + terms.lead * value_of(gradient[kBelow[e]]);
    store(&slope(i, e), sum);
  }
}

}  // namespace

std::pair<std::string, const char*> describe(const Row& row) {
  const std::string rotor = "rotor " + std::to_string(row.terms.rotor + 1);
  switch (row.quantity) {
    case Quantity::kRotorThrust: return {rotor, "N"};
    case Quantity::kRotorRate: return {"thrust rate of " + rotor, "N/s"};
    case Quantity::kRotorCommand: return {"command of " + rotor, "N"};
    case Quantity::kRotorRise: return {"motor speed-up of " + rotor, "N"};
    case Quantity::kRotorFall: return {"motor slow-down of " + rotor, "N"};
    case Quantity::kForce: return {"thrust", "N"};
    case Quantity::kForceZ: return {"vertical thrust", "N"};
    case Quantity::kUprightness: return {"cosine of tilt", "1"};
    case Quantity::kRateSquared: return {"body rate squared", "rad²/s²"};
    case Quantity::kSpeedSquared: return {"speed squared", "m²/s²"};
    case Quantity::kHeight: return {"height", "m"};
    case Quantity::kHeading: return {"heading", ""};
    case Quantity::kWall: return {"fence", "m"};
  }
  return {"", ""};
}

Constraints::Constraints(const Vehicle& vehicle, const Limits& limits, bool any_speed_limit, int walls)
    : vehicle_(vehicle), limits_(limits) {
  const std::vector<Entry> velocity = {{0, 1}, {1, 1}, {2, 1}}, acceleration = {{0, 2}, {1, 2}, {2, 2}};
  const double weight = vehicle.mass * vehicle.gravity, scale = limits.rotor_max;
  const int rotors = limits.vertical ? 1 : 4;  // straight up and down all four do the same
  for (int i = 0; i < rotors; ++i) {
    add(Quantity::kRotorThrust, limits.vertical ? std::vector<Entry>{{2, 2}} : kDynamics, {i});
    bound(-1.0, limits.rotor_max, scale);
    bound(1.0, limits.rotor_min, scale);
  }
  for (int i = 0; i < rotors; ++i) add_rotor_rates(i);
  if (!limits.vertical && std::isfinite(limits.force_min)) {
    add(Quantity::kForce, acceleration);
    bound(1.0, limits.force_min, 4.0 * scale);
  }
  if (std::isfinite(limits.force_z_min)) {
    add(Quantity::kForceZ, {{2, 2}});
    bound(1.0, limits.force_z_min, weight);
  }
  if (!limits.vertical && std::isfinite(limits.tilt_cos_min)) {
    add(Quantity::kUprightness, acceleration);
    bound(1.0, limits.tilt_cos_min, 1.0);
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
  if (std::isfinite(limits.floor) || std::isfinite(limits.ceiling)) {
    add(Quantity::kHeight, {{2, 0}});
    if (std::isfinite(limits.floor)) bound(1.0, limits.floor, 1.0);
    if (std::isfinite(limits.ceiling)) bound(-1.0, limits.ceiling, 1.0);
  }
  if (!limits.vertical && limits.heading.rule != Heading::Rule::kNone) {
    const int order = limits.heading.rule == Heading::Rule::kPath ? 1 : 0;
    add(Quantity::kHeading, {{0, order}, {1, order}, {3, 0}});
    bound(1.0, -limits.heading.slack, 10.0 * limits.heading.slack);
  }
  for (int i = 0; i < walls; ++i) {
    add(Quantity::kWall, {{0, 0}, {1, 0}});
    rows_.back().wall = i;
    bound(-1.0, kNoLimit, 1.0);
  }
}

/// A thrust that follows its command c with a lag needs c = f + lag f'. A motor whose speed, the root of its thrust,
/// does, needs the speed sqrt(f) + lag f'/(2 sqrt(f)); times sqrt(f) that is linear in f'.
void Constraints::add_rotor_rates(int rotor) {
  const std::vector<Entry> entries = limits_.vertical ? std::vector<Entry>{{2, 2}, {2, 3}} : kRateDynamics;
  const Drive& drive = limits_.drive;
  const double scale = limits_.rotor_max;
  if (std::isfinite(limits_.rotor_rate_max)) {
    add(Quantity::kRotorRate, entries, {rotor, 0.0, 1.0});
    bound(-1.0, limits_.rotor_rate_max, limits_.rotor_rate_max);
    bound(1.0, -limits_.rotor_rate_max, limits_.rotor_rate_max);
    limits_rates_ = true;
  }
  if (!std::isfinite(drive.command_max)) return;
  limits_rates_ = true;
  if (drive.of_speed) {
    add(Quantity::kRotorRise, entries, {rotor, 1.0, 0.5 * drive.lag_up, drive.command_max});
    bound(-1.0, 0.0, scale);
    add(Quantity::kRotorFall, entries, {rotor, 1.0, 0.5 * drive.lag_down, drive.command_min});
    bound(1.0, 0.0, scale);
  } else {
    add(Quantity::kRotorCommand, entries, {rotor, 1.0, drive.lag_up});
    bound(-1.0, drive.command_max, scale);
    bound(1.0, drive.command_min, scale);
  }
}

void Constraints::add(Quantity quantity, std::vector<Entry> entries, RotorTerms terms) {
  rows_.push_back({quantity, std::move(entries), terms});
}

void Constraints::bound(double sign, double limit, double scale) {
  bounds_.push_back({static_cast<int>(rows_.size()) - 1, sign, limit, scale});
}

Bound Constraints::on_piece(int index, const PieceLimits& piece) const {
  Bound b = bounds_[index];
  if (rows_[b.row].quantity == Quantity::kSpeedSquared) {
    const double fastest = std::isfinite(piece.speed_max) ? piece.speed_max : 1e3;  // no limit: one that is never met
    b.limit = b.scale = fastest * fastest;
  }
  const int wall = rows_[b.row].wall;
  if (wall >= 0) b.limit = piece.wall(wall).offset;
  return b;
}

SampleTable::SampleTable(int count, bool rates)
    : intervals_(rates ? count - 1 : count), derivatives_(rates ? kSampled : kGiven) {
  for (int d = 0; d < derivatives_; ++d) {
    tables_[d].resize(count, kOrder);
    rows_[d].assign(count * kRow, 0.0);
    for (int i = 0; i < count; ++i) {
      const BasisRow row = hermite_row(static_cast<double>(i) / intervals_, d);
      tables_[d].row(i) = row;
      std::copy_n(row.data(), kOrder, &rows_[d][i * kRow]);
    }
  }
}

HALFROLL_WIDE void sample_piece(const Ends& ends, double duration, const SampleTable& table, FlatSamples& flat) {
  const int count = table.count();
  double power = 1.0;
  for (int d = 0; d < table.derivatives(); ++d, power /= duration) {
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

namespace {

template <class S>
void evaluate_dynamics(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const double least = kLeastRoot * constraints.limits().rotor_max;
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Flat<S> q = load_flat<S>(flat, i);
    const ThrustAxis<S> axis = thrust_axis(q, v.gravity);
    const BodyRate<S> rate = body_rate(axis, q);
    const std::array<S, 4> f = rotor_thrusts(axis.size, rate, v);
    for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
      const RotorTerms& terms = rows[r].terms;
      if (rows[r].of_rotor())
        store(&values(i, r), rotor_row(terms, value_of(f[terms.rotor]), rate_of(f[terms.rotor]), least));
      if (rows[r].quantity == Quantity::kForce) store(&values(i, r), v.mass * value_of(axis.size));
      if (rows[r].quantity == Quantity::kUprightness) store(&values(i, r), value_of(axis.n[2]));
      if (rows[r].quantity == Quantity::kRateSquared) store(&values(i, r), value_of(dot(rate.w, rate.w)));
    }
  }
}

template <class S>
void differentiate_dynamics(const Constraints& constraints, const FlatSamples& flat,
                            std::vector<Eigen::MatrixXd>& slopes) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const double least = kLeastRoot * constraints.limits().rotor_max;
  for (int i = 0; i < flat[0].rows(); i += Pack::kWidth) {
    const Flat<S> q = load_flat<S>(flat, i);
    const ThrustAxis<S> axis = thrust_axis(q, v.gravity);
    const BodyRate<S> b = body_rate(axis, q);
    const std::array<S, 4> f = rotor_thrusts(axis.size, b, v);
    const auto gradients = thrust_gradients(axis, b, q, v);
    const Vec<Pack> n = {value_of(axis.n[0]), value_of(axis.n[1]), value_of(axis.n[2])};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const int rotor = rows[r].terms.rotor;
      if (rotor >= 0) store_rotor_row(rows[r], f[rotor], gradients[rotor], least, slopes[r], i);
      for (int a = 0; a < 3; ++a) {
        if (rows[r].quantity == Quantity::kForce) store(&slopes[r](i, a), v.mass * n[a]);
        if (rows[r].quantity == Quantity::kUprightness) {  // (e3 - n3 n)/|f|
          store(&slopes[r](i, a), value_of(axis.inv) * (splat(a == 2 ? 1.0 : 0.0) - n[2] * n[a]));
        }
      }
      if (rows[r].quantity == Quantity::kRateSquared) {
        const S zero = 0.0 * axis.size;
        const auto g =
            by_entry(pull_back<S>({zero, zero, zero}, {2.0 * b.w[0], 2.0 * b.w[1], 2.0 * b.w[2]}, axis, b, q));
        for (int e = 0; e < kDynamicEntries; ++e) store(&slopes[r](i, e), value_of(g[e]));
      }
    }
  }
}

/// Value and slopes of the heading's row at a sample.
struct HeadingRow {
  double value, by_x, by_y, by_yaw;
};
HeadingRow heading_row(const Heading& heading, const FlatSamples& flat, int i) {
  const bool path = heading.rule == Heading::Rule::kPath;
  const double sign = path ? 1.0 : -1.0;  // of d by the position or velocity
  const double dx = path ? flat[1](i, 0) : heading.x - flat[0](i, 0);
  const double dy = path ? flat[1](i, 1) : heading.y - flat[0](i, 1);
  const double c = std::cos(flat[0](i, 3)), s = std::sin(flat[0](i, 3));
  const double size = std::sqrt(dx * dx + dy * dy + heading.slack * heading.slack);
  return {c * dx + s * dy - heading.cosine * size, sign * (c - heading.cosine * dx / size),
          sign * (s - heading.cosine * dy / size), c * dy - s * dx};
}

/// Straight up and down: one rotor's thrust and its rate, (count) each.
Moving vertical_thrust(const Vehicle& v, const FlatSamples& flat, int i) {
  Moving f;
  f.v = 0.25 * v.mass * (load(&flat[2](i, 2)) + v.gravity);
  f.d[0] = 0.25 * v.mass * load(&flat[3](i, 2));
  return f;
}

// Compiled for each processor, with all that the templates above call.
HALFROLL_WIDE void evaluate_still(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  evaluate_dynamics<Pack>(constraints, flat, values);
}
HALFROLL_WIDE void evaluate_moving(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values) {
  evaluate_dynamics<Moving>(constraints, flat, values);
}
HALFROLL_WIDE void differentiate_still(const Constraints& constraints, const FlatSamples& flat,
                                       std::vector<Eigen::MatrixXd>& slopes) {
  differentiate_dynamics<Pack>(constraints, flat, slopes);
}
HALFROLL_WIDE void differentiate_moving(const Constraints& constraints, const FlatSamples& flat,
                                        std::vector<Eigen::MatrixXd>& slopes) {
  differentiate_dynamics<Moving>(constraints, flat, slopes);
}

}  // namespace

void evaluate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
              Eigen::MatrixXd& values) {
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
      case Quantity::kHeading:
        for (int i = 0; i < count; ++i) column[i] = heading_row(constraints.limits().heading, flat, i).value;
        break;
      case Quantity::kWall: {
        const Wall wall = piece.wall(rows[r].wall);
        column = wall.x * flat[0].col(0).array() + wall.y * flat[0].col(1).array();
        break;
      }
      default: break;  // below
    }
  }
  if (!constraints.limits().vertical) {
    if (constraints.limits_rates()) {
      evaluate_moving(constraints, flat, values);
    } else {
      evaluate_still(constraints, flat, values);
    }
    return;
  }
  for (int i = 0; i < count; i += Pack::kWidth) {
    const Moving f = vertical_thrust(v, flat, i);
    for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
      const double least = kLeastRoot * constraints.limits().rotor_max;
      if (rows[r].of_rotor()) store(&values(i, r), rotor_row(rows[r].terms, f.v, f.d[0], least));
    }
  }
}

void differentiate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
                   std::vector<Eigen::MatrixXd>& slopes) {
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
      case Quantity::kHeading:
        for (int i = 0; i < count; ++i) {
          const HeadingRow row = heading_row(constraints.limits().heading, flat, i);
          slopes[r].row(i) << row.by_x, row.by_y, row.by_yaw;
        }
        break;
      case Quantity::kWall: {
        const Wall wall = piece.wall(rows[r].wall);
        slopes[r].col(0).setConstant(wall.x);
        slopes[r].col(1).setConstant(wall.y);
        break;
      }
      default: break;  // below
    }
  }
  if (!constraints.limits().vertical) {
    if (constraints.limits_rates()) {
      differentiate_moving(constraints, flat, slopes);
    } else {
      differentiate_still(constraints, flat, slopes);
    }
    return;
  }
  const double by_acceleration = 0.25 * v.mass, least = kLeastRoot * constraints.limits().rotor_max;
  for (int i = 0; i < count; i += Pack::kWidth) {
    const Pack f = vertical_thrust(v, flat, i).v;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const RotorTerms& terms = rows[r].terms;
      if (!rows[r].of_rotor()) continue;
      const Pack root = terms.root == 0.0 ? Pack{} : root_of(terms.root, f, least).slope;
      store(&slopes[r](i, 0), by_acceleration * (splat(terms.share) - root));
      if (rows[r].entries.size() > 1) store(&slopes[r](i, 1), splat(by_acceleration * terms.lead));
    }
  }
}

Entry dynamic_entry(int index) { return kRateDynamics[index]; }

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
  const double least = kLeastRoot * constraints.limits().rotor_max;
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

    const ThrustAxis<D> axis = thrust_axis(q, v.gravity);
    const BodyRate<D> b = body_rate(axis, q);
    const std::array<D, 4> f = rotor_thrusts(axis.size, b, v);
    S rotor[4] = {}, rate{};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const RotorTerms& terms = rows[r].terms;
      const Pack weight = load(&weights(i, static_cast<int>(r)));
      if (rows[r].of_rotor()) {
        const Pack root = terms.root == 0.0 ? Pack{} : root_of(terms.root, value_of(f[terms.rotor].v), least).slope;
        weigh(terms, weight, splat(terms.share) - root, rotor[terms.rotor]);
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
    FlatGradient<D> g = pull_back(by_dw, by_w, axis, b, q);
    g.acceleration = g.acceleration + on_thrust * axis.n;
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
