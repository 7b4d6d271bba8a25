#include "planar_certificate.hpp"

#include <algorithm>
#include <cmath>

#include "bisection.hpp"
#include "taylor_model.hpp"

namespace halfroll::planner {
namespace {

constexpr int P = TaylorModel::kDegree;
constexpr int kRates = 4;  // derivatives 0..3 of the direction

using Powers = std::array<double, kOrder>;  // of tau

/// A polynomial of tau on parts.
TaylorModel model_of(const Powers& powers, const Parts& parts) {
  std::array<Pack, kOrder> shifted;
  for (int i = 0; i < kOrder; ++i) shifted[i] = splat(powers[i]);
  for (int i = 0; i < kOrder; ++i) {
    for (int j = kOrder - 2; j >= i; --j) shifted[j] += parts.centre * shifted[j + 1];
  }
  TaylorModel model;
  const Pack end = parts.centre + parts.half;
  Pack width = splat(1.0), reach = width, sizes{};
  for (int i = 0; i < kOrder; ++i, width = width * parts.half, reach = reach * end) {
    const Pack term = shifted[i] * width;
    if (i <= P) {
      model.c[i] = term;
    } else {
      model.remainder += absolute(term);
    }
    sizes += std::abs(powers[i]) * reach;
  }
  model.remainder += 8.0 * kUlp * (sizes + model.size());
  return model;
}

Powers derivative(const Powers& powers, double duration) {
  Powers out{};
  for (int i = 1; i < kOrder; ++i) out[i - 1] = i * powers[i] / duration;
  return out;
}

/// By t - t_start, what is left of the constant term being rounding.
Powers divided_at_start(const Powers& powers, double duration) {
  Powers out{};
  for (int i = 1; i < kOrder; ++i) out[i - 1] = powers[i] / duration;
  return out;
}

/// By t - t_end: synthetic division by tau - 1, its remainder being rounding.
Powers divided_at_end(const Powers& powers, double duration) {
  Powers out{};
  for (int i = kOrder - 1; i > 0; --i) out[i - 1] = (i < kOrder - 1 ? out[i] : 0.0) + powers[i] / duration;
  return out;
}

Powers axis_of(const PlanarPiece& piece, int axis) {
  Powers powers;
  for (int i = 0; i < kOrder; ++i) powers[i] = piece.path(i, axis);
  return powers;
}

/// What the rows are made of.
struct Models {
  std::array<TaylorModel, 4> thrust, rate;
  TaylorModel turning, speed_squared, height;
};

/// On parts of a half of the piece: the one that begins or the one that ends at a reversal, or neither.
HALFROLL_WIDE Models models_of(const PlanarPiece& piece, const Vehicle& v, const Parts& parts, bool begins, bool ends) {
  Models out;
  std::array<TaylorModel, kRates> x, z;  // of the direction: force, or force divided by time from the reversal
  for (const auto& [axis, along] : {std::pair{0, &x}, std::pair{2, &z}}) {
    const Powers position = axis_of(piece, axis), velocity = derivative(position, piece.duration);
    const TaylorModel speed = model_of(velocity, parts);
    out.speed_squared = out.speed_squared + speed * speed;
    if (axis == 2) out.height = model_of(position, parts);
    Powers force = derivative(velocity, piece.duration);
    if (axis == 2) force[0] += v.gravity;
    if (begins) force = divided_at_start(force, piece.duration);
    if (ends) force = divided_at_end(force, piece.duration);
    for (TaylorModel& model : *along) model = model_of(force, parts), force = derivative(force, piece.duration);
  }
  const TaylorModel square = x[0] * x[0] + z[0] * z[0], along = x[0] * x[1] + z[0] * z[1];
  const TaylorModel further = x[1] * x[1] + z[1] * z[1] + x[0] * x[2] + z[0] * z[2];
  const TaylorModel inv_root = inverse_sqrt(square), inv = inverse(square);
  out.turning = (z[0] * x[1] - x[0] * z[1]) * inv;
  const TaylorModel quickening = (z[0] * x[2] - x[0] * z[2] - 2.0 * (out.turning * along)) * inv;
  const TaylorModel jolt = (z[1] * x[2] + z[0] * x[3] - x[1] * z[2] - x[0] * z[3] -
                            2.0 * (out.turning * further + 2.0 * (quickening * along))) *
                           inv;
  const double scale = 0.25 * v.mass * piece.sign;
  TaylorModel thrust = scale * (square * inv_root), thrust_rate = scale * (along * inv_root);
  if (begins || ends) {
    TaylorModel since;  // time from the reversal
    since.c[0] = piece.duration * (parts.centre + (ends ? -1.0 : 0.0));
    since.c[1] = piece.duration * parts.half;
    since.remainder = kUlp * since.size();
    const double side = ends ? -1.0 : 1.0;
    thrust_rate = side * (thrust + since * thrust_rate);
    thrust = side * (since * thrust);
  }
  const double yaw = piece.path(0, 3), c = std::cos(yaw), s = std::sin(yaw);
  const auto& J = v.inertia;
  const double about_x = 0.5 * J[0] / v.arm * s, about_y = 0.5 * J[1] / v.arm * c;
  const double about_z = 0.25 * (J[1] - J[0]) / v.yaw_coefficient * s * c;
  const TaylorModel gyration = about_z * (out.turning * out.turning);
  const TaylorModel gyration_rate = 2.0 * about_z * (out.turning * quickening);
  for (int rotor = 0; rotor < 4; ++rotor) {
    const double arm = (rotor < 2 ? 1.0 : -1.0) * (rotor % 2 == 0 ? about_x : about_y);
    const double twist = rotor % 2 == 0 ? -1.0 : 1.0;
    out.thrust[rotor] = thrust + arm * quickening + twist * gyration;
    out.rate[rotor] = thrust_rate + arm * jolt + twist * gyration_rate;
  }
  return out;
}

/// What may exceed its limits by most.
Doubts doubts_of(const Models& models, const Vehicle& v, const Limits& limits, double speed_max) {
  Doubts doubts;
  const auto look = [&](int bound, const TaylorModel& row, double low, double high, double scale) {
    if (low == -kNoLimit && high == kNoLimit) return;
    const Interval interval = range(row);
    for (int lane = 0; lane < Pack::kWidth; ++lane) {
      doubts[lane].consider(bound, low - interval.low.v[lane], scale);
      doubts[lane].consider(bound, interval.high.v[lane] - high, scale);
    }
  };
  const double hover = 0.25 * v.mass * v.gravity;
  for (int i = 0; i < 4; ++i) {
    look(i, models.thrust[i], limits.rotor_min, limits.rotor_max, hover);
    look(4 + i, models.rate[i], -limits.rotor_rate_max, limits.rotor_rate_max, limits.rotor_rate_max);
    if (limits.drive.lag_up == 0.0) continue;
    const TaylorModel command = models.thrust[i] + limits.drive.lag_up * models.rate[i];
    look(8 + i, command, limits.drive.command_min, limits.drive.command_max, hover);
  }
  const double rate = limits.body_rate_max, fast = speed_max * speed_max;
  look(12, models.turning, -rate, rate, rate);
  look(13, models.speed_squared, -kNoLimit, fast, fast);
  look(14, models.height, limits.floor, limits.ceiling, 1.0);
  return doubts;
}

}  // namespace

Certificate certify_planar(const std::vector<PlanarPiece>& pieces, const Vehicle& vehicle, const Limits& limits) {
  Certificate result;
  for (int k = 0; k < static_cast<int>(pieces.size()); ++k) {
    const PlanarPiece& piece = pieces[k];
    const auto half = [&](double begin, double end, bool begins, bool ends) {
      return prove(k, begin, end, result, [&](const Parts& parts) {
        return doubts_of(models_of(piece, vehicle, parts, begins, ends), vehicle, limits, piece.speed_max);
      });
    };
    if (half(0.0, 0.5, piece.begins_at_reversal, false)) half(0.5, 1.0, false, piece.ends_at_reversal);
  }
  return result;
}

}  // namespace halfroll::planner
