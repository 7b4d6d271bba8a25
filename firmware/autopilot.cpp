// The loop on one page (step), and who flies in each mode (navigate). Messages are in autopilot_link.cpp.
#include "autopilot.hpp"

#include <cmath>
#include <cstring>

#include "core/attitude.hpp"
#include "core/constants.hpp"
#include "core/mixer.hpp"
#include "core/quaternion.hpp"
#include "core/setpoint.hpp"
#include "link/sentence.hpp"

namespace halfroll {
namespace {

constexpr float kHomeReached = 1.F;       // [m], horizontally, before the return descends
constexpr float kReturnNear = 5.F;        // [m], closer than this the return does not climb
constexpr float kSlowBelow = 5.F;         // [m] above home: a descent is slow
constexpr float kFastAbove = 10.F;        // [m] above home: full descent speed
constexpr float kSinkLead = 0.6F;         // [m], a descending reference is at most this far below the vehicle
constexpr float kBlindCorrection = 0.5F;  // of gravity, descending without a position
constexpr std::uint64_t kFailsafeShownUs = 5000000;
constexpr std::uint64_t kPrearmUs = 100000;

}  // namespace

Autopilot::Autopilot(const Vehicle& vehicle, const Params& params, const Boot& boot)
    : vehicle_(vehicle),
      params_(params),
      px4_identity_(boot.px4_identity),
      outer_loop_(vehicle),
      origin_(link::origin_at(boot.origin_lat_deg, boot.origin_lon_deg, boot.origin_alt_m)),
      param_service_(params) {
  outbox_.begin(static_cast<std::uint8_t>(params_.system_id), 0);
  params_damaged_ =
      param_service_.load(boot.stored_params, boot.stored_params_size, params_) == link::ParamLoad::kDamaged;
  if (params_damaged_) outbox_.say(link::Severity::kCritical, "Params: stored file damaged, defaults in use");
  if (!missions_.load(boot.stored_mission, boot.stored_mission_size)) {
    outbox_.say(link::Severity::kCritical, "Mission: stored file damaged, none loaded");
  }
  runner_.reset(first());
}

Outputs Autopilot::step(const Inputs& in) {
  t_us_ = started_ ? t_us_ + kStepUs : 0;
  started_ = true;
  exchange(in.link);  // commands, missions, setpoints
  imu_ = in.measured.imu;
  battery_ = in.battery;
  Measurements measured = in.measured;
  measured.pose = pose_source_.choose(t_us_, in.measured.pose, linked_pose_, params_);
  linked_pose_.reset();
  estimate_ = estimator_.step(t_us_, measured, armed_ && !landed_.on_ground(), params_);
  if (t_us_ % kReferenceUs == 0) navigate();                       // 100 Hz: mode -> setpoint_
  if (mode_ == Mode::kOffboard) follow_link();                     // at once: link -> setpoint_
  reference_ = extrapolate(setpoint_, estimate_, t_us_, params_);  // to this millisecond
  const Wrench wanted = attitude_wrench(estimate_.q_WB, estimate_.w_WB_B, reference_, vehicle_, params_);
  const Allocation given = allocate(wanted, vehicle_);  // inside the rotor limits
  if (wants_to_fly()) {
    rotors_ = rotor_lag_inverse_.step(given.rotors, vehicle_, params_);
  } else {
    rotor_lag_inverse_.reset();
    const float idle = armed_ ? std::max(vehicle_.thrust_min, 0.F) : 0.F;
    rotors_.thrust = {idle, idle, idle, idle};
  }
  missions_.step(mission_situation(), outbox_);
  streams_.step(status(), outbox_);
  return {rotors_, finish(in.link)};
}

bool Autopilot::wants_to_fly() const {
  if (!armed_) return false;
  if (!landed_.on_ground()) return true;
  const bool tracking = offboard_stage_ == OffboardStage::kTracking || offboard_stage_ == OffboardStage::kNoRates;
  return mode_ == Mode::kTakeoff || mode_ == Mode::kMission || (mode_ == Mode::kOffboard && tracking);
}

/// One 10 ms tick: where are we, does anything force another mode, and what does this mode want to fly?
void Autopilot::navigate() {
  landed_.step(estimate_, reference_.thrust * up_axis(estimate_.q_WB).z(), vehicle_.mass * kGravity, armed_);
  flown_ = flown_ || (armed_ && !landed_.on_ground());
  if (!home_ && estimate_.position_valid) set_home(estimate_.p_WB);
  watch();
  report_reached();

  if (!armed_) return stand_by();
  switch (mode_) {
    case Mode::kHold: hold(); break;
    case Mode::kTakeoff: {
      FollowerTarget target = hold_target();
      target.position.z() = home_position().z() + takeoff_height_;
      fly_to(target);
      if (std::abs(target.position.z() - estimate_.p_WB.z()) < kTakeoffReached) hold_at(target.position);
      break;
    }
    case Mode::kMission: fly_mission(); break;
    case Mode::kReturn: fly_return(); break;
    case Mode::kLand:
      if (landed_.on_ground()) return stand_by();
      if (!estimate_.position_valid) return land_without_position();
      stopping_ ? hold() : descend(hold_target());
      break;
    case Mode::kOffboard: fly_offboard(); break;
  }
}

FollowerTarget Autopilot::hold_target() const {
  return {hold_position_, hold_yaw_, params_.cruise_speed, params_.climb_speed, params_.descent_speed};
}

/// Mode HOLD at a place that was the target anyway.
void Autopilot::hold_at(Vec3 position) {
  enter(Mode::kHold, Requester::kAutopilot);
  hold_position_ = position;
  stopping_ = false;
}

/// Come to rest, then stay there.
void Autopilot::hold() {
  if (landed_.on_ground()) return stand_by();
  if (!stopping_) return fly_to(hold_target());
  follower_.brake(kReferenceDt, params_);
  stopping_ = !follower_.at_rest();
  hold_position_ = follower_.reference().position;
  fly_reference();
}

/// On the ground with nothing to fly: references wait where the vehicle stands.
void Autopilot::stand_by() {
  follower_.start(estimate_.p_WB, Vec3::Zero(), heading_after_levelling(estimate_.q_WB));
  hold_position_ = estimate_.p_WB;
  hold_yaw_ = follower_.reference().yaw;
  stopping_ = false;
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
  hold_position_ = step.target.position;
  if (step.descend) return descend(step.target);
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

/// A fresh setpoint counts from the millisecond it comes; one that is ageing loses its rates first.
void Autopilot::follow_link() {
  const OffboardStage stage = offboard_.stage(t_us_, armed_, params_);
  if (stage != OffboardStage::kTracking && stage != OffboardStage::kNoRates) return;
  setpoint_ = offboard_.setpoint();
  setpoint_mask_ = offboard_.type_mask();
  if (stage == OffboardStage::kNoRates) setpoint_.w_WD_D = Vec3::Zero();
}

/// What OFFBOARD is without good setpoints: hold, recover, give up.
void Autopilot::fly_offboard() {
  const OffboardStage before = offboard_stage_;
  offboard_stage_ = offboard_.stage(t_us_, armed_, params_);
  switch (offboard_stage_) {
    case OffboardStage::kTracking:
    case OffboardStage::kNoRates:
      if (before == OffboardStage::kRecovering) outbox_.say(link::Severity::kInfo, "Offboard: setpoints regained");
      restart_follower();  // ready to take over from here
      return;
    case OffboardStage::kRecovering:
      if (before != offboard_stage_) {
        restart_follower();
        outbox_.say(link::Severity::kWarning, "Offboard: setpoints lost, recovering");
      }
      break;
    case OffboardStage::kWaiting: break;
    case OffboardStage::kNeverStarted:
      outbox_.say(link::Severity::kWarning, "Offboard: no setpoints");
      enter(Mode::kHold, Requester::kAutopilot);
      break;
    case OffboardStage::kLost: {
      constexpr Mode kActions[] = {Mode::kHold, Mode::kLand, Mode::kReturn, Mode::kMission};
      const Mode action = kActions[static_cast<int>(params_.offboard_loss_action)];
      const bool possible = action != Mode::kMission || count() > 0;
      fail_safe(possible ? action : Mode::kHold, "offboard lost");
      break;
    }
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

/// References start again from the present motion and come to rest from there.
void Autopilot::restart_follower() {
  follower_.start(estimate_.p_WB, estimate_.v_WB, heading_after_levelling(estimate_.q_WB));
  outer_loop_.reset(estimate_.q_WB);
  hold_position_ = estimate_.p_WB;
  hold_yaw_ = follower_.reference().yaw;
  stopping_ = true;
}

/// What makes the autopilot act by itself.
void Autopilot::watch() {
  if (t_us_ % kPrearmUs == 0 && !armed_) prearm_checks_pass_ = refuse_to_arm(false, kQuietly) == nullptr;
  const bool jumped = estimate_.resets != position_resets_;
  position_resets_ = estimate_.resets;
  if (jumped) outbox_.say(link::Severity::kWarning, "Failsafe: position jumped");
  if (!armed_) return;
  const bool flying = !landed_.on_ground();
  if (jumped || (estimate_.position_valid && !position_was_valid_)) restart_follower();  // its reference is from before
  position_was_valid_ = estimate_.position_valid;
  if (flying && !estimate_.position_valid && mode_ != Mode::kLand) fail_safe(Mode::kLand, "position lost");
  if (battery_.state_of_charge < params_.battery_low && !battery_low_said_) {
    battery_low_said_ = true;
    outbox_.say(link::Severity::kWarning, "Battery low");
  }
  const bool going_down = mode_ == Mode::kLand || mode_ == Mode::kReturn;
  if (flying && battery_.state_of_charge < params_.battery_critical && !going_down) {
    fail_safe(Mode::kLand, "battery critical");
  }

  idle_s_ = wants_to_fly() ? 0.F : idle_s_ + kReferenceDt;
  if (idle_s_ > (flown_ ? params_.disarm_after_landing : params_.disarm_before_takeoff)) disarm();
}

void Autopilot::fail_safe(Mode mode, const char* words) {
  outbox_.say(link::Severity::kCritical, link::Sentence("Failsafe: ", words, ", ", mode_name(mode)).text());
  failsafe_until_us_ = t_us_ + kFailsafeShownUs;
  enter(mode, Requester::kAutopilot);
}

void Autopilot::disarm() {
  armed_ = false;
  flown_ = false;
  idle_s_ = 0.F;
  home_chosen_ = false;
  if (mode_ != Mode::kHold) enter(Mode::kHold, Requester::kAutopilot);
}

void Autopilot::enter(Mode mode, Requester who) {
  const bool keeps_reference = mode_ != Mode::kOffboard && armed_;
  if (keeps_reference) {
    hold_position_ = follower_.reference().position;
    hold_yaw_ = follower_.reference().yaw;
    stopping_ = true;
  } else {
    restart_follower();
  }
  if (mode == Mode::kMission) {
    if (runner_.complete()) {
      runner_.reset(first());
      mission_started_ = false;
    } else {
      runner_.resume();
    }
  }
  if (mode == Mode::kOffboard) offboard_.enter(t_us_);
  offboard_stage_ = OffboardStage::kWaiting;
  return_climbing_ = mode == Mode::kReturn;
  entered_by_ground_station_ = who == Requester::kGroundStation;
  if (who == Requester::kUser) user_mode_ = mode;
  mode_ = mode;
  idle_s_ = 0.F;
}

Vec3 Autopilot::home_position() const { return home_ ? home_->position : Vec3(Vec3::Zero()); }

void Autopilot::set_home(const Vec3& position) {
  home_ = link::home_at(origin_, position, heading_after_levelling(estimate_.q_WB));
}

/// Everything that decides future commands. Wall-clock pacing and received bytes of half frames are not in it.
auto Autopilot::state() const {
  return std::tuple_cat(
      std::tie(t_us_, mode_, user_mode_, armed_, flown_, terminated_, entered_by_ground_station_, idle_s_,
               failsafe_until_us_, battery_low_said_, hold_position_, hold_yaw_, stopping_, takeoff_height_,
               return_climbing_, mission_started_, mission_revision_, offboard_stage_, position_was_valid_,
               position_resets_),
      std::tie(setpoint_.t_us, setpoint_.q_WD, setpoint_.w_WD_D, setpoint_.thrust, setpoint_.attitude_used,
               setpoint_.rate_used, setpoint_mask_, reference_.thrust, rotors_, origin_, home_, home_chosen_),
      pose_source_.state(), estimator_.state(), landed_.state(), follower_.state(), runner_.state(), offboard_.state(),
      outer_loop_.state(), rotor_lag_inverse_.state());
}

bool Autopilot::same_state(const Autopilot& other) const {
  return state() == other.state() && missions_ == other.missions_ &&
         std::memcmp(&params_, &other.params_, sizeof params_) == 0;  // all floats, no padding
}

int Autopilot::first() const {
  return link::first_is_home(missions_.items(), missions_.count(), static_cast<int>(params_.mission_seq0_home)) ? 1 : 0;
}

FlightItem Autopilot::item(int seq) const {
  const link::Datum datum{origin_, home_position().z(), params_.takeoff_altitude};
  return link::flight_item(missions_.items()[seq], datum);
}

}  // namespace halfroll
