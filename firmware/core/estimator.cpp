#include "core/estimator.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "core/quaternion.hpp"

namespace halfroll {
namespace {

constexpr std::uint64_t kValidAfterUs = 100000;
constexpr std::uint64_t kLostAfterUs = 500000;

bool is_finite(const Imu& imu) { return imu.w_WB_B.allFinite() && imu.specific_force_B.allFinite(); }

Vec3 acceleration(const Quat& q_WB, const Imu& imu) {
  return rotate(q_WB, imu.specific_force_B) - Vec3(0.F, 0.F, kGravity);
}

}  // namespace

Estimate Estimator::step(std::uint64_t t_us, const Imu& imu, const std::optional<PoseFix>& pose, const Params& params) {
  if (poses_ > 0 && t_us - last_pose_us_ > kLostAfterUs) poses_ = 0;
  integrate(is_finite(imu) ? imu : imu_);
  history_[t_us / kStepUs % kHistory] = now_;
  if (pose && usable(t_us, *pose)) correct(t_us, *pose, params);

  Estimate estimate;
  estimate.q_WB = now_.q_WB;
  estimate.w_WB_B = imu_.w_WB_B - gyro_bias_;
  estimate.p_WB = now_.p_WB;
  estimate.v_WB = now_.v_WB;
  estimate.attitude_valid = estimate.position_valid = poses_ > 1 && t_us - first_pose_us_ >= kValidAfterUs;
  return estimate;
}

// Trapezoids: both sensors are sampled at the ends of the step.
void Estimator::integrate(const Imu& imu) {
  const Vec3 w = 0.5F * (imu_.w_WB_B + imu.w_WB_B) - gyro_bias_;
  const Quat q_WB = normalised(now_.q_WB * from_rotation_vector(w * kDt));
  if (placed_) {  // without poses this is dead reckoning: invalid, but vertical speed stays good for a while
    const Vec3 a = 0.5F * (acceleration(now_.q_WB, imu_) + acceleration(q_WB, imu));
    now_.p_WB += (now_.v_WB + 0.5F * kDt * a) * kDt;
    now_.v_WB += a * kDt;
  }
  now_.q_WB = q_WB;
  imu_ = imu;
}

bool Estimator::usable(std::uint64_t t_us, const PoseFix& pose) const {
  const float norm2 = dot(pose.q_WB, pose.q_WB);
  const bool sane = pose.p_WB.allFinite() && norm2 > 0.81F && norm2 < 1.21F;  // false for a NaN
  const bool in_time = pose.t_us <= t_us && t_us - pose.t_us <= (kHistory - 2) * kStepUs;
  return sane && in_time && (poses_ == 0 || pose.t_us > last_pose_us_);
}

/// What is believed now of an instant in the history, between its milliseconds.
Estimator::Past Estimator::past(std::uint64_t t_us) const {
  const Past& before = history_[t_us / kStepUs % kHistory];
  const std::uint64_t rest_us = t_us % kStepUs;
  if (rest_us == 0) return before;
  const Past& after = history_[(t_us / kStepUs + 1) % kHistory];
  const float share = static_cast<float>(rest_us) / static_cast<float>(kStepUs);
  Past between;
  between.q_WB = before.q_WB * from_rotation_vector(share * rotation_vector(conj(before.q_WB) * after.q_WB));
  between.p_WB = before.p_WB + share * (after.p_WB - before.p_WB);
  between.v_WB = before.v_WB + share * (after.v_WB - before.v_WB);
  return between;
}

// The innovation is taken where the pose was; the whole believed path is moved by it, so that the next pose, which may
// be of an instant before this correction, does not apply it again. Gains begin as those of a growing memory (1, then
// smaller), so the second pose already gives the velocity, and end as the parameters'.
void Estimator::correct(std::uint64_t t_us, const PoseFix& pose, const Params& params) {
  placed_ = true;
  if (poses_ == 0) first_pose_us_ = t_us;
  const bool tracking = poses_ > 0 && last_pose_us_ >= first_pose_us_;
  poses_ = tracking ? std::min<std::uint32_t>(poses_ + 1, 1000) : 1;
  const auto n = static_cast<float>(poses_);
  const float interval = tracking ? 1e-6F * static_cast<float>(pose.t_us - last_pose_us_) : 1.F;
  const float attitude_gain = std::max(params.est_attitude_gain, 1.F / n);
  const float position_gain = std::max(params.est_position_gain, 2.F * (2.F * n - 1.F) / (n * (n + 1.F)));
  const float velocity_gain = tracking ? std::max(params.est_velocity_gain, 6.F / (n * (n + 1.F) * interval)) : 0.F;
  last_pose_us_ = pose.t_us;

  const Past believed = past(pose.t_us);
  const Vec3 turn = rotation_vector(normalised(pose.q_WB) * conj(believed.q_WB));  // in world axes
  const Quat turned = from_rotation_vector(attitude_gain * turn);
  const Vec3 moved = position_gain * (pose.p_WB - believed.p_WB);
  const Vec3 faster = velocity_gain * (pose.p_WB - believed.p_WB);
  if (tracking) gyro_bias_ -= params.est_gyro_bias_gain * rotate(conj(believed.q_WB), turn);

  for (std::uint64_t k = 0; k < kHistory; ++k) {
    const std::uint64_t age_us = k * kStepUs;
    if (age_us > t_us) break;
    Past& then = history_[(t_us - age_us) / kStepUs % kHistory];
    const float since_pose = 1e-6F * (static_cast<float>(t_us - pose.t_us) - static_cast<float>(age_us));
    then.q_WB = normalised(turned * then.q_WB);
    then.p_WB += moved + faster * since_pose;
    then.v_WB += faster;
  }
  now_ = history_[t_us / kStepUs % kHistory];
}

}  // namespace halfroll
