// What the vehicle and the laboratory measure. Why: the autopilot never sees the truth, and what it sees of the
// motion capture is already old. Each sensor draws from streams of its own (random.hpp).
#pragma once
#include "core/types.hpp"
#include "sim/on_the_way.hpp"
#include "sim/random.hpp"
#include "sim/rigid_body.hpp"
#include "sim/rotors.hpp"
#include "sim/scenario.hpp"

namespace halfroll::sim {

/// Memory of the sensors: biases, slow errors, samples on the way.
struct Sensors {
  Vec3d gyro_bias = Vec3d::Zero();              // [rad/s]
  Vec3d accelerometer_bias = Vec3d::Zero();     // [m/s²]
  PerRotor rotor_angle = {0.0, 0.0, 0.0, 0.0};  // [rad], for vibration

  Vec3d attitude_wander = Vec3d::Zero();  // [rad], motion capture
  PoseFix last_pose;
  OnTheWay<PoseFix, 16> poses;

  Vec3d gps_wander = Vec3d::Zero();  // [m]
  OnTheWay<GpsFix, 8> fixes;
  double barometer_drift = 0.0;             // [m]
  Vec3d magnetometer_bias = Vec3d::Zero();  // share of the field
};

/// What is true of the frame, whose middle is where the sensors sit, at t_us.
struct Truth {
  std::uint64_t t_us = 0;
  Vec3d p_W = Vec3d::Zero(), v_W = Vec3d::Zero();
  Eigen::Vector4d q_WB = {1.0, 0.0, 0.0, 0.0};
  Vec3d w_B = Vec3d::Zero();
  Vec3d specific_force_B = Vec3d::Zero();
  PerRotor rotor_speed_rad_s = {0.0, 0.0, 0.0, 0.0};
  double nominal_rotor_speed_rad_s = 0.0;
};

/// Sensors at switch-on.
Sensors make_sensors(const Scenario& scenario, const Random& random);

/// Read gyro and accelerometer now, take what else is due, deliver what is old enough.
Measurements read(const Scenario& scenario, const Random& random, Sensors& sensors, const Truth& truth);

/// The earth's field in W, as a unit vector: north and down, 63 degrees steep, no declination.
Vec3d magnetic_field_W();

}  // namespace halfroll::sim
