#include "core/manoeuvre.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "core/quaternion.hpp"

namespace halfroll {
namespace {

constexpr float kTurn = 6.2831853F;
constexpr float kPeakRate = 1.875F;           // of the quintic: rate, in angle / duration
constexpr float kPeakAcceleration = 5.7735F;  //                 angular acceleration, in angle / duration²
constexpr float kTorqueShare = 0.5F;          // of what one pair of rotors gives around hover
constexpr float kThrustShare = 0.9F;          // of the greatest thrust, the rest turns the body
constexpr float kLiftGain = 4.F;              // makes the mean of c² (1 + k s²) one
constexpr float kOffCourse = 0.5F;            // cosine
constexpr float kFeedback = 0.6F * kGravity;  // [m/s²], most correction towards the start

}  // namespace

float Manoeuvre::duration(float turns, const Vehicle& vehicle, const Params& params) {
  const float angle = std::abs(turns) * kTurn;
  const float hover = 0.25F * vehicle.mass * kGravity;
  const float torque = kTorqueShare * 2.F * vehicle.arm * (vehicle.thrust_max - hover);
  const float acceleration = torque / std::max(vehicle.inertia.x(), vehicle.inertia.y());
  return std::max(kPeakRate * angle / params.flip_rate, std::sqrt(kPeakAcceleration * angle / acceleration));
}

void Manoeuvre::start(const Quat& q_WB, const Vec3& position, BodyAxis axis, float turns, const Vehicle& vehicle,
                      const Params& params) {
  *this = Manoeuvre{};
  active_ = true;
  q_start_ = q_WB;
  start_ = position;
  axis_ = axis == BodyAxis::kRoll ? Vec3(Vec3::UnitX()) : Vec3(-Vec3::UnitY());  // nose up is about -y
  angle_ = turns * kTurn;
  duration_ = duration(turns, vehicle, params);
}

Setpoint Manoeuvre::step(const Estimate& estimate, std::uint64_t t_us, const Vehicle& vehicle, const Params& params) {
  elapsed_ = std::min(elapsed_ + kReferenceDt, duration_);
  active_ = elapsed_ < duration_;
  const float s = elapsed_ / duration_, r = 1.F - s;
  const float angle = angle_ * s * s * s * (10.F + s * (6.F * s - 15.F));
  const float rate = angle_ * 30.F * s * s * r * r / duration_;
  const float acceleration = angle_ * 60.F * s * r * (1.F - 2.F * s) / (duration_ * duration_);

  Setpoint setpoint;
  setpoint.t_us = t_us;
  setpoint.q_WD = normalised(q_start_ * from_rotation_vector(angle * axis_));
  setpoint.w_WD_D = rate * axis_;
  setpoint.dw_WD_D = acceleration * axis_;

  // Thrust is taken where the body will be when the rotors give it; what lies along it of the way back is added.
  const Vec3 led = up_axis(setpoint.q_WD * from_rotation_vector(params.actuator_lead * setpoint.w_WD_D));
  const float c = led.z();
  const Vec3 kp(params.pos_kp_xy, params.pos_kp_xy, params.pos_kp_z);
  const Vec3 kd(params.pos_kd_xy, params.pos_kd_xy, params.pos_kd_z);
  const Vec3 back = -kp.cwiseProduct(estimate.p_WB - start_) - kd.cwiseProduct(estimate.v_WB);
  const float size = back.norm();
  const Vec3 correction = size > kFeedback ? Vec3(back * (kFeedback / size)) : back;
  const float thrust = vehicle.mass * (kGravity * c * (1.F + kLiftGain * (1.F - c * c)) + correction.dot(led));
  const float most = kThrustShare * 4.F * vehicle.thrust_max;
  setpoint.thrust = std::clamp(thrust, -most, most);

  on_course_ = up_axis(setpoint.q_WD).dot(up_axis(estimate.q_WB)) > kOffCourse;
  return setpoint;
}

}  // namespace halfroll
