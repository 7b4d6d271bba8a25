// Where to be, how fast, or how hard to accelerate, axis by axis. Why: what SET_POSITION_TARGET asks for, in W and SI,
// between the link that brings it and the follower that flies it.
#pragma once
#include "core/types.hpp"

namespace halfroll {

struct PositionSetpoint {
  std::uint64_t t_us = 0;                                                              // when it was meant
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), acceleration = Vec3::Zero();  // W
  std::array<bool, 3> position_used = {}, velocity_used = {}, acceleration_used = {};
  float yaw = 0.F, yaw_rate = 0.F;  // W
  bool yaw_used = false, yaw_rate_used = false;

  bool has_velocity() const { return velocity_used[0] || velocity_used[1] || velocity_used[2]; }
  bool has_acceleration() const { return acceleration_used[0] || acceleration_used[1] || acceleration_used[2]; }
  auto state() const {
    return std::tie(t_us, position, velocity, acceleration, position_used, velocity_used, acceleration_used, yaw,
                    yaw_rate, yaw_used, yaw_rate_used);
  }
};

}  // namespace halfroll
