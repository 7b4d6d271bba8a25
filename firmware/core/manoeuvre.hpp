// Half rolls and flips flown on board. Why: inverted hold and a flip need no ground station, and no memory: attitude
// and thrust follow from the time since they began.
//
// The body turns about one of its own axes by a quintic of time (rate and angular acceleration start and end at 0). The
// thrust along the way is m g c (1 + 4 s²) for cosine c and sine s of the tilt: hover at both ends, zero when the axis
// is level, and its vertical part averages the weight over each quarter turn, so height is kept but for the rotors'
// limits.
#pragma once
#include "core/params.hpp"
#include "core/types.hpp"
#include "core/vehicle.hpp"

namespace halfroll {

enum class BodyAxis : std::uint8_t { kRoll = 1, kPitch = 2 };  // MAVLink's numbers in the flip command

class Manoeuvre {
 public:
  /// From this attitude, upright or inverted and at rest, by `turns` (0.5: half a roll) about the axis. Positive turns
  /// follow the wire's axes: right wing down, nose up.
  void start(const Quat& q_WB, const Vec3& position, BodyAxis axis, float turns, const Vehicle& vehicle,
             const Params& params);

  /// One 10 ms tick: the setpoint of now; `on_course` and `active` follow from it.
  Setpoint step(const Estimate& estimate, std::uint64_t t_us, const Vehicle& vehicle, const Params& params);
  void stop() { active_ = false; }

  bool active() const { return active_; }
  /// False once the body is more than 60 deg from where it should be.
  bool on_course() const { return on_course_; }

  /// [s], so that FLIP_RATE and half the torque of the rotors suffice.
  static float duration(float turns, const Vehicle& vehicle, const Params& params);

  /// [m], a bound on how far it sinks before it is back.
  static float height_loss(float turns) { return 0.5F + 0.3F * (turns < 0.F ? -turns : turns); }

  auto state() const { return std::tie(active_, on_course_, q_start_, start_, axis_, angle_, duration_, elapsed_); }

 private:
  bool active_ = false, on_course_ = true;
  Quat q_start_;
  Vec3 start_ = Vec3::Zero();  // W, where it returns to
  Vec3 axis_ = Vec3::UnitX();  // B
  float angle_ = 0.F;          // [rad], all turns
  float duration_ = 1.F, elapsed_ = 0.F;
};

}  // namespace halfroll
