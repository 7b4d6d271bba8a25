// What pushes the body: rotors, air, ground. Why: one sum, used by the integrator sixteen times a millisecond and by
// the accelerometer once, which feels all of it but gravity.
#pragma once
#include "sim/contact.hpp"
#include "sim/model.hpp"

namespace halfroll::sim {

/// What is around the body and does not change within a substep.
struct Surroundings {
  Vec3d wind_W = Vec3d::Zero();
  PerRotor rotor_speed = {0.0, 0.0, 0.0, 0.0};  // share of nominal
  double spin = 0.0;                            // [N·m·s], angular momentum of the rotors along body up
  double spin_rate = 0.0;                       // [N·m], its change
  bool near_ground = false;
};

/// Cheeseman and Bennett: a rotor this high above the ground gives 1 / (1 - (R / 4h)²) times its thrust; less what is
/// left of that at five radii, where the effect ends, and no closer than half a radius.
inline double ground_effect(double radius, double height) {
  const double ratio = radius / (4.0 * std::max(height, 0.5 * radius)), excess = ratio * ratio - 1.0 / 400.0;
  return excess > 0.0 ? 1.0 / (1.0 - excess) : 1.0;
}

/// Blades in moving air: thrust lost to air along the axis, force along air across it; both seen at each hub.
inline void add_blade_air(const Model& model, const Surroundings& around, const Vec3d& air_B, const Vec3d& w_B,
                          Vec3d& force_B, Vec3d& torque_B) {
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = model.rotor_places[i].x(), y = model.rotor_places[i].y(), speed = around.rotor_speed[i];
    const double lost = model.plant.rotor_inflow_N_s_m * speed * (air_B.z() + w_B.x() * y - w_B.y() * x);
    const double drag = model.plant.rotor_drag_N_s_m * speed;
    const double fx = -drag * (air_B.x() - w_B.z() * y), fy = -drag * (air_B.y() + w_B.z() * x);
    force_B += Vec3d(fx, fy, -lost);
    torque_B += Vec3d(-y * lost, x * lost, x * fy - y * fx);
  }
}

/// All but gravity. `rotors` is what the rotors give in still air, away from the ground.
inline Load felt_load(const Model& model, const Surroundings& around, const Contact& contact, const BodyLoad& rotors,
                      const RigidBody& body) {
  const Plant& plant = model.plant;
  const Vec3d up_W = up_axis(body.q_WB);
  Load sum;
  double thrust = rotors.thrust;
  sum.torque_B = rotors.torque_B;
  if (model.scenario.effects.ground_effect && thrust > 0.0 && up_W.z() > 0.0) {
    const double gain = ground_effect(plant.rotor_radius, body.p_WB.z() - ground_z(plant));
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
      Vec3d force_B = Vec3d::Zero();
      add_blade_air(model, around, R_WB.transpose() * air_W, body.w_WB_B, force_B, sum.torque_B);
      sum.force_W += R_WB * force_B;
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
