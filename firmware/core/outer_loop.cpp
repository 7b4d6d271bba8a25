#include "core/outer_loop.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "core/quaternion.hpp"

namespace halfroll {
namespace {

constexpr float kChartHysteresis = 0.05F;  // n3 beyond which the other chart takes over
constexpr float kYawOffsetRate = 0.2F;     // [1/s], decay of the yaw that a non-planar change of chart leaves
constexpr float kRateMax = 39.F;           // [rad/s] per axis; the link refuses 40 and more
constexpr float kFixedPitchLift = 0.5F;    // share of the weight that a fixed-pitch vehicle keeps pointing up

float sign_of(float x) { return x < 0.F ? -1.F : 1.F; }

Vec3 gravity_up() { return {0.F, 0.F, kGravity}; }

/// How much of the position feedback the attitude sees, and how fast that changes.
struct Fade {
  float share = 1.F, rate = 0.F;  // [-], [1/s]
};

// Near zero force a small feedback turns the thrust axis violently; so it leaves the attitude (never the thrust) there.
Fade fade(const Vec3& force, const Vec3& force_rate, float fade_force) {
  const float size = force.norm();
  if (fade_force <= 0.F || size >= fade_force) return {};
  const float x = size / fade_force;
  const float x_rate = size > 1e-6F ? force.dot(force_rate) / (size * fade_force) : 0.F;
  return {x * x * (3.F - 2.F * x), 6.F * x * (1.F - x) * x_rate};
}

}  // namespace

OuterLoop::OuterLoop(const Vehicle& vehicle) : vehicle_(vehicle), modelled_thrust_(vehicle.mass * kGravity) {}

void OuterLoop::reset(const Quat& q_WB) {
  *this = OuterLoop(vehicle_);
  q_WD_ = normalised(q_WB);
  thrust_axis_ = up_axis(q_WD_);
  modelled_thrust_ *= thrust_axis_.z();
  inverted_chart_ = thrust_axis_.z() < 0.F;
  // the gamma for which chart C gives this attitude at its heading_after_levelling, straight down included
  chart_heading_ = arctangent2(q_WD_.y, q_WD_.x) + 0.5F * heading_after_levelling(q_WD_);
}

// A tick that is not finite (a NaN in the state or the plan) is not flown: attitude and thrust of the last one stay.
Setpoint OuterLoop::step(const OuterLoopInput& in, const Params& params) {
  OuterLoop next = *this;
  Setpoint setpoint = next.advance(in, params);
  if (is_finite(setpoint.q_WD) && setpoint.w_WD_D.allFinite() && std::isfinite(setpoint.thrust) &&
      next.integral_.allFinite()) {
    *this = next;
    return setpoint;
  }
  Setpoint held;
  held.t_us = in.t_us;
  held.q_WD = q_WD_;
  held.thrust = modelled_thrust_;
  return held;
}

Setpoint OuterLoop::advance(const OuterLoopInput& in, const Params& params) {
  const float m = vehicle_.mass;
  const Feedback fb = feedback(in, params);

  // Eqs 6-7 and their derivatives, drag along the plan fed forward; the feedback's part of F'' is left out
  const float d = params.drag;
  const Vec3 plan_force = m * (in.now.acceleration + gravity_up()) + d * in.now.velocity;
  const Vec3 plan_force_rate = m * in.now.jerk + d * in.now.acceleration;
  const Fade w = fade(plan_force, plan_force_rate, params.fade_force);
  Vec3 force = plan_force + w.share * m * fb.acceleration;
  Vec3 force_rate = plan_force_rate + w.share * m * fb.jerk + w.rate * m * fb.acceleration;
  Vec3 force_acceleration = m * in.now.snap + d * in.now.jerk;
  keep_upright(force, force_rate, force_acceleration);

  if (force.norm() < params.hold_force) {
    propagate();
  } else {
    const ForceAttitude wanted = attitude_from_force(force, force_rate, force_acceleration, in, params);
    q_WD_ = wanted.q_WD;
    w_WD_D_ = wanted.w_WD_D;
  }
  thrust_axis_ = up_axis(q_WD_);

  const Vec3 led_velocity = in.now.velocity + (params.actuator_lead + in.mid_age) * in.now.acceleration;
  const Vec3 led_force = m * (in.lead_acceleration + gravity_up()) + d * led_velocity;
  const float thrust = sign_of(led_force.dot(thrust_axis_)) * led_force.norm() + m * fb.acceleration.dot(thrust_axis_);
  follow_own_thrust(thrust, params);

  Setpoint setpoint;
  setpoint.t_us = in.t_us;
  // extrapolation with the led rate runs ahead by mid_age on average: taken back here
  setpoint.q_WD = normalised(q_WD_ * from_rotation_vector(-in.mid_age * in.lead_rate));
  setpoint.w_WD_D = (w_WD_D_ + in.lead_rate).cwiseMax(-kRateMax).cwiseMin(kRateMax);
  setpoint.thrust = thrust;
  return setpoint;
}

// Position PID and its derivative, by the acceleration that our own thrust makes: no differencing, no noise.
OuterLoop::Feedback OuterLoop::feedback(const OuterLoopInput& in, const Params& params) {
  const Vec3 kp(params.pos_kp_xy, params.pos_kp_xy, params.pos_kp_z);
  const Vec3 ki(params.pos_ki_xy, params.pos_ki_xy, params.pos_ki_z);
  const Vec3 kd(params.pos_kd_xy, params.pos_kd_xy, params.pos_kd_z);
  const Vec3 position_error = in.state.p_WB - in.at_sample.position;
  const Vec3 velocity_error = in.state.v_WB - in.at_sample.velocity;
  if (!in.on_ground && !thrust_cut_) {
    integral_ = (integral_ + position_error * kReferenceDt).cwiseMax(-kMostIntegral).cwiseMin(kMostIntegral);
  }
  const Vec3 n_B = up_axis(in.state.q_WB);
  const Vec3 push = n_B * modelled_thrust_ - params.drag * in.state.v_WB;
  const Vec3 acceleration = push / vehicle_.mass - gravity_up();
  const Vec3 acceleration_error = acceleration - in.at_sample.acceleration;
  const Vec3 jerk =
      -kp.cwiseProduct(velocity_error) - ki.cwiseProduct(position_error) - kd.cwiseProduct(acceleration_error);
  // A body that is still turning over moves as its attitude makes it: no reason to turn the reference away meanwhile.
  const float share = std::max(0.F, n_B.dot(thrust_axis_));
  return {-kp.cwiseProduct(position_error) - ki.cwiseProduct(integral_) - kd.cwiseProduct(velocity_error),
          share * jerk};
}

// A fixed-pitch vehicle cannot push down: its force never points below half its weight, and stands still there.
void OuterLoop::keep_upright(Vec3& force, Vec3& force_rate, Vec3& force_acceleration) const {
  if (vehicle_.rotor_kind != RotorKind::kFixedPitch) return;
  const float least = std::max(4.F * vehicle_.thrust_min, kFixedPitchLift * vehicle_.mass * kGravity);
  if (force.z() >= least) return;
  force.z() = least;
  force_rate.z() = force_acceleration.z() = 0.F;
}

/// Hold: the force is too small to have a direction; the attitude keeps turning at the rate it had.
void OuterLoop::propagate() { q_WD_ = normalised(q_WD_ * from_rotation_vector(w_WD_D_ * kReferenceDt)); }

// What the rotors make of the thrust asked for so far (their lag, their limits), for the next tick's acceleration.
void OuterLoop::follow_own_thrust(float thrust, const Params& params) {
  const bool fixed_pitch = vehicle_.rotor_kind == RotorKind::kFixedPitch;
  const float lag =
      fixed_pitch ? vehicle_.rotor_lag / params.lag_compensation : std::max(vehicle_.rotor_lag, params.actuator_lead);
  const float given = std::clamp(thrust, 4.F * vehicle_.thrust_min, 4.F * vehicle_.thrust_max);
  thrust_cut_ = given != thrust;
  modelled_thrust_ += kReferenceDt / (lag + kReferenceDt) * (given - modelled_thrust_);
}

ForceAttitude OuterLoop::attitude_from_force(const Vec3& force, const Vec3& force_rate, const Vec3& force_acceleration,
                                             const OuterLoopInput& in, const Params& params) {
  ThrustAxis axis = unit_derivatives(force, force_rate, force_acceleration);
  const float sign = thrust_sign(axis.n, in, params);
  axis = {sign * axis.n, sign * axis.n1, sign * axis.n2};
  choose_chart(axis.n);

  const ForceAttitude levelled = inverted_chart_ ? least_rotation_inverted(axis.n, axis.n1, axis.n2, chart_heading_)
                                                 : least_rotation(axis.n, axis.n1, axis.n2);
  const float offset_rate = -kYawOffsetRate * yaw_offset_;
  ForceAttitude wanted = with_yaw(levelled, in.now.yaw + yaw_offset_, in.now.yaw_rate + offset_rate,
                                  in.now.yaw_acceleration - kYawOffsetRate * offset_rate);
  yaw_offset_ += kReferenceDt * offset_rate;
  if (dot(wanted.q_WD, q_WD_) < 0.F) wanted.q_WD = -wanted.q_WD;  // q and -q are one
  return wanted;
}

// s of n = s F/|F|. Base rule: sigma is the wanted sign of n3. Feedback moves the true reversal away from a scheduled
// one, so near it continuity decides (SIGN_RULE window), always (cont) or never (paper).
float OuterLoop::thrust_sign(const Vec3& u, const OuterLoopInput& in, const Params& params) const {
  if (vehicle_.rotor_kind == RotorKind::kFixedPitch) return 1.F;
  const float base = sign_of(in.sigma) * sign_of(u.z());
  const bool continuous = params.sign_rule == 2.F || (params.sign_rule == 0.F && in.sigma_event_near);
  const float along = u.dot(thrust_axis_);
  return continuous && along != 0.F ? sign_of(along) : base;
}

// Chart A is singular straight down, chart C straight up. Each takes over with the attitude of the other: C by its
// heading gamma, A by a yaw offset (0 for planar flips).
void OuterLoop::choose_chart(const Vec3& n) {
  const float gamma = arctangent2(n.x(), -n.y());  // phi + pi/2
  if (!inverted_chart_ && n.z() < -kChartHysteresis) {
    inverted_chart_ = true;
    chart_heading_ = gamma;
  } else if (inverted_chart_ && n.z() > kChartHysteresis) {
    inverted_chart_ = false;
    yaw_offset_ = wrapped_angle(yaw_offset_ + 2.F * (gamma - chart_heading_));
  }
}

ThrustAxis unit_derivatives(const Vec3& force, const Vec3& force_rate, const Vec3& force_acceleration) {
  const float r = force.norm();
  const Vec3 n = force / r;
  const float r1 = n.dot(force_rate);
  const Vec3 n1 = (force_rate - n * r1) / r;
  const float r2 = n1.dot(force_rate) + n.dot(force_acceleration);
  return {n, n1, (force_acceleration - 2.F * n1 * r1 - n * r2) / r};
}

ForceAttitude least_rotation(const Vec3& n, const Vec3& n1, const Vec3& n2) {
  const float d = 1.F + n.z();
  const float twist = n.y() * n1.x() - n.x() * n1.y(), twist_rate = n.y() * n2.x() - n.x() * n2.y();
  const float c = n1.z() / d, c_rate = n2.z() / d - c * c;  // (n3'/D) and its derivative
  ForceAttitude a;
  a.q_WD = normalised({d, -n.y(), n.x(), 0.F});
  a.w_WD_D = {-n1.y() + n.y() * c, n1.x() - n.x() * c, twist / d};
  a.dw_WD_D = {-n2.y() + n1.y() * c + n.y() * c_rate, n2.x() - n1.x() * c - n.x() * c_rate,
               (twist_rate - twist * c) / d};
  return a;
}

// A constant half turn on the left changes no body rate: chart A of the turned n, turned back.
ForceAttitude least_rotation_inverted(const Vec3& n, const Vec3& n1, const Vec3& n2, float gamma) {
  const Quat half_turn{0.F, cosine(gamma), sine(gamma), 0.F};
  ForceAttitude a = least_rotation(rotate(half_turn, n), rotate(half_turn, n1), rotate(half_turn, n2));
  a.q_WD = half_turn * a.q_WD;
  return a;
}

ForceAttitude with_yaw(const ForceAttitude& attitude, float yaw, float yaw_rate, float yaw_acceleration) {
  const Quat turn = about_z(yaw);
  const Vec3 w = rotate(conj(turn), attitude.w_WD_D);
  const Vec3 dw = rotate(conj(turn), attitude.dw_WD_D);
  return {attitude.q_WD * turn, w + Vec3(0.F, 0.F, yaw_rate),
          dw + yaw_rate * Vec3(w.y(), -w.x(), 0.F) + Vec3(0.F, 0.F, yaw_acceleration)};
}

}  // namespace halfroll
