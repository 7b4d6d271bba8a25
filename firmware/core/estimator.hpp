// The smallest estimator that copes: gyro and accelerometer at 1 kHz, corrected by late poses from outside.
// Why: a pose is compared with what was believed when it was taken, so its delay costs noise, not stability.
#pragma once
#include <optional>

#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

class Estimator {
 public:
  Estimate step(std::uint64_t t_us, const Imu& imu, const std::optional<PoseFix>& pose, const Params& params);
  auto state() const;

 private:
  static constexpr int kHistory = 64;  // [ms], longest pose delay it can use
  struct Past {
    Quat q_WB;
    Vec3 p_WB = Vec3::Zero();
    Vec3 v_WB = Vec3::Zero();
  };
  Past now_;
  Vec3 gyro_bias_ = Vec3::Zero();
  std::array<Past, kHistory> history_ = {};
  std::uint64_t first_pose_us_ = 0, last_pose_us_ = 0;
  bool initialised_ = false;
};

}  // namespace halfroll
