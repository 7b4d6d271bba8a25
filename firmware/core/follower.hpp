// The on-board follower: smooth references towards a target, in O(1) memory. Why: hold, takeoff, land, return and any
// mission must fly without the ground station; slower than its plan, always inside speed, acceleration and jerk limits.
#pragma once
#include "core/params.hpp"
#include "core/position_setpoint.hpp"
#include "core/types.hpp"

namespace halfroll {

struct FollowerTarget {
  Vec3 position = Vec3::Zero();  // W
  float yaw = 0.F;               // W [rad]
  float speed_xy = 5.F;          // [m/s]
  float speed_up = 3.F, speed_down = 3.F;
};

class Follower {
 public:
  /// Continue from a state of motion; the reference starts there.
  void start(const Vec3& position, const Vec3& velocity, float yaw);
  /// Advance the reference by dt towards the target.
  const FlatReference& step(const FollowerTarget& target, float dt, const Params& params);
  /// Advance the reference by dt, coming to rest as soon as the braking limits allow; heading kept.
  const FlatReference& brake(float dt, const Params& params);
  /// The same, as hard as attitude loop and `acceleration` [m/s²] allow: for a vehicle that has lost its way.
  const FlatReference& recover(float dt, float acceleration, const Params& params);
  /// Advance the reference by dt along a setpoint that moves, within MPC_XY_VEL_MAX, the climb and descent speeds and
  /// the limits of braking: who gives speeds or accelerations is answerable for their smoothness.
  const FlatReference& track(const PositionSetpoint& setpoint, float dt, const Params& params);
  const FlatReference& reference() const { return reference_; }
  bool at_rest() const;

  auto state() const {
    return std::tie(reference_.position, reference_.velocity, reference_.acceleration, reference_.jerk, reference_.yaw,
                    reference_.yaw_rate);
  }

 private:
  const FlatReference& slow_down(float velocity_gain, float acceleration_gain, float acceleration, float jerk,
                                 float dt);
  void turn(float yaw_rate, float dt);

  FlatReference reference_;
};

}  // namespace halfroll
