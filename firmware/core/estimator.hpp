// What the vehicle believes of its motion: an error-state Kalman filter over the inertial path.
// Why: gyro and accelerometer are quick and drift, poses and satellites are late and do not; each is believed as far as
// its noise allows, and what contradicts everything else is not believed at all.
//
// The motion is integrated at 1 kHz; the covariance of its errors follows at 100 Hz and whenever something is measured.
// A late measurement is compared with the path at its own instant, and that error is written in terms of the error of
// now (docs/estimator.md): no horizon to wait for, no second filter. Nothing in it knows which way is up.
#pragma once
#include <optional>

#include "core/error_covariance.hpp"
#include "core/inertial_path.hpp"
#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

/// Whether it has a position within a thousand kilometres and an attitude: a quaternion of about unit length.
bool is_pose(const PoseFix& pose);

/// What became of the measurements so far.
struct EstimatorHealth {
  std::uint32_t used = 0;      // poses and satellite fixes taken in
  std::uint32_t rejected = 0;  // too far from what was believed
  std::uint32_t late = 0;      // older than the memory, out of order, or of the future
  std::uint32_t frozen = 0;    // poses that did not move while the vehicle did
  auto state() const { return std::tie(used, rejected, late, frozen); }
  bool operator==(const EstimatorHealth& o) const { return state() == o.state(); }
};

class Estimator {
 public:
  /// Advance to t_us, 1 ms after the call before; the first is at 0. `flying`: off the ground, where nothing stands
  /// still to the last bit. Measurements may be up to 0.25 s old. One is taken in a millisecond, and none in that of
  /// the outer loop: the others wait, and of each kind the newest. What is not finite, no attitude, out of order or
  /// older is not used. The first pose places the vehicle, in any attitude; without poses a still vehicle with
  /// accelerometer, magnetometer and satellites is placed by those. Position is valid after 0.1 s of poses and until
  /// 0.5 s without; attitude until it is uncertain by 10 deg.
  Estimate step(std::uint64_t t_us, const Measurements& measured, bool flying, const Params& params);

  const ErrorCovariance& covariance() const { return covariance_; }
  const Vec3& gyro_bias() const { return gyro_bias_; }
  const Vec3& accelerometer_bias() const { return accelerometer_bias_; }
  const EstimatorHealth& health() const { return health_; }

  auto state() const {
    return std::tuple_cat(
        path_.state(),
        std::tie(covariance_, imu_, waiting_, gyro_bias_, accelerometer_bias_, started_, placed_, grown_us_,
                 grown_from_, aided_, pose_, contradiction_, still_, latest_fix_us_, barometer_, resets_, deviations_));
  }

 private:
  /// What has come and is not taken in yet.
  struct Waiting {
    std::optional<PoseFix> pose;
    std::optional<GpsFix> gps;
    std::optional<BarometerSample> barometer;
    std::optional<MagnetometerSample> magnetometer;
    auto state() const { return std::tie(pose, gps, barometer, magnetometer); }
    bool operator==(const Waiting& o) const { return state() == o.state(); }
  };
  /// Since when, and until when, something external has agreed.
  struct Aided {
    std::uint64_t since_us = 0, pose_us = 0, satellites_us = 0;
    std::uint32_t count = 0;
    bool by_pose = false, by_satellites = false, attitude_known = false;
    auto state() const {
      return std::tie(since_us, pose_us, satellites_us, count, by_pose, by_satellites, attitude_known);
    }
    bool operator==(const Aided& o) const { return state() == o.state(); }
  };
  /// The latest pose looked at, used or not, and the inertial sample that came with it.
  struct LatestPose {
    std::uint64_t t_us = 0;
    Vec3 p_WB = Vec3::Zero();
    Quat q_WB;
    Imu imu;
    std::uint8_t resets = 0;
    auto state() const { return std::tie(t_us, p_WB, q_WB, imu, resets); }
    bool operator==(const LatestPose& o) const { return state() == o.state(); }
  };
  /// Measurements that were rejected but agree with each other.
  struct Contradiction {
    std::uint64_t since_us = 0, until_us = 0;
    Vec3 shift_W = Vec3::Zero();
    Quat turn_W;
    auto state() const { return std::tie(since_us, until_us, shift_W, turn_W); }
    bool operator==(const Contradiction& o) const { return state() == o.state(); }
  };
  /// Sums over the time it has stood still.
  struct Still {
    std::uint32_t samples = 0, fields = 0;
    Vec3 specific_force_B = Vec3::Zero(), rate_B = Vec3::Zero(), field_B = Vec3::Zero();
    auto state() const { return std::tie(samples, fields, specific_force_B, rate_B, field_B); }
    bool operator==(const Still& o) const { return state() == o.state(); }
  };
  struct Barometer {
    std::uint64_t t_us = 0;
    float offset = 0.F, variance = 0.F;
    bool known = false;
    auto state() const { return std::tie(t_us, offset, variance, known); }
    bool operator==(const Barometer& o) const { return state() == o.state(); }
  };

