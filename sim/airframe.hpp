// What pushes the body: rotors, air, ground. Why: one sum, used by the integrator sixteen times a millisecond and by
// the accelerometer once, which feels all of it but gravity.
#pragma once
#include "sim/contact.hpp"
#include "sim/model.hpp"

namespace halfroll::sim {

/// What is around the body and does not change within a substep.
struct Surroundings {
  Vec3d wind_W = Vec3d::Zero();
  AirCoefficients air;
  double spin = 0.0;       // [N·m·s], angular momentum of the rotors along body up
  double spin_rate = 0.0;  // [N·m], its change
  bool near_ground = false;
};

/// Of the body and of rotors at these shares of their nominal speed.
inline AirCoefficients air_coefficients(const Model& model, const PerRotor& speed) {
  AirCoefficients air = model.body_air;
  if (!model.air_moves_blades) return air;
  for (std::size_t i = 0; i < 4; ++i) air.add(model.rotor_air[i], speed[i]);
  return air;
}

/// Cheeseman and Bennett: a rotor this high above the ground gives 1 / (1 - (R / 4h)²) times its thrust; less what is
/// left of that at five radii, where the effect ends, and no closer than half a radius.
inline double ground_effect(double radius, double height) {
  const double ratio = radius / (4.0 * std::max(height, 0.5 * radius)), excess = ratio * ratio - 1.0 / 400.0;
  return excess > 0.0 ? 1.0 / (1.0 - excess) : 1.0;
}

/// What rotors give close to the ground that give `rotors` away from it.
inline BodyLoad above_ground(const Model& model, const BodyLoad& rotors, const RigidBody& body) {
  const double height = body.p_WB.z() - model.ground, upward = up_axis(body.q_WB).z();
  if (!model.scenario.effects.ground_effect || !(rotors.thrust > 0.0 && upward > 0.0)) return rotors;
  const double share = 1.0 + (ground_effect(model.plant.rotor_radius, height) - 1.0) * upward;
  return {share * rotors.thrust, share * rotors.torque_B};
}

/// All but gravity, of rotors and plain drag, which are all there is in most flights (Model::plain) off the ground.
inline Load plain_load(const Model& model, const Surroundings& around, const BodyLoad& rotors, const RigidBody& body) {
  Load sum = {rotors.thrust * up_axis(body.q_WB), rotors.torque_B};
  if (model.plant.drag_N_s_m > 0.0) sum.force_W -= model.plant.drag_N_s_m * (body.v_WB - around.wind_W);
  return sum;
}

/// All but gravity, away from the ground. `rotors` is what the rotors give in still air.
inline Load airborne_load(const Model& model, const Surroundings& around, const BodyLoad& rotors,
                          const RigidBody& body) {
  const AirCoefficients& air = around.air;
  const Eigen::Matrix3d R_WB = rotation(body.q_WB);
  const Vec3d& w = body.w_WB_B;
  const Vec3d a = R_WB.transpose() * (body.v_WB - around.wind_W);
  Vec3d force_B(air.across_y * w.z() - air.across * a.x(), -air.across * a.y() - air.across_x * w.z(),
                rotors.thrust - air.along * a.z() - air.along_y * w.x() + air.along_x * w.y());
  if (model.plant.drag_N_s2_m2 > 0.0) force_B -= model.plant.drag_N_s2_m2 * a.norm() * a;
  const Vec3d of_air(air.along_xy * w.y() - air.along_y * a.z() - air.along_yy * w.x(),
                     air.along_x * a.z() + air.along_xy * w.x() - air.along_xx * w.y(),
                     air.across_y * a.x() - air.across_x * a.y() - air.across_turning * w.z());
  const Vec3d of_spin(-w.y() * around.spin, w.x() * around.spin, -around.spin_rate);  // -w x h - dh/dt
  return {R_WB * force_B, rotors.torque_B + of_air + of_spin};
}

/// All but gravity, anywhere. `rotors` is what the rotors give in still air, away from the ground.
inline Load felt_load(const Model& model, const Surroundings& around, const Contact& contact, const BodyLoad& rotors,
                      const RigidBody& body) {
  if (!around.near_ground) return airborne_load(model, around, rotors, body);
  Load sum = airborne_load(model, around, above_ground(model, rotors, body), body);
  const Load ground = ground_load(model.plant, contact, body);
  sum.force_W += ground.force_W;
  sum.torque_B += ground.torque_B;
  return sum;
}

}  // namespace halfroll::sim
