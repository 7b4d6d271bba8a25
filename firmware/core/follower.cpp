#include "core/follower.hpp"

#include <algorithm>
#include <cmath>

#include "core/trig.hpp"

namespace halfroll {
namespace {

// Cascade position -> velocity -> acceleration -> jerk. Unlimited, its poles are -2, -2, -4 rad/s: no overshoot.
constexpr float kPositionGain = 0.8F;     // [1/s]
constexpr float kVelocityGain = 2.5F;     // [1/s]
constexpr float kAccelerationGain = 8.F;  // [1/s]
constexpr float kBrakeShare = 0.5F;       // of the acceleration limit, planned for stopping; the rest is for jerk
constexpr float kRecoveryVelocity = 0.75F, kRecoveryAcceleration = 3.75F;  // of the attitude loop's natural frequency
constexpr float kAnyJerk = 1e9F;
constexpr float kRestSpeed = 0.05F;        // [m/s]
constexpr float kRestAcceleration = 0.2F;  // [m/s²]
constexpr float kYawGain = 2.F;            // [1/s]
constexpr float kYawRateMax = 1.F;         // [rad/s]

/// The vector shortened to at most `limit`.
template <class V>
V limited(const V& v, float limit) {
  const float size = v.norm();
  return size > limit ? V(v * (limit / size)) : v;
}

struct Limits {
  float speed, acceleration, jerk;
};

/// One step of the cascade in one or two dimensions.
template <class V>
void advance(const V& error, V& position, V& velocity, V& acceleration, V& jerk, const Limits& limits, float dt) {
  const float distance = error.norm();
  const float braking = std::sqrt(2.F * kBrakeShare * limits.acceleration * distance);
  const float speed = std::min({limits.speed, kPositionGain * distance, braking});
  const V wanted_velocity = distance > 1e-6F ? V(error * (speed / distance)) : V(V::Zero());
  const V wanted_acceleration = limited(V(kVelocityGain * (wanted_velocity - velocity)), limits.acceleration);
  jerk = limited(V(kAccelerationGain * (wanted_acceleration - acceleration)), limits.jerk);
  acceleration += jerk * dt;
  velocity += acceleration * dt;
  position += velocity * dt;
}

}  // namespace

void Follower::start(const Vec3& position, const Vec3& velocity, float yaw) {
  reference_ = FlatReference{};
  reference_.position = position;
  reference_.velocity = velocity;
  reference_.yaw = yaw;
}

const FlatReference& Follower::step(const FollowerTarget& target, float dt, const Params& params) {
  using Vec1 = Eigen::Matrix<float, 1, 1>;
  using Vec2 = Eigen::Vector2f;
  FlatReference& r = reference_;
  const Vec3 error = target.position - r.position;

  Vec2 p = r.position.head<2>(), v = r.velocity.head<2>(), a = r.acceleration.head<2>(), j = r.jerk.head<2>();
  advance<Vec2>(error.head<2>(), p, v, a, j, {target.speed_xy, params.acceleration_max, params.jerk_max}, dt);

  Vec1 pz(r.position.z()), vz(r.velocity.z()), az(r.acceleration.z()), jz(r.jerk.z());
  const float speed_z = error.z() >= 0.F ? target.speed_up : target.speed_down;
  advance<Vec1>(Vec1(error.z()), pz, vz, az, jz, {speed_z, params.acceleration_max, params.jerk_max}, dt);

  r.position << p, pz;
  r.velocity << v, vz;
  r.acceleration << a, az;
  r.jerk << j, jz;
  turn(kYawGain * wrapped_angle(target.yaw - r.yaw), dt);
  return r;
}

void Follower::turn(float yaw_rate, float dt) {
  reference_.yaw_rate = std::clamp(yaw_rate, -kYawRateMax, kYawRateMax);
  reference_.yaw = wrapped_angle(reference_.yaw + reference_.yaw_rate * dt);
}

// The same cascade about the setpoint's own motion. An axis without a position follows its speed, one without a speed
// its acceleration: what is missing takes no part.
const FlatReference& Follower::track(const PositionSetpoint& setpoint, float dt, const Params& params) {
  FlatReference& r = reference_;
  const float slowing = kBrakeShare * params.brake_acceleration;
  Vec3 velocity, acceleration = setpoint.acceleration;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    velocity[axis] = setpoint.velocity[axis];
    if (setpoint.position_used[i]) {
      const float error = setpoint.position[axis] - r.position[axis];
      const float speed = std::min(kPositionGain * std::abs(error), std::sqrt(2.F * slowing * std::abs(error)));
      velocity[axis] += std::copysign(speed, error);
    }
  }
  const Eigen::Vector2f level = limited(Eigen::Vector2f(velocity.head<2>()), params.speed_max);
  velocity << level, std::clamp(velocity.z(), -params.descent_speed, params.climb_speed);
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const bool has_speed = setpoint.position_used[i] || setpoint.velocity_used[i];
    if (has_speed) acceleration[axis] += kVelocityGain * (velocity[axis] - r.velocity[axis]);
  }
  const Vec3 wanted = limited(acceleration, params.brake_acceleration);
  r.jerk = limited(Vec3(kAccelerationGain * (wanted - r.acceleration)), params.brake_jerk);
  r.acceleration += r.jerk * dt;
  r.velocity += r.acceleration * dt;
  r.velocity.head<2>() = limited(Eigen::Vector2f(r.velocity.head<2>()), params.speed_max);
  r.velocity.z() = std::clamp(r.velocity.z(), -params.descent_speed, params.climb_speed);
  r.position += r.velocity * dt;
  const float towards = setpoint.yaw_used ? kYawGain * wrapped_angle(setpoint.yaw - r.yaw) : 0.F;
  turn(towards + (setpoint.yaw_rate_used ? setpoint.yaw_rate : 0.F), dt);
  return r;
}

const FlatReference& Follower::brake(float dt, const Params& params) {
  return slow_down(kVelocityGain, kAccelerationGain, params.brake_acceleration, params.brake_jerk, dt);
}

const FlatReference& Follower::recover(float dt, float acceleration, const Params& params) {
  const float wn = params.att_natural_frequency;
  const float acceleration_gain = std::min(kRecoveryAcceleration * wn, 0.6F / dt);  // 1 / dt is there at once
  return slow_down(kRecoveryVelocity * wn, acceleration_gain, acceleration, kAnyJerk, dt);
}

/// Against the velocity, until it is gone.
const FlatReference& Follower::slow_down(float velocity_gain, float acceleration_gain, float acceleration, float jerk,
                                         float dt) {
  FlatReference& r = reference_;
  const Vec3 wanted = limited(Vec3(-velocity_gain * r.velocity), acceleration);
  r.jerk = limited(Vec3(acceleration_gain * (wanted - r.acceleration)), jerk);
  r.acceleration += r.jerk * dt;
  r.velocity += r.acceleration * dt;
  r.position += r.velocity * dt;
  r.yaw_rate = 0.F;
  return r;
}

bool Follower::at_rest() const {
  return reference_.velocity.norm() < kRestSpeed && reference_.acceleration.norm() < kRestAcceleration;
}

}  // namespace halfroll
