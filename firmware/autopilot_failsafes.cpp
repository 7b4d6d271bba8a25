// What the autopilot does by itself: the table of core/failsafes against what is known of the flight.
#include <cmath>

#include "autopilot.hpp"
#include "core/constants.hpp"
#include "core/quaternion.hpp"
#include "link/sentence.hpp"

namespace halfroll {
namespace {

using link::Sentence;
using link::Severity;

constexpr std::uint64_t kFailsafeShownUs = 5000000;
constexpr std::uint64_t kPrearmUs = 100000;

/// How strong what a mode does is, as a failsafe's action.
FailsafeAction strength(Mode mode) {
  switch (mode) {
    case Mode::kLand: return FailsafeAction::kLand;
    case Mode::kReturn: return FailsafeAction::kReturn;
    case Mode::kHold: return FailsafeAction::kHold;
    case Mode::kMission: return FailsafeAction::kMission;
    default: return FailsafeAction::kNone;
  }
}

Mode mode_of(FailsafeAction action) {
  switch (action) {
    case FailsafeAction::kLand: return Mode::kLand;
    case FailsafeAction::kReturn: return Mode::kReturn;
    case FailsafeAction::kMission: return Mode::kMission;
    default: return Mode::kHold;
  }
}

}  // namespace

FailsafeInputs Autopilot::failsafe_inputs() const {
  FailsafeInputs in;
  in.flying = armed_ && !landed_.on_ground();
  in.offboard = mode_ == Mode::kOffboard;
  in.attitude_valid = estimate_.attitude_valid;
  in.position_valid = estimate_.position_valid;
  in.axis_cosine = up_axis(reference_.q_WD).dot(up_axis(estimate_.q_WB));
  in.rate_error = (reference_.w_WD_D - estimate_.w_WB_B).norm();
  in.state_of_charge = battery_.state_of_charge;
  if (ground_heard_us_) {
    const float silence_s = 1e-6F * static_cast<float>(t_us_ - *ground_heard_us_);
    in.ground_silence_s = silence_s / std::max(1.F, params_.simulation_speed);
  }
  const Vec3 from_home = estimate_.p_WB - home_position();
  in.distance = from_home.head<2>().norm();
  in.height = from_home.z();
  in.suspect_rotor = rotor_monitor_.suspect(vehicle_, params_);
  in.offboard_lost = in.offboard && armed_ && offboard_.stage(t_us_, armed_, params_) == OffboardStage::kLost;
  return in;
}

/// One 10 ms tick: what has begun is said and acted on, what has ended is said.
void Autopilot::watch() {
  if (t_us_ % kPrearmUs == 0 && !armed_) prearm_checks_pass_ = refuse_to_arm(false, kQuietly) == nullptr;
  const bool jumped = estimate_.resets != position_resets_;
  position_resets_ = estimate_.resets;
  if (jumped) outbox_.say(link::Severity::kWarning, "Failsafe: position jumped");
  if (!armed_) return;
  if (jumped || (estimate_.position_valid && !position_was_valid_)) restart_follower();  // its reference is from before
  position_was_valid_ = estimate_.position_valid;

  const FailsafeInputs in = failsafe_inputs();
  const Failsafes::Change change = failsafes_.step(in, kReferenceDt, params_);
  for (const FailsafeRow& row : kFailsafes) {
    const auto bit = static_cast<unsigned>(row.cause);
    if ((change.begun >> bit & 1U) != 0) fail_safe(row);
    if ((change.ended >> bit & 1U) != 0 && row.cause == FailsafeCause::kGroundLost) {
      outbox_.say(Severity::kInfo, "Failsafe: GCS regained");
    }
  }
  // Nothing else can be flown without a position, whoever wants it.
  if (armed_ && failsafes_.active(FailsafeCause::kPositionLost) && mode_ != Mode::kLand) {
    enter(Mode::kLand, Requester::kAutopilot);
  }

  idle_s_ = wants_to_fly() ? 0.F : idle_s_ + kReferenceDt;
  if (idle_s_ > (flown_ ? params_.disarm_after_landing : params_.disarm_before_takeoff)) disarm();
}

/// A mode gives way to the row's action if that is stronger; what cannot be flown gives way to the next stronger one.
void Autopilot::fail_safe(const FailsafeRow& row) {
  FailsafeAction action = row.action(params_);
  if (action == FailsafeAction::kTerminate) {
    outbox_.say(Severity::kEmergency, Sentence("Failsafe: ", row.words, ", terminate").text());
    return terminate();
  }
  if (action == FailsafeAction::kMission && (count() == 0 || mission_problem(kQuietly) != nullptr)) {
    action = FailsafeAction::kHold;
  }
  if (action >= FailsafeAction::kMission) {
    failsafe_until_us_ = t_us_ + kFailsafeShownUs;
    if (!estimate_.position_valid) action = FailsafeAction::kLand;
    if (action > strength(mode_)) enter(mode_of(action), Requester::kAutopilot);
    if (action == FailsafeAction::kHold && mode_ == Mode::kHold) stopping_ = true;  // wherever it was sent
  }
  announce(row, action);
}

void Autopilot::announce(const FailsafeRow& row, FailsafeAction action) {
  if (row.cause == FailsafeCause::kBatteryLow) return outbox_.say(Severity::kWarning, "Battery low");
  const Severity severity = action > FailsafeAction::kWarn ? Severity::kCritical : Severity::kWarning;
  const bool acts = action > FailsafeAction::kWarn && row.cause != FailsafeCause::kGroundLost;
  const char* comma = acts ? ", " : "";
  const char* mode = acts ? mode_name(mode_) : "";
  if (row.cause == FailsafeCause::kRotor) {
    return outbox_.say(severity, Sentence("Failsafe: rotor ", failsafes_.faulty_rotor(), comma, mode).text());
  }
  outbox_.say(severity, Sentence("Failsafe: ", row.words, comma, mode).text());
}

/// Motors off until the next boot.
void Autopilot::terminate() {
  disarm();
  terminated_ = true;
}

/// An item that only now turns out to be unflyable: home has moved, or a limit was changed in flight.
bool Autopilot::hold_before_unflyable_item(const FollowerTarget& target) {
  const float height = target.position.z() - home_position().z();
  const bool flyable = height > -kTakeoffReached && height <= params_.mission_altitude_max + kTakeoffReached;
  if (flyable) return false;
  outbox_.say(Severity::kCritical, Sentence("Mission: item ", runner_.current(), " not flyable, Hold").text());
  failsafe_until_us_ = t_us_ + kFailsafeShownUs;
  enter(Mode::kHold, Requester::kAutopilot);
  return true;
}

}  // namespace halfroll
