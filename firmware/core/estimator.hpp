// The smallest estimator that copes: gyro and accelerometer at 1 kHz, corrected by late poses from outside.
// Why: a pose is compared with what was believed when it was taken, so its delay costs noise, not stability.
#pragma once
#include <optional>

#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

class Estimator {
 public:
  /// Advance to t_us, 1 ms after the call before. `imu` is sampled at t_us; `pose` may be up to 62 ms old.
  /// A sample or pose that is not finite, a pose without unit quaternion, out of order or too old is not used.
  /// Attitude and position are valid after 0.1 s of poses and until 0.5 s without any; the first one places the
  /// vehicle.
  Estimate step(std::uint64_t t_us, const Imu& imu, const std::optional<PoseFix>& pose, const Params& params);

  auto state() const {
    return std::tie(now_, imu_, gyro_bias_, history_, first_pose_us_, last_pose_us_, poses_, placed_);
  }

 private:
  static constexpr std::uint64_t kHistory = 64;  // [ms], longest pose delay it can use
  struct Past {
    Quat q_WB;
    Vec3 p_WB = Vec3::Zero();
    Vec3 v_WB = Vec3::Zero();
    bool operator==(const Past& o) const { return q_WB == o.q_WB && p_WB == o.p_WB && v_WB == o.v_WB; }
  };

  void integrate(const Imu& imu);
  void correct(std::uint64_t t_us, const PoseFix& pose, const Params& params);
  bool usable(std::uint64_t t_us, const PoseFix& pose) const;
  Past past(std::uint64_t t_us) const;

  Past now_;
  Imu imu_;  // of the last step
  Vec3 gyro_bias_ = Vec3::Zero();
  std::array<Past, kHistory> history_ = {};  // of millisecond k at k mod 64
  std::uint64_t first_pose_us_ = 0, last_pose_us_ = 0;
  bool placed_ = false;      // has ever had a pose
  std::uint32_t poses_ = 0;  // since tracking began; 0: not placed yet
};

}  // namespace halfroll
