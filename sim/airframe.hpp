// What pushes the body: rotors, air, ground. Why: one sum, used by the integrator sixteen times a millisecond and by
// the accelerometer once, which feels all of it but gravity.
#pragma once
#include "sim/contact.hpp"
#include "sim/model.hpp"

namespace halfroll::sim {

/// Forces and torques of the air, linear in airspeed and body rate: coefficients in body axes. Blades lose thrust to
/// air along their axis and are pushed by air across it, air as it passes each hub, (air_B + w x place), summed over
/// the hubs.
struct AirCoefficients {
  double across = 0.0, along = 0.0;                             // [N·s/m], force per airspeed; of the body, too
  double across_x = 0.0, across_y = 0.0, across_turning = 0.0;  // of blades, times the hub's place
  double along_x = 0.0, along_y = 0.0;                          // likewise
  double along_xx = 0.0, along_xy = 0.0, along_yy = 0.0;        // and times it once more
};

inline AirCoefficients air_coefficients(const Model& model, const PerRotor& speed) {
  AirCoefficients air;
  air.across = air.along = model.plant.drag_N_s_m;
  if (!model.air_moves_blades) return air;
  const double k = model.plant.rotor_inflow_N_s_m, d = model.plant.rotor_drag_N_s_m;
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = model.rotor_places[i].x(), y = model.rotor_places[i].y();
    const double across = d * speed[i], along = k * speed[i], along_x = along * x, along_y = along * y;
    air.across += across;
    air.across_x += across * x;
    air.across_y += across * y;
    air.across_turning += across * (x * x + y * y);
    air.along += along;
    air.along_x += along_x;
    air.along_y += along_y;
    air.along_xx += along_x * x;
    air.along_xy += along_x * y;
    air.along_yy += along_y * y;
  }
  return air;
}

/// What is around the body and does not change within a substep.
struct Surroundings {
  Vec3d wind_W = Vec3d::Zero();
  AirCoefficients air;
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

/// Whether rotors and plain drag are all there is, as in most of a flight.
inline bool only_rotors_and_drag(const Model& model, const Surroundings& around) {
  return !around.near_ground && !model.air_moves_blades && model.spin <= 0.0 && !model.scenario.effects.ground_effect &&
         model.plant.drag_N_s2_m2 <= 0.0;
}

/// All but gravity, where only_rotors_and_drag.
inline Load plain_load(const Model& model, const Surroundings& around, const BodyLoad& rotors, const RigidBody& body) {
  Load sum = {rotors.thrust * up_axis(body.q_WB), rotors.torque_B};
  if (model.plant.drag_N_s_m > 0.0) sum.force_W -= model.plant.drag_N_s_m * (body.v_WB - around.wind_W);
  return sum;
}

/// All but gravity. `rotors` is what the rotors give in still air, away from the ground.
inline Load felt_load(const Model& model, const Surroundings& around, const Contact& contact, const BodyLoad& rotors,
                      const RigidBody& body) {
  const Plant& plant = model.plant;
  const Eigen::Matrix3d R_WB = rotation(body.q_WB);
  const Vec3d& w = body.w_WB_B;
  Load sum;
  sum.torque_B = rotors.torque_B;
  double thrust = rotors.thrust;
  const double height = body.p_WB.z() - model.ground;
  if (model.scenario.effects.ground_effect && height < 5.0 * plant.rotor_radius && thrust > 0.0 && R_WB(2, 2) > 0.0) {
    const double gain = ground_effect(plant.rotor_radius, height);
    const double share = 1.0 + (gain - 1.0) * R_WB(2, 2);
    thrust *= share;
    sum.torque_B *= share;
  }
  const AirCoefficients& air = around.air;
  Vec3d force_B(0.0, 0.0, thrust);
  if (air.across > 0.0 || air.along > 0.0 || plant.drag_N_s2_m2 > 0.0) {
    const Vec3d a = R_WB.transpose() * (body.v_WB - around.wind_W);
    force_B -= Vec3d(air.across * a.x() - air.across_y * w.z(), air.across * a.y() + air.across_x * w.z(),
                     air.along * a.z() + air.along_y * w.x() - air.along_x * w.y());
    sum.torque_B += Vec3d(air.along_xy * w.y() - air.along_y * a.z() - air.along_yy * w.x(),
                          air.along_x * a.z() + air.along_xy * w.x() - air.along_xx * w.y(),
                          air.across_y * a.x() - air.across_x * a.y() - air.across_turning * w.z());
    if (plant.drag_N_s2_m2 > 0.0) force_B -= plant.drag_N_s2_m2 * a.norm() * a;
  }
  sum.force_W = R_WB * force_B;
  // -w x h - dh/dt
  if (model.spin > 0.0) sum.torque_B += Vec3d(-w.y() * around.spin, w.x() * around.spin, -around.spin_rate);
  if (around.near_ground) {
    const Load ground = ground_load(plant, contact, body);
    sum.force_W += ground.force_W;
    sum.torque_B += ground.torque_B;
  }
  return sum;
}

}  // namespace halfroll::sim
