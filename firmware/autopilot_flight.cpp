// How each mode flies: through the follower and the outer loop, or by the link's setpoints.
#include <cmath>

#include "autopilot.hpp"
#include "core/constants.hpp"
#include "core/quaternion.hpp"
#include "link/sentence.hpp"

namespace halfroll {
namespace {

constexpr float kHomeReached = 1.F;       // [m], horizontally, before the return descends
constexpr float kReturnNear = 5.F;        // [m], closer than this the return does not climb
constexpr float kSlowBelow = 5.F;         // [m] above home: a descent is slow
constexpr float kFastAbove = 10.F;        // [m] above home: full descent speed
constexpr float kSinkLead = 0.6F;         // [m], a descending reference is at most this far below the vehicle
constexpr float kBlindCorrection = 0.5F;  // of gravity, descending without a position
constexpr float kEitherWayAbove = 2.5F;   // [m/s]; below, the half roll that follows costs more than it saves
constexpr float kUprightBelow = 0.5F;     // [m/s], slow enough to roll upright and hold

}  // namespace

FollowerTarget Autopilot::hold_target() const {
  return {hold_position_, hold_yaw_, params_.cruise_speed, params_.climb_speed, params_.descent_speed};
}

/// Mode HOLD at a place that was the target anyway.
void Autopilot::hold_at(const Vec3& position) {
  const Vec3 there = position;  // NOLINT(performance-*): it may be hold_position_, which entering a mode moves
  enter(Mode::kHold, Requester::kAutopilot);
  hold_position_ = there;
  stopping_ = false;
}

/// Come to rest, then stay there.
void Autopilot::hold() {
  if (landed_.on_ground()) return stand_by();
  if (!stopping_) return fly_to(hold_target());
  if (recovery_ != Recovery::kNone) {
    const float most = 4.F * vehicle_.thrust_max / vehicle_.mass;  // sideways, while the rotors carry the weight
    follower_.recover(kReferenceDt, std::sqrt(std::max(most * most - kGravity * kGravity, 1.F)), params_);
  } else {
    follower_.brake(kReferenceDt, params_);
  }
  const bool fast = estimate_.v_WB.norm() > kUprightBelow;
  stopping_ = !follower_.at_rest() || (recovery_ == Recovery::kEitherWayUp && fast);
  if (!stopping_) recovery_ = Recovery::kNone;
  hold_position_ = follower_.reference().position;
  fly_reference();
}

/// Half rolls and flips begin and end where HOLD hovers.
void Autopilot::turn_over(BodyAxis axis, float turns) {
  manoeuvre_.start(estimate_.q_WB, hold_position_, axis, turns, vehicle_, params_);
}

/// A manoeuvre that fails is left to the recovery that everything on board ends in: upright, stop, hold.
void Autopilot::fly_manoeuvre() {
  const Vec3 start = hold_position_;
  setpoint_ = manoeuvre_.step(estimate_, t_us_, vehicle_, params_);
  setpoint_mask_ = 0;
  if (manoeuvre_.on_course() && manoeuvre_.active()) return;
  restart_follower();
  if (!manoeuvre_.on_course()) {
    manoeuvre_.stop();
    inverted_ = false;
    outbox_.say(link::Severity::kWarning, "Command: manoeuvre failed, recovering");
  } else if (mode_ == Mode::kHold) {
    hold_position_ = start;
    stopping_ = false;
  }
}

/// On the ground with nothing to fly: references wait where the vehicle stands.
void Autopilot::stand_by() {
  follower_.start(estimate_.p_WB, Vec3::Zero(), heading_after_levelling(estimate_.q_WB));
  hold_position_ = estimate_.p_WB;
  hold_yaw_ = follower_.reference().yaw;
  stopping_ = false;
  recovery_ = Recovery::kNone;
  outer_loop_.reset(estimate_.q_WB);
  setpoint_ = Setpoint{};
  setpoint_.t_us = t_us_;
  setpoint_.q_WD = estimate_.q_WB;
  setpoint_mask_ = 0;
}

/// Through the on-board follower and the outer loop; the reference is known only now, so leads extrapolate it.
void Autopilot::fly_to(const FollowerTarget& target) {
  follower_.step(target, kReferenceDt, params_);
  fly_reference();
}

void Autopilot::fly_reference() {
  const FlatReference& reference = follower_.reference();
  const float mid_age = 0.5F * kReferenceDt;
  OuterLoopInput in;
  in.t_us = t_us_;
  in.state = estimate_;
  in.at_sample = reference;
  in.now = reference;
  in.lead_acceleration = reference.acceleration + reference.jerk * (params_.actuator_lead + mid_age);
  in.mid_age = mid_age;
  in.sigma = inverted_ ? -1.F : 1.F;
  in.sigma_event_near = recovery_ == Recovery::kEitherWayUp;  // the axis' sign by continuity, from the body's
  in.on_ground = landed_.on_ground();
  setpoint_ = outer_loop_.step(in, params_);
  setpoint_mask_ = 0;
}

/// Straight down over the target, slowly near the ground, until landed.
void Autopilot::descend(FollowerTarget target) {
  if (landed_.on_ground()) return stand_by();
  const float height = estimate_.p_WB.z() - home_position().z();
  const float share = std::clamp((height - kSlowBelow) / (kFastAbove - kSlowBelow), 0.F, 1.F);
  target.speed_down = params_.land_speed + share * std::max(0.F, params_.descent_speed - params_.land_speed);
  const float reference_z = follower_.reference().position.z();
  const bool leading = reference_z < estimate_.p_WB.z() - kSinkLead;
  target.position.z() = leading ? reference_z : reference_z - 10.F;
  fly_to(target);
}

/// MISSION_ITEM_REACHED of what was completed, a few a tick: a long mission must not flood the link.
void Autopilot::report_reached() {
  constexpr int kPerTick = 16;
  for (int n = 0; n < kPerTick; ++n) {
    const int seq = runner_.take_reached();
    if (seq < 0 || seq >= count()) return;
    outbox_.send(link::kToAll, link::MissionItemReached{static_cast<std::uint16_t>(seq)});
    const link::OnBoard part = link::on_board(missions_.items()[seq]);
    if (mode_ == Mode::kOffboard || part == link::OnBoard::kFull) continue;
    const char* what = part == link::OnBoard::kSkipped ? " skipped" : " attitude not flown";
    outbox_.say(link::Severity::kNotice, link::Sentence("Mission: item ", seq, what).text());
  }
}

void Autopilot::fly_mission() {
  mission_started_ = true;
  const MissionStep step = runner_.step(*this, estimate_, follower_.reference(), home_position(), landed_.on_ground(),
                                        kReferenceDt, params_);
  if (step.set_home) {
    set_home(step.home);
    return fly_to(step.target);
  }
  if (step.return_home) return enter(Mode::kReturn, Requester::kAutopilot);
  if (step.complete) {
    hold_at(hold_position_);
    return hold();
  }
  if (step.descend) {
    hold_position_ = step.target.position;
    return descend(step.target);
  }
  if (hold_before_unflyable_item(step.target)) return hold();
  hold_position_ = step.target.position;
  fly_to(step.target);
}

/// Climb if far, cross, descend over home.
void Autopilot::fly_return() {
  FollowerTarget target = hold_target();
  const Vec3 home = home_position();
  const Vec3 away = estimate_.p_WB - home;
  const bool near = away.head<2>().norm()<kReturnNear, high = away.z()> params_.return_altitude - kTakeoffReached;
  return_climbing_ = return_climbing_ && !near && !high;
  if (return_climbing_) {
    target.position.z() = home.z() + params_.return_altitude;
    return fly_to(target);
  }
  target.position.x() = home.x();
  target.position.y() = home.y();
  if (away.head<2>().norm() < kHomeReached) return descend(target);
  fly_to(target);
}

/// A fresh setpoint counts from the millisecond it comes, and so does a loss; one that is ageing loses its rates first.
void Autopilot::follow_link() {
  const OffboardStage stage = offboard_.stage(t_us_, armed_, params_);
  const bool just_lost = stage == OffboardStage::kRecovering && offboard_stage_ != stage;
  if (just_lost && !offboard_.is_position()) return fly_offboard();  // at speed the rest of a tick is centimetres
  if (stage != OffboardStage::kTracking && stage != OffboardStage::kNoRates) return;
  if (offboard_.is_position()) return;
  manoeuvre_.stop();  // rolling upright from inverted hold: the stream decides now
  setpoint_ = offboard_.setpoint();
  setpoint_mask_ = offboard_.type_mask();
  if (stage == OffboardStage::kNoRates) setpoint_.w_WD_D = Vec3::Zero();
}

/// A place alone is flown to like any other; with speeds or accelerations the setpoint itself is tracked.
void Autopilot::fly_position() {
  const PositionSetpoint setpoint = offboard_.position_setpoint(t_us_);
  const auto& p = setpoint.position_used;
  if (p[0] && p[1] && p[2] && !setpoint.has_velocity() && !setpoint.has_acceleration() && !setpoint.yaw_rate_used) {
    FollowerTarget target = hold_target();
    target.position = setpoint.position;
    if (setpoint.yaw_used) target.yaw = setpoint.yaw;
    return fly_to(target);
  }
  follower_.track(setpoint, kReferenceDt, params_);
  hold_yaw_ = follower_.reference().yaw;
  fly_reference();
}

/// What OFFBOARD is without good setpoints: hold, recover, give up.
void Autopilot::fly_offboard() {
  const OffboardStage before = offboard_stage_;
  offboard_stage_ = offboard_.stage(t_us_, armed_, params_);
  switch (offboard_stage_) {
    case OffboardStage::kTracking:
    case OffboardStage::kNoRates:
      if (before == OffboardStage::kRecovering) outbox_.say(link::Severity::kInfo, "Offboard: setpoints regained");
      recovery_ = Recovery::kNone;
      if (offboard_.is_position()) return fly_position();
      restart_follower();  // ready to take over from here
      return;
    case OffboardStage::kRecovering:
      if (before != offboard_stage_) {
        if (offboard_.is_position()) {
          stopping_ = true;
        } else {
          start_recovery();
        }
        outbox_.say(link::Severity::kWarning, "Offboard: setpoints lost, recovering");
      }
      break;
    case OffboardStage::kWaiting: break;
    case OffboardStage::kNeverStarted:
      outbox_.say(link::Severity::kWarning, "Offboard: no setpoints");
      enter(Mode::kHold, Requester::kAutopilot);
      break;
    case OffboardStage::kLost: break;  // the failsafes end it
  }
  hold();
}

/// Level, sinking at landing speed by dead reckoning; attitude and vertical speed are still known for a while.
void Autopilot::land_without_position() {
  outer_loop_.reset(estimate_.q_WB);
  setpoint_ = Setpoint{};
  setpoint_.t_us = t_us_;
  setpoint_.q_WD = about_z(heading_after_levelling(estimate_.q_WB));
  const float correction = params_.pos_kd_z * (-params_.land_speed - estimate_.v_WB.z());
  const float most = kBlindCorrection * kGravity;
  setpoint_.thrust = vehicle_.mass * (kGravity + std::clamp(correction, -most, most));
}

/// Rotors that push both ways brake upside down as well as upright: at speed the attitude that is nearer is taken, if
/// there is height for rolling upright afterwards.
void Autopilot::start_recovery() {
  restart_follower();
  const bool both_ways = vehicle_.rotor_kind == RotorKind::kVariablePitch;
  const bool high = estimate_.p_WB.z() - home_position().z() > params_.inverted_height_min;
  const bool fast = estimate_.v_WB.norm() > kEitherWayAbove;
  recovery_ = both_ways && high && fast ? Recovery::kEitherWayUp : Recovery::kUpright;
}

/// References start again from the present motion and come to rest from there.
void Autopilot::restart_follower() {
  follower_.start(estimate_.p_WB, estimate_.v_WB, heading_after_levelling(estimate_.q_WB));
  outer_loop_.reset(estimate_.q_WB);
  hold_position_ = estimate_.p_WB;
  hold_yaw_ = follower_.reference().yaw;
  stopping_ = true;
}

}  // namespace halfroll
