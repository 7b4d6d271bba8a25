// The nouns of the loop. Why: a quantity keeps one name, one frame and one unit from sensor to rotor.
//
// World W: north-west-up, origin at the local origin. Body B: forward-left-up. Desired body D.
// q_WB takes body vectors to world. SI and radians throughout; thrust is signed along body +z.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <tuple>

namespace halfroll {

using Vec3 = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3f;

/// Hamilton unit quaternion [w, x, y, z]; q and -q are one attitude.
struct Quat {
  float w = 1.F, x = 0.F, y = 0.F, z = 0.F;
  auto state() const { return std::tie(w, x, y, z); }
  bool operator==(const Quat& o) const { return state() == o.state(); }
};

/// One sample of the inertial sensors.
struct Imu {
  Vec3 w_WB_B = Vec3::Zero();            // [rad/s]
  Vec3 specific_force_B = Vec3::Zero();  // [m/s²], what an accelerometer shows: +g along up at rest
  auto state() const { return std::tie(w_WB_B, specific_force_B); }
  bool operator==(const Imu& o) const { return state() == o.state(); }
};

/// Whether a sensor can have said so: none measures beyond, and what is squared on the way stays finite.
inline bool is_plausible(const Imu& imu) {
  constexpr float kRateMost = 1e3F, kForceMost = 1e4F;  // [rad/s], [m/s²]
  return (imu.w_WB_B.array().abs() <= kRateMost).all() && (imu.specific_force_B.array().abs() <= kForceMost).all();
}

// What comes besides was taken at t_us and is usually delivered later. A deviation is one sigma per axis; 0 says that
// the sensor does not know it, and a parameter stands in.

/// A pose from outside: motion capture on board the loop, or by link.
struct PoseFix {
  std::uint64_t t_us = 0;
  Vec3 p_WB = Vec3::Zero();
  Quat q_WB;
  Vec3 position_deviation = Vec3::Zero();  // [m], along W
  Vec3 attitude_deviation = Vec3::Zero();  // [rad], about W
  std::uint8_t resets = 0;                 // of the source's own origin, counted by the source
  auto state() const { return std::tie(t_us, p_WB, q_WB, position_deviation, attitude_deviation, resets); }
  bool operator==(const PoseFix& o) const { return state() == o.state(); }
};

/// A satellite fix, already in W.
struct GpsFix {
  std::uint64_t t_us = 0;
  Vec3 p_WB = Vec3::Zero();
  Vec3 v_WB = Vec3::Zero();
  float horizontal_deviation = 0.F;  // [m]
  float vertical_deviation = 0.F;    // [m]
  float speed_deviation = 0.F;       // [m/s]
  auto state() const { return std::tie(t_us, p_WB, v_WB, horizontal_deviation, vertical_deviation, speed_deviation); }
  bool operator==(const GpsFix& o) const { return state() == o.state(); }
};

/// Height by pressure: right up to an offset that wanders slowly with the weather.
struct BarometerSample {
  std::uint64_t t_us = 0;
  float height = 0.F;  // [m] above the local origin
  auto state() const { return std::tie(t_us, height); }
  bool operator==(const BarometerSample& o) const { return state() == o.state(); }
};

/// The earth's field, in any unit: only its direction counts.
struct MagnetometerSample {
  std::uint64_t t_us = 0;
  Vec3 field_B = Vec3::Zero();
  auto state() const { return std::tie(t_us, field_B); }
  bool operator==(const MagnetometerSample& o) const { return state() == o.state(); }
};

/// All that the sensors say in one millisecond.
struct Measurements {
  Imu imu;
  std::optional<PoseFix> pose;
  std::optional<GpsFix> gps;
  std::optional<BarometerSample> barometer;
  std::optional<MagnetometerSample> magnetometer;
};

/// What keeps the estimate from drifting.
enum class Aiding : std::uint8_t { kNone, kPose, kSatellites };

/// What the estimator believes now.
struct Estimate {
  Quat q_WB;
  Vec3 w_WB_B = Vec3::Zero();  // gyro minus bias
  Vec3 p_WB = Vec3::Zero();
  Vec3 v_WB = Vec3::Zero();
  bool attitude_valid = false;
  bool position_valid = false;
  Aiding aiding = Aiding::kNone;   // kNone: dead reckoning, or nothing yet
  std::uint8_t resets = 0;         // jumps of the position: counts up, for those who hold one
  float attitude_deviation = 0.F;  // [rad], one sigma along the worst axis
  float velocity_deviation = 0.F;  // [m/s]
  float position_deviation = 0.F;  // [m]
};

/// A point of a trajectory: what to fly, before the outer loop.
struct FlatReference {
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  Vec3 acceleration = Vec3::Zero();
  Vec3 jerk = Vec3::Zero();
  Vec3 snap = Vec3::Zero();
  float yaw = 0.F, yaw_rate = 0.F, yaw_acceleration = 0.F;
};

/// Attitude, rates and signed thrust wanted at t_us. Made by the outer loop, on board or on the ground.
struct Setpoint {
  std::uint64_t t_us = 0;
  Quat q_WD;
  Vec3 w_WD_D = Vec3::Zero();   // [rad/s]
  Vec3 dw_WD_D = Vec3::Zero();  // [rad/s²]; zero for what comes by link
  float thrust = 0.F;           // [N], signed, along body up of D
  bool attitude_used = true;    // false: rates and thrust only (type_mask 128)
  std::array<bool, 3> rate_used = {true, true, true};
};

/// A setpoint brought to this millisecond: what the attitude loop tracks.
struct Reference {
  Quat q_WD;
  Vec3 w_WD_D = Vec3::Zero();
  Vec3 dw_WD_D = Vec3::Zero();
  float thrust = 0.F;  // [N], along the actual body up (already projected, Eq 14)
};

/// Force and torque wanted of the rotors together.
struct Wrench {
  float thrust = 0.F;          // [N]
  Vec3 torque = Vec3::Zero();  // [N·m], body axes
};

/// Thrust of each rotor [N]; rotor 1 sits on +y (left), 2 on -x (rear), 3 on -y (right), 4 on +x (front).
struct RotorCommands {
  std::array<float, 4> thrust = {0.F, 0.F, 0.F, 0.F};
  auto state() const { return std::tie(thrust); }
  bool operator==(const RotorCommands& o) const { return thrust == o.thrust; }
};

/// Which part of a wrench the limits have cut.
struct Saturation {
  bool tilt = false, thrust = false, yaw = false;
};

}  // namespace halfroll
