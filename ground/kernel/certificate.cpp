#include "certificate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "bisection.hpp"
#include "dual.hpp"
#include "inverse_dynamics.hpp"
#include "samples.hpp"
#include "taylor_model.hpp"

namespace halfroll::planner {
namespace {

constexpr int P = TaylorModel::kDegree;

struct Falling {
  double table[kSampled][kOrder] = {};  // i (i-1) .. (i-r+1)
  constexpr Falling() {
    for (int r = 0; r < kSampled; ++r) {
      for (int i = 0; i < kOrder; ++i) {
        table[r][i] = 1.0;
        for (int j = 0; j < r; ++j) table[r][i] *= i - j;
      }
    }
  }
};
constexpr Falling kFalling;

/// Derivatives first..last by time of one axis on parts of a piece.
void model_axis(const Coefficients& piece, int axis, double duration, const Parts& parts, int first, int last,
                std::array<TaylorModel, kSampled>& out) {
  std::array<Pack, kOrder> terms, sizes;  // of t^i on the part; what was added up to them
  for (int i = 0; i < kOrder; ++i) terms[i] = splat(piece(i, axis));
  for (int i = 0; i < kOrder; ++i) {
    for (int j = kOrder - 2; j >= i; --j) terms[j] += parts.centre * terms[j + 1];
  }
  const Pack end = parts.centre + parts.half;
  Pack width = splat(1.0), reach = width;
  for (int i = 0; i < kOrder; ++i, width = width * parts.half, reach = reach * end) {
    terms[i] = width * terms[i];
    sizes[i] = std::abs(piece(i, axis)) * reach;
  }
  const Pack by_width = inverse(duration * parts.half), by_reach = inverse(duration * end);
  Pack scale = splat(1.0), size_scale = scale;
  for (int r = 0; r <= last; ++r, scale = scale * by_width, size_scale = size_scale * by_reach) {
    if (r < first) continue;
    TaylorModel& model = out[r] = TaylorModel{};
    Pack size{};
    for (int i = 0; i + r < kOrder; ++i) {
      const Pack term = kFalling.table[r][i + r] * (scale * terms[i + r]);
      if (i <= P) {
        model.c[i] = term;
      } else {
        model.remainder += absolute(term);
      }
      size += kFalling.table[r][i + r] * (size_scale * sizes[i + r]);
    }
    // of the shift: 2 * 10 roundings of the sum of sizes
    model.remainder = (1.0 + kUlp) * model.remainder + 8.0 * kUlp * (size + model.size());
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

/// Where the rows of the constraints are on parts of a piece, in their order.
HALFROLL_WIDE void enclose(const Coefficients& coefficients, double duration, const Parts& parts,
                           const PieceLimits& piece, const Constraints& constraints, std::vector<Interval>& rows) {
  Motion motion;
  const bool rates = constraints.limits_rates();
  for (int a = 0; a < kAxes; ++a) {
    const int last = (a < 3 ? 4 : 2) + (rates ? 1 : 0);
    model_axis(coefficients, a, duration, parts, constraints.lowest_order(a), last, motion.axes[a]);
  }
  const Vehicle& v = constraints.vehicle();
  RowModels models;
  if (constraints.limits().vertical) {
    models.thrust[0] = 0.25 * v.mass * (motion.axes[2][2] + v.gravity);
    models.rate[0] = 0.25 * v.mass * motion.axes[2][3];
  } else if (rates) {
    models = models_of<Moving>(motion, v);
  } else {
    models = models_of<TaylorModel>(motion, v);
  }
  const Vec<TaylorModel> velocity = {motion.axes[0][1], motion.axes[1][1], motion.axes[2][1]};
  rows.clear();
  for (const Row& row : constraints.rows()) {
    switch (row.quantity) {
      case Quantity::kForce: rows.push_back(range(models.size)); break;
      case Quantity::kForceZ: rows.push_back(range(v.mass * (motion.axes[2][2] + v.gravity))); break;
      case Quantity::kUprightness: rows.push_back(range(models.uprightness)); break;
      case Quantity::kRateSquared: rows.push_back(range(models.body_rate_squared)); break;
      case Quantity::kSpeedSquared: rows.push_back(range(dot(velocity, velocity))); break;
      case Quantity::kHeight: rows.push_back(range(motion.axes[2][0])); break;
      case Quantity::kHeading: rows.push_back(range(heading_row(motion, constraints.limits().heading))); break;
      case Quantity::kWall: {
        const Wall wall = piece.wall(row.wall);
        rows.push_back(range(wall.x * motion.axes[0][0] + wall.y * motion.axes[1][0]));
        break;
      }
      default: rows.push_back(range(rotor_row(row.terms, models)));
    }
  }
}

/// By how much a bound may be exceeded where its row is in this interval.
double excess(const Bound& bound, const Interval& interval, int lane) {
  return bound.sign > 0.0 ? bound.limit - interval.low.v[lane] : interval.high.v[lane] - bound.limit;
}

}  // namespace

Certificate certify(const std::vector<Coefficients>& pieces, const std::vector<double>& durations,
                    const std::vector<PieceLimits>& limits, const Constraints& constraints) {
  Certificate result;
  const int bounds = static_cast<int>(constraints.bounds().size());
  std::vector<Bound> on_piece(bounds, Bound{});
  std::vector<Interval> rows;
  for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
    for (int b = 0; b < bounds; ++b) on_piece[b] = constraints.on_piece(b, limits[k]);
    prove(k, 0.0, 1.0, result, [&](const Parts& parts) {
      enclose(pieces[k], durations[k], parts, limits[k], constraints, rows);
      Doubts doubts;
      for (int lane = 0; lane < Pack::kWidth; ++lane) {
        for (int b = 0; b < bounds; ++b) {
          doubts[lane].consider(b, excess(on_piece[b], rows[on_piece[b].row], lane), on_piece[b].scale);
        }
      }
      return doubts;
    });
  }
  return result;
}

}  // namespace halfroll::planner