  // estimator.cpp: the path, its covariance, and poses
  Imu unbiased(const Imu& imu) const;
  void take_in(bool flying, const Params& params);
  void grow(const Params& params);
  template <int... N>
  bool believe(const Params& params, const Observation<N>&... seen);
  void inject(const ErrorVector& found);
  void see(const PoseFix& pose, bool flying, const Params& params);
  void place(const PoseFix& pose, const Vec3& position_variance, const Vec3& attitude_variance);
  void jump(std::uint64_t t_us, const Motion& then, const Vec3& position_variance);
  bool contradicts_the_same(std::uint64_t t_us, const Vec3& shift_W, const Quat& turn_W, std::uint64_t long_enough_us);
  Vec3 attitude_variance(const PoseFix& pose, const Params& params) const;
  void agreed(std::uint64_t& last_us, std::uint64_t t_us, bool& by);
  void forget();
  Estimate estimate(const Imu& imu);

  // estimator_outdoors.cpp: satellites, barometer, magnetometer
  void gather(const Measurements& measured, const Params& params);
  void begin(bool flying, const Params& params);
  void stand();
  void place_outdoors(const GpsFix& fix, const Params& params);
  void see(const GpsFix& fix, const Params& params);
  void see(const BarometerSample& sample, const Params& params);
  void see(const MagnetometerSample& sample, const Params& params);

  InertialPath path_;
  ErrorCovariance covariance_;
  Imu imu_;  // of the last step, biases and all
  Waiting waiting_;
  Vec3 gyro_bias_ = Vec3::Zero(), accelerometer_bias_ = Vec3::Zero();
  bool started_ = false;
  bool placed_ = false;         // knows where it is, well or badly
  std::uint64_t grown_us_ = 0;  // the covariance is of this instant
  Motion grown_from_;           // and the motion of it
  Aided aided_;
  LatestPose pose_;
  Contradiction contradiction_;
  Still still_;
  std::uint64_t latest_fix_us_ = 0;  // stamp of the latest looked at
  Barometer barometer_;
  std::uint8_t resets_ = 0;
  EstimatorHealth health_;
  Vec3 deviations_ = Vec3::Zero();  // attitude, velocity, position
};

/// Take in what was seen at one instant if all of it is where it may be, given what was before it; else nothing of it.
template <int... N>
bool Estimator::believe(const Params& params, const Observation<N>&... seen) {
  const float gate = params.est_gate * params.est_gate;
  Findings found;
  if (!((covariance_.look(seen, found) < gate) && ...)) return false;
  covariance_.take(found);
  inject(found.errors());
  return true;
}

/// Where the error of now shows in a position measured when the motion was `then`, `age` before `now`.
Observation<3> late_position(const Motion& then, const Motion& now, float age);
/// The same of a velocity.
Observation<3> late_velocity(const Motion& then, const Motion& now, float age);

}  // namespace halfroll
