#include "core/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/constants.hpp"
#include "core/quaternion.hpp"

namespace halfroll {
namespace {

constexpr std::uint64_t kGrowUs = 10000;              // the covariance follows this often
constexpr std::uint64_t kValidAfterUs = 100000;       // of poses without a gap
constexpr std::uint64_t kPosesLostUs = 500000;        // without a pose that agrees
constexpr std::uint64_t kSatellitesLostUs = 1500000;  // without a fix that agrees
constexpr std::uint64_t kJumpAfterUs = 400000;        // poses contradict, but agree with each other for this long
constexpr std::uint64_t kContradictionGapUs = 200000;
constexpr float kSameShift = 0.1F, kSameTurn = 0.1F;  // [m], [rad], between two contradictions
constexpr float kAttitudeLost = 0.17F;                // [rad], one sigma
constexpr float kNowhere = 100.F;                     // [m], one sigma: dead reckoning has lost it
constexpr float kFirstSpeed = 10.F;                   // [m/s], one sigma, placed by a pose
constexpr float kJumpSpeed = 0.5F;                    // [m/s], one sigma, on top, after a jump
constexpr float kFirstGyroBias = 0.02F;               // [rad/s]
constexpr float kFirstAccelerometerBias = 0.2F;       // [m/s²]
constexpr float kActiveRate = 2e-3F;                  // [rad/s], between two poses: not at rest to the last bit
constexpr float kActiveForce = 0.02F;                 // [m/s²]
constexpr float kFarthest = 1e6F;                     // [m]; beyond a float cannot tell one place from the next

using namespace error_state;

float square(float x) { return x * x; }
Vec3 squares(const Vec3& v) { return v.cwiseProduct(v); }
float seconds(std::uint64_t us) { return 1e-6F * static_cast<float>(us); }

/// The matrix of v -> -w x v.
Mat3 minus_cross_matrix(const Vec3& w) {
  Mat3 m;
  m << 0.F, w.z(), -w.y(), -w.z(), 0.F, w.x(), w.y(), -w.x(), 0.F;
  return m;
}

}  // namespace

bool is_pose(const PoseFix& pose) {
  const float norm2 = dot(pose.q_WB, pose.q_WB);
  return pose.p_WB.allFinite() && pose.p_WB.cwiseAbs().maxCoeff() < kFarthest && norm2 > 0.81F && norm2 < 1.21F;
}

// Turning the present attitude by an error turns what the specific force did since `then`, about now. Process noise and
// bias errors within `age` are left out: at 60 ms a gyro bias of 0.02 rad/s is a milliradian until it is learnt.
Observation<3> late_position(const Motion& then, const Motion& now, float age) {
  const Vec3 back = then.p_WB - now.p_WB + age * now.v_WB + Vec3(0.F, 0.F, 0.5F * kGravity * age * age);
  Observation<3> seen;
  seen.attitude = minus_cross_matrix(back);
  seen.velocity = -age;
  seen.position = 1.F;
  return seen;
}

Observation<3> late_velocity(const Motion& then, const Motion& now, float age) {
  const Vec3 back = then.v_WB - now.v_WB - Vec3(0.F, 0.F, kGravity * age);
  Observation<3> seen;
  seen.attitude = minus_cross_matrix(back);
  seen.velocity = 1.F;
  return seen;
}

Estimate Estimator::step(std::uint64_t t_us, const Measurements& measured, bool flying, const Params& params) {
  const Imu imu = is_plausible(measured.imu) ? measured.imu : imu_;
  if (started_) path_.step(t_us, unbiased(imu_), unbiased(imu), placed_);
  started_ = true;
  imu_ = imu;
  gather(measured, params);
  if (!placed_) {
    begin(flying, params);
  } else if (t_us % kReferenceUs != 0) {  // the outer loop is work enough for one millisecond
    take_in(flying, params);
  }
  return estimate(imu);
}

/// One a millisecond, so that none is much longer than the others.
void Estimator::take_in(bool flying, const Params& params) {
  if (path_.t_us() - grown_us_ >= kGrowUs) grow(params);
  if (waiting_.pose) {
    see(*std::exchange(waiting_.pose, std::nullopt), flying, params);
  } else if (waiting_.gps) {
    see(*std::exchange(waiting_.gps, std::nullopt), params);
  } else if (waiting_.barometer) {
    see(*std::exchange(waiting_.barometer, std::nullopt), params);
  } else if (waiting_.magnetometer) {
    see(*std::exchange(waiting_.magnetometer, std::nullopt), params);
  }
}

Imu Estimator::unbiased(const Imu& imu) const {
  return {imu.w_WB_B - gyro_bias_, imu.specific_force_B - accelerometer_bias_};
}

/// The covariance to now.
void Estimator::grow(const Params& params) {
  const float dt = seconds(path_.t_us() - grown_us_);
  if (dt > 0.F) {
    const Motion& now = path_.now();
    const Mat3 R_WB = 0.5F * (rotation_matrix(grown_from_.q_WB) + rotation_matrix(now.q_WB));
    const Vec3 faster_W = now.v_WB - grown_from_.v_WB + Vec3(0.F, 0.F, kGravity * dt);
    covariance_.propagate(dt, R_WB, faster_W,
                          {kDt * square(params.est_gyro_noise), kDt * square(params.est_accelerometer_noise),
                           square(params.est_gyro_walk), square(params.est_accelerometer_walk)});
  }
  grown_us_ = path_.t_us();
  grown_from_ = path_.now();
  deviations_ = {covariance_.deviation(kAttitude), covariance_.deviation(kVelocity), covariance_.deviation(kPosition)};
  // Nowhere, or a number that is none (no measurement may do that; a fault in memory may): start over.
  if (!(deviations_.maxCoeff() < kNowhere && deviations_.allFinite() && grown_from_.p_WB.allFinite())) forget();
}

void Estimator::forget() {
  if (!path_.now().p_WB.allFinite() || !path_.now().v_WB.allFinite()) path_ = InertialPath();
  if (!gyro_bias_.allFinite() || !accelerometer_bias_.allFinite()) {
    gyro_bias_.setZero();
    accelerometer_bias_.setZero();
  }
  covariance_ = ErrorCovariance();
  placed_ = false;
  aided_ = {};
}

/// Errors found by measurements, into the motion and the biases.
void Estimator::inject(const ErrorVector& found) {
  path_.correct(found.segment<3>(kAttitude), found.segment<3>(kVelocity), found.segment<3>(kPosition));
  gyro_bias_ += found.segment<3>(kGyroBias);
  accelerometer_bias_ += found.segment<3>(kAccelerometerBias);
  grown_from_ = path_.now();
}

/// A slow error of the poses is as bad as a white one of the same power at low frequencies: that is what averages out.
Vec3 Estimator::attitude_variance(const PoseFix& pose, const Params& params) const {
  if (pose.attitude_deviation.minCoeff() > 0.F) return squares(pose.attitude_deviation);
  const float since = aided_.by_pose ? seconds(pose.t_us - aided_.pose_us) : 1e3F;
  const float samples_alike = std::max(1.F, 2.F * params.est_attitude_wander_time / since);
  return Vec3::Constant(square(params.est_attitude_deviation) + samples_alike * square(params.est_attitude_wander));
}

void Estimator::see(const PoseFix& pose, bool flying, const Params& params) {
  if (!is_pose(pose)) return;
  const bool first = pose_.t_us == 0 && aided_.pose_us == 0;
  const std::optional<Motion> believed = path_.at(pose.t_us);
  if (!believed || (!first && pose.t_us <= pose_.t_us)) {
    ++health_.late;
    return;
  }
  const bool same = pose.p_WB == pose_.p_WB && pose.q_WB == pose_.q_WB;
  const bool active = (imu_.w_WB_B - pose_.imu.w_WB_B).norm() > kActiveRate ||
                      (imu_.specific_force_B - pose_.imu.specific_force_B).norm() > kActiveForce;
  const bool told = pose.resets != pose_.resets && !first;
  pose_ = {pose.t_us, pose.p_WB, pose.q_WB, imu_, pose.resets};
  if (same && active && flying) {
    ++health_.frozen;
    return;
  }
  const Vec3 position_variance = pose.position_deviation.minCoeff() > 0.F
                                     ? squares(pose.position_deviation)
                                     : Vec3::Constant(square(params.est_position_deviation));
  const Vec3 turned_variance = attitude_variance(pose, params);
  if (!placed_) return place(pose, position_variance, turned_variance);

  grow(params);
  const Quat turn_W = normalised(pose.q_WB) * conj(believed->q_WB);
  Observation<3> position = late_position(*believed, path_.now(), seconds(path_.t_us() - pose.t_us));
  position.innovation = pose.p_WB - believed->p_WB;
  position.variance = position_variance;
  Observation<3> attitude;
  attitude.innovation = rotation_vector(turn_W);
  attitude.variance = turned_variance;
  attitude.attitude = Mat3::Identity();
  if (believe(params, position, attitude)) return agreed(aided_.pose_us, pose.t_us, aided_.by_pose);
  ++health_.rejected;
  if (path_.t_us() - aided_.since_us < kValidAfterUs) {  // one of the two lies
    aided_ = {};
    return place(pose, position_variance, turned_variance);
  }
  if (!contradicts_the_same(pose.t_us, position.innovation, turn_W, kJumpAfterUs) && !told) return;
  covariance_.set(kAttitude, turned_variance);
  jump(pose.t_us, {normalised(pose.q_WB), rotate(turn_W, believed->v_WB), pose.p_WB}, position_variance);
  agreed(aided_.pose_us, pose.t_us, aided_.by_pose);
}

/// By the first pose: attitude and position are its, the velocity is unknown.
void Estimator::place(const PoseFix& pose, const Vec3& position_variance, const Vec3& attitude_variance) {
  path_.pin(pose.t_us, {normalised(pose.q_WB), Vec3::Zero(), pose.p_WB});
  covariance_.set(kAttitude, attitude_variance);
  covariance_.set(kGyroBias, Vec3::Constant(square(kFirstGyroBias)));
  covariance_.set(kAccelerometerBias, Vec3::Constant(square(kFirstAccelerometerBias)));
  covariance_.set_moving(position_variance, square(kFirstSpeed), seconds(path_.t_us() - pose.t_us));
  placed_ = true;
  grown_us_ = path_.t_us();
  grown_from_ = path_.now();
  agreed(aided_.pose_us, pose.t_us, aided_.by_pose);
}

/// What is measured elsewhere has moved its origin, or the estimate was lost: go where it says, keep the biases.
void Estimator::jump(std::uint64_t t_us, const Motion& then, const Vec3& position_variance) {
  path_.pin(t_us, then);
  const float speed = square(kJumpSpeed) + square(covariance_.deviation(kVelocity));
  covariance_.set_moving(position_variance, speed, seconds(path_.t_us() - t_us));
  grown_from_ = path_.now();
  ++resets_;
}

/// True when this and all before it, for long enough, were off by the same.
bool Estimator::contradicts_the_same(std::uint64_t t_us, const Vec3& shift_W, const Quat& turn_W,
                                     std::uint64_t long_enough_us) {
  Contradiction& c = contradiction_;
  const bool same = c.until_us != 0 && t_us - c.until_us < kContradictionGapUs + long_enough_us / 2 &&
                    (shift_W - c.shift_W).norm() < kSameShift + 0.05F * shift_W.norm() &&
                    rotation_vector(turn_W * conj(c.turn_W)).norm() < kSameTurn;
  c = {same ? c.since_us : t_us, t_us, shift_W, turn_W};
  return t_us - c.since_us >= long_enough_us;
}

/// A measurement of t_us agreed (or was believed): `last_us` and `by` are its kind's.
void Estimator::agreed(std::uint64_t& last_us, std::uint64_t t_us, bool& by) {
  if (!aided_.by_pose && !aided_.by_satellites) {
    aided_.since_us = path_.t_us();
    aided_.count = 0;
  }
  by = true;
  last_us = t_us;
  aided_.count = std::min<std::uint32_t>(aided_.count + 1, 1000);
  contradiction_ = {};
  ++health_.used;
}

Estimate Estimator::estimate(const Imu& imu) {
  const std::uint64_t now_us = path_.t_us();
  aided_.by_pose = aided_.by_pose && now_us - aided_.pose_us <= kPosesLostUs;
  aided_.by_satellites = aided_.by_satellites && now_us - aided_.satellites_us <= kSatellitesLostUs;
  const bool aided = aided_.by_pose || aided_.by_satellites;
  Estimate out;
  out.q_WB = path_.now().q_WB;
  out.w_WB_B = imu.w_WB_B - gyro_bias_;
  out.p_WB = path_.now().p_WB;
  out.v_WB = path_.now().v_WB;
  out.position_valid = aided && aided_.count > 1 && now_us - aided_.since_us >= kValidAfterUs;
  aided_.attitude_known = placed_ && (aided_.attitude_known || out.position_valid);
  out.attitude_valid = aided_.attitude_known && deviations_[0] < kAttitudeLost;
  out.aiding = aided_.by_pose ? Aiding::kPose : aided_.by_satellites ? Aiding::kSatellites : Aiding::kNone;
  out.resets = resets_;
  out.attitude_deviation = deviations_[0];
  out.velocity_deviation = deviations_[1];
  out.position_deviation = deviations_[2];
  return out;
}

}  // namespace halfroll
