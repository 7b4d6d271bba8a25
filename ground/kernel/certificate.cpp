#include "certificate.hpp"

#include "inverse_dynamics.hpp"
#include "taylor_model.hpp"

namespace halfroll::planner {
namespace {

constexpr int P = TaylorModel::kDegree;
constexpr int kDeepest = 12;  // halvings of a piece
constexpr int kFirstParts = 8;

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

/// Derivatives 0..4 by time of one axis on a part.
void models(const Coefficients& piece, int axis, double duration, const Part& part,
            std::array<TaylorModel, kGiven>& out) {
  std::array<double, kOrder> shifted;
  for (int i = 0; i < kOrder; ++i) shifted[i] = piece(i, axis);
  for (int i = 0; i < kOrder; ++i) {
    for (int j = kOrder - 2; j >= i; --j) shifted[j] += part.centre * shifted[j + 1];
  }
  double time = 1.0;
  for (int r = 0; r < kGiven; ++r, time /= duration) {
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

struct Motion {
  std::array<std::array<TaylorModel, kGiven>, kAxes> axes;
  Flat<TaylorModel> flat() const {
    const auto derivative = [&](int d) -> Vec<TaylorModel> { return {axes[0][d], axes[1][d], axes[2][d]}; };
    return {derivative(2), derivative(3), derivative(4), axes[3][0], axes[3][1], axes[3][2]};
  }
};

/// The rows of the constraints as models, in their order.
std::vector<TaylorModel> rows_of(const Motion& motion, const Constraints& constraints) {
  const Vehicle& v = constraints.vehicle();
  const bool vertical = constraints.limits().vertical;
  std::array<TaylorModel, 4> rotors;
  TaylorModel size, rate;
  if (vertical) {
    rotors[0] = 0.25 * v.mass * (motion.axes[2][2] + v.gravity);
  } else {
    const Flat<TaylorModel> flat = motion.flat();
    const ThrustAxis<TaylorModel> axis = thrust_axis(flat, v.gravity);
    const BodyRate<TaylorModel> body = body_rate(axis, flat);
    rotors = rotor_thrusts(axis.size, body, v);
    size = v.mass * axis.size;
    rate = dot(body.w, body.w);
  }
  const Vec<TaylorModel> velocity = {motion.axes[0][1], motion.axes[1][1], motion.axes[2][1]};
  std::vector<TaylorModel> rows;
  for (const Row& row : constraints.rows()) {
    switch (row.quantity) {
      case Quantity::kForce: rows.push_back(size); break;
      case Quantity::kForceZ: rows.push_back(v.mass * (motion.axes[2][2] + v.gravity)); break;
      case Quantity::kRateSquared: rows.push_back(rate); break;
      case Quantity::kSpeedSquared: rows.push_back(dot(velocity, velocity)); break;
      case Quantity::kHeight: rows.push_back(motion.axes[2][0]); break;
      default: rows.push_back(rotors[static_cast<int>(row.quantity)]);
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
                    const std::vector<double>& speed_max, const Constraints& constraints) {
  Certificate result;
  const int bounds = static_cast<int>(constraints.bounds().size());
  double worst = 0.0;
  for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
    std::vector<Bound> on_piece;
    for (int b = 0; b < bounds; ++b) on_piece.push_back(constraints.on_piece(b, speed_max[k]));
    std::vector<Part> open;
    for (int i = kFirstParts - 1; i >= 0; --i) open.push_back({(i + 0.5) / kFirstParts, 0.5 / kFirstParts, 3});
    while (!open.empty()) {
      const Part part = open.back();
      open.pop_back();
      ++result.intervals;
      Motion motion;
      for (int a = 0; a < kAxes; ++a) models(pieces[k], a, durations[k], part, motion.axes[a]);
      const std::vector<TaylorModel> rows = rows_of(motion, constraints);
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
