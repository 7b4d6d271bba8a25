// How kind the world is: air, sensors, loads, faults. Why: the same flight is flown in a perfect world to see the
// method, and in worse ones to see what it is worth. scenarios/*.toml are the only place of these numbers.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "sim/plant.hpp"

namespace halfroll::sim {

inline constexpr double kDegree = 3.14159265358979323846 / 180.0;
inline constexpr double kForever = std::numeric_limits<double>::infinity();

/// Which effects of the vehicle are on.
struct Effects {
  bool drag = false;             // of the body
  bool rotor_drag = false;       // of blades in air that comes from the side
  bool inflow = false;           // thrust lost to air along the axis
  bool gyroscopic = false;       // angular momentum of the rotors
  bool ground_effect = false;    // more thrust close to the ground
  bool governor = false;         // variable pitch: speed droops under load
  bool stiction = false;         // of the pitch servos
  bool battery = false;          // sags and empties
  bool physical_torque = false;  // drag torque keeps its sign when thrust changes its own; else the paper's c f
};

/// Something small hung onto the vehicle that its autopilot does not know of.
struct Payload {
  double mass = 0.0;               // [kg]
  Vec3d position = Vec3d::Zero();  // [m], body axes, from the vehicle's own centre of mass
};

/// A gust: rises as (1 - cos) / 2, stays, falls the same way.
struct Gust {
  double at_s = 0.0, rise_s = 1.0, hold_s = 0.0;
  Vec3d velocity = Vec3d::Zero();  // [m/s], W
};

struct WindSetup {
  static constexpr std::size_t kGusts = 4;
  Vec3d mean = Vec3d::Zero();             // [m/s], W, where the air goes
  Vec3d intensity = Vec3d::Zero();        // [m/s], turbulence along the mean, across it, vertical
  Vec3d length = Vec3d::Constant(100.0);  // [m], Dryden scales of the same
  double speed = 0.0;                     // [m/s] at which turbulence is carried past; 0: the mean's
  std::array<Gust, kGusts> gusts = {};    // velocity 0: none
};

/// One axis of an inertial sensor, in its unit. Standard deviations.
struct InertialErrors {
  double noise = 0.0;      // of each sample
  double bias = 0.0;       // at switch-on
  double bias_walk = 0.0;  // per square root of a second
  double range = 0.0;      // largest reading; 0: no limit
  double step = 0.0;       // of the converter; 0: none
  double vibration = 0.0;  // amplitude from each rotor at nominal speed
};

struct MocapSetup {
  std::uint64_t period_us = 10000;  // whole milliseconds; 0: there is none
  std::uint64_t delay_us = 0;       // from exposure to delivery
  std::uint64_t jitter_us = 0;      // up to so much more, uniform
  double position_noise = 0.0;      // [m]
  double attitude_noise = 0.0;      // [rad], white
  double attitude_wander = 0.0;     // [rad], slow
  double wander_time = 0.5;         // [s], correlation time of the slow part
  double dropout = 0.0;             // share of poses that never arrive
  double outlier = 0.0;             // share of poses that are wrong
  double outlier_size = 1.0;        // [m], and [rad], standard deviation of a wrong one
};

struct GpsSetup {
  std::uint64_t period_us = 0;  // 0: there is none
  std::uint64_t delay_us = 0;
  double noise_xy = 0.0, noise_z = 0.0;    // [m], white
  double wander_xy = 0.0, wander_z = 0.0;  // [m], slow
  double wander_time = 60.0;               // [s]
  double velocity_noise = 0.0;             // [m/s]
};

struct BarometerSetup {
  std::uint64_t period_us = 0;  // 0: there is none
  double noise = 0.0;           // [m]
  double drift = 0.0;           // [m] per square root of a second
};

struct MagnetometerSetup {
  std::uint64_t period_us = 0;  // 0: there is none
  double noise = 0.0;           // share of the field
  double bias = 0.0;            // share of the field, each axis, at switch-on
};

/// What goes wrong, when.
struct Fault {
  enum class Kind : std::uint8_t {
    kNone = 0,
    kWeakRotor = 1,    // gives `share` of its thrust
    kStuckRotor = 2,   // blades (variable pitch) or speed (fixed pitch) stay as they are
    kDeadRotor = 3,    // motor off
    kMocapLost = 4,    // nothing comes
    kMocapFrozen = 5,  // the last pose comes again and again, with fresh stamps
    kGpsLost = 6,
  };
  Kind kind = Kind::kNone;
  double at_s = 0.0, until_s = kForever;
  std::size_t rotor = 0;  // 0..3
  double share = 1.0;

  bool active(double t_s) const { return t_s >= at_s && t_s < until_s; }
};

/// The default is the perfect world, `ideal`. Standard deviations are per axis and sample.
struct Scenario {
  static constexpr std::size_t kFaults = 8;
  Effects effects;
  Payload payload;
  WindSetup wind;
  InertialErrors gyro;           // [rad/s]
  InertialErrors accelerometer;  // [m/s²]
  MocapSetup mocap;
  GpsSetup gps;
  BarometerSetup barometer;
  MagnetometerSetup magnetometer;
  std::array<Fault, kFaults> faults = {};
};

}  // namespace halfroll::sim
