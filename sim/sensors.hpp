// What the vehicle and the laboratory measure. Why: the autopilot never sees the truth, and what it sees of the
// motion capture is already old.
#pragma once
#include <array>
#include <cstddef>

#include "core/types.hpp"
#include "sim/noise.hpp"
#include "sim/rigid_body.hpp"
#include "sim/scenario.hpp"

namespace halfroll::sim {

/// Memory of the sensors: the random stream, the slow attitude error, poses taken but not yet delivered.
struct Sensors {
  static constexpr std::size_t kOnTheWay = 8;
  Noise noise;
  Vec3d attitude_wander = Vec3d::Zero();      // [rad]
  std::array<PoseFix, kOnTheWay> poses = {};  // ring
  std::size_t taken = 0, delivered = 0;
};

/// Sensors of a flight with this seed.
Sensors make_sensors(const Scenario& scenario, std::uint64_t seed);

/// Read gyro and accelerometer now, take a pose if one is due, deliver one that is old enough.
Measurements read(const Scenario& scenario, Sensors& sensors, std::uint64_t t_us, const RigidBody& body,
                  const Vec3d& specific_force_B);

}  // namespace halfroll::sim
