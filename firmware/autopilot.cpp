// The loop on one page (step), who flies in each mode (navigate), and how modes are entered and left. How they fly is
// in autopilot_flight.cpp, what overrides them in autopilot_failsafes.cpp, messages in autopilot_link.cpp.
#include "autopilot.hpp"

#include <cmath>

#include "core/attitude.hpp"
#include "core/constants.hpp"
#include "core/mixer.hpp"
#include "core/quaternion.hpp"
#include "core/setpoint.hpp"
#include "link/sentence.hpp"

namespace halfroll {
namespace {

constexpr std::uint64_t kImuFailureShownUs = 500000;
constexpr float kLeaning = 0.5F;  // cosine of the tilt beyond which a stream that ends leaves nothing to fly on from
constexpr float kSinking = 1.F;   // [m/s], so does one that falls faster: what modes brake with may need more height

}  // namespace

Autopilot::Autopilot(const Vehicle& vehicle, const Params& params, const Boot& boot)
    : vehicle_(vehicle),
      params_(params),
      px4_identity_(boot.px4_identity),
      outer_loop_(vehicle),
      origin_(boot.origin),
      param_service_(params),
      signing_(boot.signing_policies, boot.signing_key, boot.unix_us_at_wall_0, boot.signing),
      unix_us_at_wall_0_(boot.unix_us_at_wall_0) {
  outbox_.begin(static_cast<std::uint8_t>(params_.system_id), 0);
  params_state_ = boot.params.state;
  mission_state_at_boot_ = boot.mission.state;
  last_words_ = boot.last_words;
  if (param_service_.load(boot.params.bytes, boot.params.size, params_) == link::ParamLoad::kDamaged) {
    params_state_ = link::StoredState::kLost;
  }
  params_damaged_ = params_state_ == link::StoredState::kLost;
  if (!missions_.load(boot.mission.bytes, boot.mission.size)) mission_state_at_boot_ = link::StoredState::kLost;
  runner_.reset(first());
}

Outputs Autopilot::step(const Inputs& in) {
  t_us_ = started_ ? t_us_ + kStepUs : 0;
  if (!started_ && unix_us_at_wall_0_ != 0) unix_us_at_boot_ = unix_us_at_wall_0_ + in.link.wall_us;
  started_ = true;
  exchange(in.link, link::kStepBytes);  // commands, missions, setpoints
  imu_ = in.measured.imu;
  battery_ = in.battery;
  Measurements measured = in.measured;
  measured.pose = pose_source_.choose(t_us_, in.measured.pose, linked_pose_, params_);
  linked_pose_.reset();
  estimate_ = estimator_.step(t_us_, measured, armed_ && !landed_.on_ground(), params_);
  if (is_plausible(imu_)) {
    rotor_monitor_.step(rotors_, estimate_.w_WB_B, imu_.specific_force_B, vehicle_);
  } else {
    imu_failed_us_ = t_us_;
  }
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
  // What clients see changes with a message or a tick of navigate().
  const bool changed = in.link.rx_count > 0 || t_us_ % kReferenceUs == 0;
  if (changed || streams_.due(t_us_)) streams_.step(status(), outbox_);
  return {rotors_, finish(in.link)};
}

bool Autopilot::imu_healthy() const { return !imu_failed_us_ || t_us_ - *imu_failed_us_ > kImuFailureShownUs; }

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
  if (manoeuvre_.active()) return fly_manoeuvre();
  const bool recovering = recovery_ != Recovery::kNone && estimate_.position_valid;
  if (recovering && mode_ != Mode::kOffboard) return hold();  // first; then what the mode is for
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

void Autopilot::disarm() {
  armed_ = false;
  flown_ = false;
  idle_s_ = 0.F;
  home_chosen_ = false;
  failsafes_.reset();
  manoeuvre_.stop();
  inverted_ = false;
  if (mode_ != Mode::kHold) enter(Mode::kHold, Requester::kAutopilot);
}

void Autopilot::enter(Mode mode, Requester who) {
  const bool recovering = recovery_ != Recovery::kNone;
  const bool keeps_reference = (mode_ != Mode::kOffboard || recovering) && armed_ && !manoeuvre_.active();
  const bool upside_down = inverted_ && !manoeuvre_.active();
  manoeuvre_.stop();
  if (upside_down && mode != Mode::kHold && estimate_.position_valid) turn_over(BodyAxis::kRoll, 0.5F);
  inverted_ = upside_down && mode == Mode::kHold;
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
  const bool stops = mode == Mode::kHold || mode == Mode::kLand;
  if (who != Requester::kAutopilot || !stops) recovery_ = Recovery::kNone;
  const bool leaning = up_axis(estimate_.q_WB).z() < kLeaning, sinking = estimate_.v_WB.z() < -kSinking;
  const bool streamed = mode_ == Mode::kOffboard && recovery_ == Recovery::kNone;
  const bool falls = (leaning || sinking) && estimate_.position_valid;
  if (streamed && falls && armed_ && !landed_.on_ground()) start_recovery();
  mode_ = mode;
  idle_s_ = 0.F;
}

Vec3 Autopilot::home_position() const { return home_ ? home_->position : Vec3(Vec3::Zero()); }

void Autopilot::set_home(const Vec3& position) {
  home_ = link::home_at(origin_, position, heading_after_levelling(estimate_.q_WB));
}

int Autopilot::first() const {
  return link::first_is_home(missions_.items(), missions_.count(), static_cast<int>(params_.mission_seq0_home)) ? 1 : 0;
}

FlightItem Autopilot::item(int seq) const {
  const link::Datum datum{origin_, home_position().z(), params_.takeoff_altitude};
  return link::flight_item(missions_.items()[seq], datum);
}

}  // namespace halfroll
