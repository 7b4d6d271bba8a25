// On the ground or in the air. Why: arming, disarming, integrators and LAND all hang on it, in any attitude.
#pragma once
#include "core/constants.hpp"
#include "core/types.hpp"

namespace halfroll {

class LandedDetector {
 public:
  /// One 10 ms tick. `lift`: what the thrust pushes straight up, in any attitude [N]; `weight` [N].
  /// Leaves the ground when risen 0.1 m; is back when it rests although its thrust could not carry it.
  bool step(const Estimate& estimate, float lift, float weight, bool armed) {
    if (!armed) {
      on_ground_ = true;
      ground_z_ = estimate.p_WB.z();
      resting_s_ = 0.F;
    } else if (on_ground_) {
      on_ground_ = estimate.p_WB.z() - ground_z_ < kLiftOff;
      resting_s_ = 0.F;
    } else {
      // In the air, so little lift would have gathered 1 m/s meanwhile. Longer on the ground, attitude control tips it
      // over.
      const bool resting = lift < kLowLift * weight && estimate.v_WB.norm() < kStill;
      resting_s_ = resting ? resting_s_ + kReferenceDt : 0.F;
      if (resting_s_ > kRestingTime) {
        on_ground_ = true;
        ground_z_ = estimate.p_WB.z();
      }
    }
    return on_ground_;
  }
  bool on_ground() const { return on_ground_; }
  auto state() const { return std::tie(on_ground_, ground_z_, resting_s_); }

 private:
  static constexpr float kLiftOff = 0.1F;       // [m]
  static constexpr float kLowLift = 0.6F;       // of the weight
  static constexpr float kStill = 0.25F;        // [m/s]
  static constexpr float kRestingTime = 0.25F;  // [s]

  bool on_ground_ = true;
  float ground_z_ = 0.F;
  float resting_s_ = 0.F;
};

}  // namespace halfroll
