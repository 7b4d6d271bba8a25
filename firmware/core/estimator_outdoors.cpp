// Where there is no motion capture: satellites for position and velocity, the magnetometer for the heading, pressure
// for the height. All of them rest while poses come: indoors they only disturb.
#include <algorithm>
#include <cmath>

#include "core/estimator.hpp"
#include "core/quaternion.hpp"

namespace halfroll {
namespace {

constexpr std::uint32_t kStillSamples = 300, kStillFields = 5;
constexpr float kStillRate = 0.15F;              // [rad/s]
constexpr float kStillForce = 1.5F;              // [m/s²], off gravity
constexpr float kFirstTilt = 0.05F;              // [rad], one sigma, from the accelerometer
constexpr float kFirstHeading = 0.1F;            // [rad]
constexpr float kFirstStillSpeed = 0.3F;         // [m/s]
constexpr float kStillGyroBias = 3e-3F;          // [rad/s], from its mean
constexpr float kStillAccelerometerBias = 0.2F;  // [m/s²]
constexpr float kLeastHorizontal = 0.1F;         // of the field: below this a heading is noise
constexpr std::uint64_t kSatelliteJumpAfterUs = 2000000;

using namespace error_state;
enum Sensor { kSatelliteFix = 4, kPressure = 8, kField = 16 };

float square(float x) { return x * x; }
float seconds(std::uint64_t us) { return 1e-6F * static_cast<float>(us); }
float given(float deviation, float otherwise) { return square(deviation > 0.F ? deviation : otherwise); }

/// The least rotation that brings `up_B` upright; upside down, half a turn about x and then the least.
Quat levelling(const Vec3& up_B) {
  const bool inverted = up_B.z() < 0.F;
  const Vec3 u = inverted ? Vec3(up_B.x(), -up_B.y(), -up_B.z()) : up_B;
  const Quat least = normalised({1.F + u.z(), u.y(), -u.x(), 0.F});
  return inverted ? least * Quat{0.F, 1.F, 0.F, 0.F} : least;
}

}  // namespace

/// What is used of what came; of each kind the newest waits.
void Estimator::gather(const Measurements& measured, const Params& params) {
  const int used = static_cast<int>(params.est_sensors);
  if (measured.pose && is_pose(*measured.pose)) waiting_.pose = measured.pose;
  if (measured.barometer && (used & kPressure) != 0) waiting_.barometer = measured.barometer;
  if (aided_.by_pose) return;
  if (measured.gps && (used & kSatelliteFix) != 0) waiting_.gps = measured.gps;
  if (measured.magnetometer && (used & kField) != 0) waiting_.magnetometer = measured.magnetometer;
}

/// Not placed yet: by a pose at once, else by satellites once it has stood still.
void Estimator::begin(bool flying, const Params& params) {
  if (waiting_.pose) see(*waiting_.pose, flying, params);
  if (!placed_) stand();
  if (!placed_ && waiting_.gps) place_outdoors(*waiting_.gps, params);
  waiting_ = {};
}

/// While it does not move, the accelerometer shows up, the gyro its bias, the magnetometer north.
void Estimator::stand() {
  const bool still = imu_.w_WB_B.norm() < kStillRate && std::abs(imu_.specific_force_B.norm() - kGravity) < kStillForce;
  if (!still) still_ = {};
  ++still_.samples;
  still_.specific_force_B += imu_.specific_force_B;
  still_.rate_B += imu_.w_WB_B;
  if (waiting_.magnetometer && waiting_.magnetometer->field_B.allFinite()) {
    ++still_.fields;
    still_.field_B += waiting_.magnetometer->field_B.normalized();
  }
  if (still_.samples < 4 * kStillSamples) return;
  still_.samples /= 2;  // forget slowly
  still_.fields /= 2;
  still_.specific_force_B *= 0.5F;
  still_.rate_B *= 0.5F;
  still_.field_B *= 0.5F;
}

void Estimator::place_outdoors(const GpsFix& fix, const Params& params) {
  if (still_.samples < kStillSamples || still_.fields < kStillFields || !fix.p_WB.allFinite()) return;
  const Quat level = levelling(still_.specific_force_B.normalized());
  const Vec3 field_L = rotate(level, still_.field_B);
  if (field_L.head<2>().norm() < kLeastHorizontal * field_L.norm()) return;
  const Quat q_WB = about_z(-params.est_declination - arctangent2(field_L.y(), field_L.x())) * level;
  path_.pin(path_.t_us(), {q_WB, Vec3::Zero(), fix.p_WB});
  gyro_bias_ = still_.rate_B / static_cast<float>(still_.samples);
  const float horizontal = given(fix.horizontal_deviation, params.est_gps_position_deviation);
  const float vertical = given(fix.vertical_deviation, params.est_gps_position_deviation);
  covariance_.set(kAttitude, {square(kFirstTilt), square(kFirstTilt), square(kFirstHeading)});
  covariance_.set(kGyroBias, Vec3::Constant(square(kStillGyroBias)));
  covariance_.set(kAccelerometerBias, Vec3::Constant(square(kStillAccelerometerBias)));
  covariance_.set_moving({horizontal, horizontal, vertical}, square(kFirstStillSpeed), 0.F);
  placed_ = true;
  grown_us_ = path_.t_us();
  grown_from_ = path_.now();
  still_ = {};
  latest_fix_us_ = fix.t_us;
  agreed(aided_.satellites_us, fix.t_us, aided_.by_satellites);
}

void Estimator::see(const GpsFix& fix, const Params& params) {
  if (!fix.p_WB.allFinite() || !fix.v_WB.allFinite()) return;
  const std::optional<Motion> believed = path_.at(fix.t_us);
  if (!believed || (latest_fix_us_ != 0 && fix.t_us <= latest_fix_us_)) {
    ++health_.late;
    return;
  }
  latest_fix_us_ = fix.t_us;
  grow(params);
  if (!placed_) return;
  const float age = seconds(path_.t_us() - fix.t_us);
  const float horizontal = given(fix.horizontal_deviation, params.est_gps_position_deviation);
  const float vertical = given(fix.vertical_deviation, params.est_gps_position_deviation);
  Observation<3> position = late_position(*believed, path_.now(), age);
  position.innovation = fix.p_WB - believed->p_WB;
  position.variance = {horizontal, horizontal, vertical};
  Observation<3> velocity = late_velocity(*believed, path_.now(), age);
  velocity.innovation = fix.v_WB - believed->v_WB;
  velocity.variance.setConstant(given(fix.speed_deviation, params.est_gps_speed_deviation));
  if (believe(params, velocity, position)) {
    return agreed(aided_.satellites_us, fix.t_us, aided_.by_satellites);
  }
  ++health_.rejected;
  if (!contradicts_the_same(fix.t_us, Vec3::Zero(), Quat{}, kSatelliteJumpAfterUs)) return;
  jump(fix.t_us, {believed->q_WB, fix.v_WB, fix.p_WB}, position.variance);
  agreed(aided_.satellites_us, fix.t_us, aided_.by_satellites);
}

// The offset is a Kalman filter of one state beside the other: what wanders over minutes need not correlate with what
// changes in seconds. While poses come, only the offset is learnt.
void Estimator::see(const BarometerSample& sample, const Params& params) {
  const std::optional<Motion> believed = path_.at(sample.t_us);
  if (!std::isfinite(sample.height) || !believed) return;
  grow(params);
  if (!placed_) return;
  const float height_variance = covariance_.variance(kPosition + 2);
  const float noise = square(params.est_barometer_deviation);
  if (!barometer_.known) {
    barometer_ = {sample.t_us, sample.height - believed->p_WB.z(), height_variance + noise, true};
    return;
  }
  const float since = sample.t_us > barometer_.t_us ? seconds(sample.t_us - barometer_.t_us) : 0.F;
  barometer_.variance += since * square(params.est_barometer_walk);
  barometer_.t_us = sample.t_us;
  const float off = sample.height - believed->p_WB.z() - barometer_.offset;
  const float age = seconds(path_.t_us() - sample.t_us);
  Observation<1> height;
  const Observation<3> position = late_position(*believed, path_.now(), age);
  height.attitude = position.attitude.row(2);
  height.velocity = position.velocity;
  height.position = position.position;
  height.axis = 2;
  height.innovation(0) = off;
  height.variance(0) = noise + barometer_.variance;
  if (!aided_.by_pose && !believe(params, height)) return;
  const float gain = barometer_.variance / (barometer_.variance + height_variance + noise);
  barometer_.offset += gain * off;
  barometer_.variance *= 1.F - gain;
}

// The measured field, turned to W as believed, should point to magnetic north: a turn about up, and with an inclined
// field a bit of the tilt. Linear in the world's axes, so it holds in any attitude.
void Estimator::see(const MagnetometerSample& sample, const Params& params) {
  const std::optional<Motion> believed = path_.at(sample.t_us);
  if (!sample.field_B.allFinite() || !believed) return;
  const Vec3 field_W = rotate(believed->q_WB, sample.field_B);
  const float horizontal2 = field_W.head<2>().squaredNorm();
  if (!(horizontal2 > square(kLeastHorizontal) * field_W.squaredNorm())) return;
  grow(params);
  if (!placed_) return;
  Observation<1> heading;
  heading.innovation(0) = wrapped_angle(-params.est_declination - arctangent2(field_W.y(), field_W.x()));
  heading.variance(0) = square(params.est_magnetometer_deviation);
  heading.attitude << -field_W.x() * field_W.z() / horizontal2, -field_W.y() * field_W.z() / horizontal2, 1.F;
  believe(params, heading);
}

}  // namespace halfroll
