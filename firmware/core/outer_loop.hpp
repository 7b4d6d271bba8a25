// Outer loop (Eqs 6-19): trajectory and measured state to attitude, body rates and signed thrust, every 10 ms.
// Why: it exists once; the firmware flies hold, land and return with it, the ground station calls the same code.
#pragma once
#include "core/params.hpp"
#include "core/types.hpp"
#include "core/vehicle.hpp"

namespace halfroll {

/// Everything one tick needs. Leads (docs/paper.md) are the caller's: it knows the plan's future.
struct OuterLoopInput {
  std::uint64_t t_us = 0;                 // the tick; stamps the setpoint
  Estimate state;                         // sampled at or before t_us
  FlatReference at_sample;                // the plan when the state was sampled
  FlatReference now;                      // the plan at t_us
  Vec3 lead_acceleration = Vec3::Zero();  // plan acceleration thrust_lead ahead of t_us [m/s²]
  Vec3 lead_rate = Vec3::Zero();          // plan body rate rate_lead ahead minus now, body components [rad/s]
  float mid_age = 0.F;                    // [s], mean age of the setpoint while it is in use
  float sigma = 1.F;                      // +1 upright, -1 inverted: wanted sign of the thrust axis' vertical component
  bool sigma_event_near = false;          // within 0.06 s of a scheduled change of sigma
  bool on_ground = false;                 // freezes the integrator
};

/// Attitude, rates and their derivative from a force and its two derivatives (Eqs 11-19), both charts.
struct ForceAttitude {
  Quat q_WD;
  Vec3 w_WD_D = Vec3::Zero();
  Vec3 dw_WD_D = Vec3::Zero();
};

/// Unit vector along a force, with two derivatives (Eq 19 and one more).
struct ThrustAxis {
  Vec3 n = Vec3::UnitZ(), n1 = Vec3::Zero(), n2 = Vec3::Zero();
};

class OuterLoop {
 public:
  static constexpr float kMostIntegral = 1.F;  // [m·s], of the position error, per axis

  explicit OuterLoop(const Vehicle& vehicle);

  /// One tick, to be called every 10 ms. The setpoint has no angular acceleration, on board as over the link: the led
  /// rate carries it (feedback in it is noise). A tick with a NaN in it repeats the last attitude and thrust, at rest.
  Setpoint step(const OuterLoopInput& in, const Params& params);

  /// Forget errors and chart; continue from this attitude.
  void reset(const Quat& q_WB);

  const Vec3& integral() const { return integral_; }  // [m·s]

  auto state() const {
    return std::tie(integral_, q_WD_, w_WD_D_, thrust_axis_, inverted_chart_, chart_heading_, yaw_offset_,
                    modelled_thrust_, thrust_cut_);
  }

 private:
  struct Feedback {
    Vec3 acceleration, jerk;  // fb [m/s²] and fb' [m/s³]
  };

  Setpoint advance(const OuterLoopInput& in, const Params& params);
  Feedback feedback(const OuterLoopInput& in, const Params& params);
  void keep_upright(Vec3& force, Vec3& force_rate, Vec3& force_acceleration) const;
  void propagate();
  void follow_own_thrust(float thrust, const Params& params);
  ForceAttitude attitude_from_force(const Vec3& force, const Vec3& force_rate, const Vec3& force_acceleration,
                                    const OuterLoopInput& in, const Params& params);
  float thrust_sign(const Vec3& u, const OuterLoopInput& in, const Params& params) const;
  void choose_chart(const Vec3& n);

  Vehicle vehicle_;
  Vec3 integral_ = Vec3::Zero();  // [m·s]
  Quat q_WD_;
  Vec3 w_WD_D_ = Vec3::Zero();
  Vec3 thrust_axis_ = Vec3::UnitZ();  // n of the last tick, for continuity of its sign
  bool inverted_chart_ = false;       // chart C (n3 < 0) in use
  float chart_heading_ = 0.F;         // gamma of chart C [rad]
  float yaw_offset_ = 0.F;            // keeps q_WD continuous over non-planar chart changes [rad]
  float modelled_thrust_ = 0.F;       // own setpoints through the rotor lag [N]
  bool thrust_cut_ = false;
};

/// Direction of a force that is not zero, and how it turns.
ThrustAxis unit_derivatives(const Vec3& force, const Vec3& force_rate, const Vec3& force_acceleration);
/// Chart A: the least rotation taking e3 to n, with rate and angular acceleration in its own axes (n3 > -1).
ForceAttitude least_rotation(const Vec3& n, const Vec3& n1, const Vec3& n2);
/// Chart C: the same measured from upside down, about the horizontal axis at heading gamma (n3 < 1).
ForceAttitude least_rotation_inverted(const Vec3& n, const Vec3& n1, const Vec3& n2, float gamma);
/// Turn about the body's own z by yaw (Eq 13), with rates.
ForceAttitude with_yaw(const ForceAttitude& attitude, float yaw, float yaw_rate, float yaw_acceleration);

}  // namespace halfroll
