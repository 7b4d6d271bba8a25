#include "certificate.hpp"

#include "dual.hpp"
#include "inverse_dynamics.hpp"
#include "samples.hpp"
#include "taylor_model.hpp"

namespace halfroll::planner {
namespace {

constexpr int P = TaylorModel::kDegree;
constexpr int kDeepest = 12;  // halvings of a piece
constexpr int kFirstParts = 4;

/// Bernstein coefficients of the powers of t on [-1, 1].
std::array<std::array<double, P + 1>, P + 1> bernstein() {
  double binomial[P + 1][P + 1] = {};
  for (int i = 0; i <= P; ++i) {
    for (int j = 0; j <= i; ++j) binomial[i][j] = j == 0 || j == i ? 1.0 : binomial[i - 1][j - 1] + binomial[i - 1][j];
  }
  std::array<std::array<double, P + 1>, P + 1> matrix{};
  for (int k = 0; k <= P; ++k) {
    for (int j = 0; j <= k; ++j) {  // (2 x - 1)^k
      const double power = binomial[k][j] * std::ldexp((k - j) % 2 == 0 ? 1.0 : -1.0, j);
      for (int i = j; i <= P; ++i) matrix[i][k] += binomial[i][j] / binomial[P][j] * power;
    }
  }
  return matrix;
}

/// One part of a piece: tau in [centre - half, centre + half], both exact.
struct Part {
  double centre, half;
  int depth;
};

double falling(int i, int r) {
  double product = 1.0;
  for (int j = 0; j < r; ++j) product *= i - j;
  return product;
}

/// Derivatives by time of one axis on a part.
void model_axis(const Coefficients& piece, int axis, double duration, const Part& part,
                std::array<TaylorModel, kSampled>& out) {
  std::array<double, kOrder> shifted;
  for (int i = 0; i < kOrder; ++i) shifted[i] = piece(i, axis);
  for (int i = 0; i < kOrder; ++i) {
    for (int j = kOrder - 2; j >= i; --j) shifted[j] += part.centre * shifted[j + 1];
  }
  double time = 1.0;
  for (int r = 0; r < kSampled; ++r, time /= duration) {
    TaylorModel& model = out[r] = TaylorModel{};
    double reach = 1.0, sizes = 0.0, width = 1.0;
    for (int i = 0; i + r < kOrder; ++i, reach *= part.centre + part.half, width *= part.half) {
      const double term = falling(i + r, r) * shifted[i + r] * width * time;
      if (i <= P) {
        model.c[i] = term;
      } else {
        model.remainder += std::abs(term);
      }
      sizes += falling(i + r, r) * std::abs(piece(i + r, axis)) * reach * time;
    }
    model.remainder += 8.0 * kUlp * (sizes + model.size());  // of the shift: 2 * 10 roundings of the sum of sizes
  }
}

using Moving = Dual<1, TaylorModel>;  // a model and that of its derivative by time

struct Motion {
  std::array<std::array<TaylorModel, kSampled>, kAxes> axes;
};

void take(const Motion& motion, int derivative, int axis, TaylorModel& out) { out = motion.axes[axis][derivative]; }
void take(const Motion& motion, int derivative, int axis, Moving& out) {
  out.v = motion.axes[axis][derivative];
  out.d[0] = motion.axes[axis][derivative + 1];
}

template <class S>
Flat<S> flat_of(const Motion& motion) {
  Flat<S> q;
  for (int a = 0; a < 3; ++a) {
    take(motion, 2, a, q.acceleration[a]);
    take(motion, 3, a, q.jerk[a]);
    take(motion, 4, a, q.snap[a]);
  }
  take(motion, 0, 3, q.yaw);
  take(motion, 1, 3, q.yaw_rate);
  take(motion, 2, 3, q.yaw_acceleration);
  return q;
}

const TaylorModel& value_of(const TaylorModel& s) { return s; }
const TaylorModel& value_of(const Moving& s) { return s.v; }
TaylorModel rate_of(const TaylorModel&) { return {}; }
const TaylorModel& rate_of(const Moving& s) { return s.d[0]; }

/// What the rows are made of.
struct RowModels {
  std::array<TaylorModel, 4> thrust, rate;
  TaylorModel size, uprightness, body_rate_squared;
};

template <class S>
RowModels models_of(const Motion& motion, const Vehicle& v) {
  const Dynamics<S> at = dynamics(flat_of<S>(motion), v);
  RowModels out;
  for (int i = 0; i < 4; ++i) out.thrust[i] = value_of(at.thrust[i]), out.rate[i] = rate_of(at.thrust[i]);
  out.size = v.mass * value_of(at.axis.size);
  out.uprightness = value_of(at.axis.n[2]);
  const Vec<TaylorModel> w = {value_of(at.body.w[0]), value_of(at.body.w[1]), value_of(at.body.w[2])};
  out.body_rate_squared = dot(w, w);
  return out;
}

TaylorModel rotor_row(const RotorTerms& terms, const RowModels& models) {
  const TaylorModel& f = models.thrust[terms.rotor];
  const TaylorModel sum = terms.share * f + terms.lead * models.rate[terms.rotor];
  return terms.root == 0.0 ? sum : sum - std::sqrt(terms.root) * (f * inverse_sqrt(f));
}

TaylorModel heading_row(const Motion& motion, const Heading& heading) {
  const bool path = heading.rule == Heading::Rule::kPath;
  const TaylorModel dx = path ? motion.axes[0][1] : -1.0 * motion.axes[0][0] + heading.x;
  const TaylorModel dy = path ? motion.axes[1][1] : -1.0 * motion.axes[1][0] + heading.y;
  const TaylorModel square = dx * dx + dy * dy + heading.slack * heading.slack;
  const TaylorModel& yaw = motion.axes[3][0];
  return cosine(yaw) * dx + sine(yaw) * dy - heading.cosine * (square * inverse_sqrt(square));
}

/// The rows of the constraints as models, in their order.
std::vector<TaylorModel> rows_of(const Motion& motion, const PieceLimits& piece, const Constraints& constraints) {
  const Vehicle& v = constraints.vehicle();
  RowModels models;
  if (constraints.limits().vertical) {
    models.thrust[0] = 0.25 * v.mass * (motion.axes[2][2] + v.gravity);
    models.rate[0] = 0.25 * v.mass * motion.axes[2][3];
  } else if (constraints.limits_rates()) {
    models = models_of<Moving>(motion, v);
  } else {
    models = models_of<TaylorModel>(motion, v);
  }
  const Vec<TaylorModel> velocity = {motion.axes[0][1], motion.axes[1][1], motion.axes[2][1]};
  std::vector<TaylorModel> rows;
  for (const Row& row : constraints.rows()) {
    switch (row.quantity) {
      case Quantity::kForce: rows.push_back(models.size); break;
      case Quantity::kForceZ: rows.push_back(v.mass * (motion.axes[2][2] + v.gravity)); break;
      case Quantity::kUprightness: rows.push_back(models.uprightness); break;
      case Quantity::kRateSquared: rows.push_back(models.body_rate_squared); break;
      case Quantity::kSpeedSquared: rows.push_back(dot(velocity, velocity)); break;
      case Quantity::kHeight: rows.push_back(motion.axes[2][0]); break;
      case Quantity::kHeading: rows.push_back(heading_row(motion, constraints.limits().heading)); break;
      case Quantity::kWall: {
        const Wall wall = piece.wall(row.wall);
        rows.push_back(wall.x * motion.axes[0][0] + wall.y * motion.axes[1][0]);
        break;
      }
      default: rows.push_back(rotor_row(row.terms, models));
    }
  }
  return rows;
}

/// By how much a bound may be exceeded where its row is in this interval; NaN counts as infinitely much.
double excess(const Bound& bound, const Interval& interval) {
  const double over = bound.sign > 0.0 ? bound.limit - interval.low : interval.high - bound.limit;
  return std::isnan(over) ? kNoLimit : over;
}

}  // namespace

Interval range(const TaylorModel& a) {
  static const auto matrix = bernstein();
  Interval interval{kNoLimit, -kNoLimit};
  for (const auto& row : matrix) {
    double point = 0.0;
    for (int k = 0; k <= P; ++k) point += row[k] * a.c[k];
    interval.low = std::min(interval.low, point);
    interval.high = std::max(interval.high, point);
  }
  const double spread = a.remainder + 8.0 * kUlp * a.size();  // |Bernstein coefficient of t^k| <= 1
  if (!(spread < kNoLimit)) return {-kNoLimit, kNoLimit};
  return {interval.low - spread, interval.high + spread};
}

Certificate certify(const std::vector<Coefficients>& pieces, const std::vector<double>& durations,
                    const std::vector<PieceLimits>& limits, const Constraints& constraints) {
  Certificate result;
  const int bounds = static_cast<int>(constraints.bounds().size());
  double worst = 0.0;
  for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
    std::vector<Bound> on_piece;
    for (int b = 0; b < bounds; ++b) on_piece.push_back(constraints.on_piece(b, limits[k]));
    std::vector<Part> open;
    for (int i = kFirstParts - 1; i >= 0; --i) open.push_back({(i + 0.5) / kFirstParts, 0.5 / kFirstParts, 2});
    while (!open.empty()) {
      const Part part = open.back();
      open.pop_back();
      ++result.intervals;
      Motion motion;
      for (int a = 0; a < kAxes; ++a) model_axis(pieces[k], a, durations[k], part, motion.axes[a]);
      const std::vector<TaylorModel> rows = rows_of(motion, limits[k], constraints);
      int exceeded = -1;
      double relative = 0.0;
      for (int b = 0; b < bounds; ++b) {
        const double over = excess(on_piece[b], range(rows[on_piece[b].row])) / on_piece[b].scale;
        if (over > relative) relative = over, exceeded = b;
      }
      if (exceeded < 0) continue;
      if (part.depth < kDeepest) {
        open.push_back({part.centre + part.half / 2.0, part.half / 2.0, part.depth + 1});
        open.push_back({part.centre - part.half / 2.0, part.half / 2.0, part.depth + 1});
        continue;
      }
      if (result.unproven.empty() || result.unproven.back() != k) result.unproven.push_back(k);
      if (result.proven || relative > worst) {
        worst = relative;
        result.piece = k;
        result.bound = exceeded;
        result.excess = relative * on_piece[exceeded].scale;
      }
      result.proven = false;
      break;  // one is enough to refuse the piece
    }
  }
  return result;
}

}  // namespace halfroll::planner
