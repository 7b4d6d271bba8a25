// What pushes the body: rotors, air, ground. Why: one sum, used by the integrator sixteen times a millisecond and by
// the accelerometer once, which feels all of it but gravity.
#pragma once
#include "sim/contact.hpp"
#include "sim/model.hpp"

namespace halfroll::sim {

/// Sums over the rotors of speed share times place, so that a stage of the integrator need not visit each hub.
struct BladeSums {
  double s = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
};

inline BladeSums blade_sums(const Model& model, const PerRotor& speed) {
  BladeSums sums;
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = model.rotor_places[i].x(), y = model.rotor_places[i].y();
    sums.s += speed[i];
    sums.x += speed[i] * x;
    sums.y += speed[i] * y;
    sums.xx += speed[i] * x * x;
    sums.xy += speed[i] * x * y;
    sums.yy += speed[i] * y * y;
  }
  return sums;
}

/// What is around the body and does not change within a substep.
struct Surroundings {
  Vec3d wind_W = Vec3d::Zero();
  BladeSums blades;
  double spin = 0.0;       // [N·m·s], angular momentum of the rotors along body up
  double spin_rate = 0.0;  // [N·m], its change
  bool near_ground = false;
};

/// Cheeseman and Bennett: a rotor this high above the ground gives 1 / (1 - (R / 4h)²) times its thrust; less what is
/// left of that at five radii, where the effect ends, and no closer than half a radius.
inline double ground_effect(double radius, double height) {
  const double ratio = radius / (4.0 * std::max(height, 0.5 * radius)), excess = ratio * ratio - 1.0 / 400.0;
  return excess > 0.0 ? 1.0 / (1.0 - excess) : 1.0;
}

struct BodyFrameLoad {
  Vec3d force_B, torque_B;
};

/// Blades in moving air: a rotor loses thrust to air along its axis and is pushed by air across it; air as it passes
/// each hub, (air_B + w x place). Summed over the hubs.
inline BodyFrameLoad blade_air_load(const Plant& plant, const BladeSums& b, const Vec3d& air_B, const Vec3d& w) {
  const double k = plant.rotor_inflow_N_s_m, d = plant.rotor_drag_N_s_m;
  BodyFrameLoad load;
  load.force_B = {-d * (b.s * air_B.x() - b.y * w.z()), -d * (b.s * air_B.y() + b.x * w.z()),
                  -k * (b.s * air_B.z() + b.y * w.x() - b.x * w.y())};
  load.torque_B = {-k * (b.y * air_B.z() + b.yy * w.x() - b.xy * w.y()),
                   k * (b.x * air_B.z() + b.xy * w.x() - b.xx * w.y()),
                   d * (b.y * air_B.x() - b.x * air_B.y() - (b.xx + b.yy) * w.z())};
  return load;
}

/// Whether rotors and plain drag are all there is, as in most of a flight.
inline bool only_rotors_and_drag(const Model& model, const Surroundings& around) {
  return !around.near_ground && !model.air_moves_blades && model.spin <= 0.0 && !model.scenario.effects.ground_effect &&
         model.plant.drag_N_s2_m2 <= 0.0;
}

/// All but gravity, where only_rotors_and_drag; the same bits as felt_load.
inline Load plain_load(const Model& model, const Surroundings& around, const BodyLoad& rotors, const RigidBody& body) {
  Load sum = {rotors.thrust * up_axis(body.q_WB), rotors.torque_B};
  if (model.plant.drag_N_s_m > 0.0) sum.force_W -= model.plant.drag_N_s_m * (body.v_WB - around.wind_W);
  return sum;
}

/// All but gravity. `rotors` is what the rotors give in still air, away from the ground.
inline Load felt_load(const Model& model, const Surroundings& around, const Contact& contact, const BodyLoad& rotors,
                      const RigidBody& body) {
  const Plant& plant = model.plant;
  const Vec3d up_W = up_axis(body.q_WB);
  Load sum;
  double thrust = rotors.thrust;
  sum.torque_B = rotors.torque_B;
  const double height = body.p_WB.z() - model.ground;
  if (model.scenario.effects.ground_effect && height < 5.0 * plant.rotor_radius && thrust > 0.0 && up_W.z() > 0.0) {
    const double gain = ground_effect(plant.rotor_radius, height);
    const double share = 1.0 + (gain - 1.0) * up_W.z();
    thrust *= share;
    sum.torque_B *= share;
  }
  sum.force_W = thrust * up_W;
  if (plant.drag_N_s_m > 0.0 || plant.drag_N_s2_m2 > 0.0 || model.air_moves_blades) {
    const Vec3d air_W = body.v_WB - around.wind_W;
    sum.force_W -= plant.drag_N_s_m * air_W;
    if (plant.drag_N_s2_m2 > 0.0) sum.force_W -= plant.drag_N_s2_m2 * air_W.norm() * air_W;
    if (model.air_moves_blades) {
      const Eigen::Matrix3d R_WB = rotation(body.q_WB);
      const auto [force_B, torque_B] = blade_air_load(plant, around.blades, R_WB.transpose() * air_W, body.w_WB_B);
      sum.force_W += R_WB * force_B;
      sum.torque_B += torque_B;
    }
  }
  if (model.spin > 0.0) {  // -w x h - dh/dt
    const Vec3d& w = body.w_WB_B;
    sum.torque_B += Vec3d(-w.y() * around.spin, w.x() * around.spin, -around.spin_rate);
  }
  if (around.near_ground) {
    const Load ground = ground_load(plant, contact, body);
    sum.force_W += ground.force_W;
    sum.torque_B += ground.torque_B;
  }
  return sum;
}

}  // namespace halfroll::sim
