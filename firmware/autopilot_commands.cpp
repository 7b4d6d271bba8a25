// What commands ask for: possible now? then done. How a wish was encoded is link/commands' business.
#include <cmath>

#include "autopilot.hpp"
#include "link/sentence.hpp"

namespace halfroll {
namespace {

using link::CommandResult;
using link::Sentence;
using link::Severity;

constexpr float kHoveringSpeed = 0.5F;                           // [m/s]
constexpr float kRepositionFarthest = 10e3F;                     // [m]
constexpr float kTakeoffLowest = 0.5F, kTakeoffHighest = 500.F;  // [m] above home

Requester requester(const link::Header& header) {
  return header.sender.component == link::kGroundComponent ? Requester::kGroundStation : Requester::kUser;
}

}  // namespace

/// One overload per kind of wish: is it possible now, and then it is done.
struct Autopilot::Applying {
  Autopilot& self;
  const link::Header& header;
  std::uint64_t wall_us;

  static constexpr CommandResult kDone = CommandResult::kAccepted, kNotNow = CommandResult::kTemporarilyRejected,
                                 kNo = CommandResult::kDenied;

  bool flying() const { return self.armed_ && !self.landed_.on_ground(); }
  template <class... Parts>
  CommandResult not_now(Parts... why) const {
    self.outbox_.say(Severity::kWarning, Sentence("Command: ", why...).text());
    return kNotNow;
  }
  float height() const { return self.estimate_.p_WB.z() - self.home_position().z(); }

  /// Why the body cannot be turned over here and now, or nullptr. Fixed-pitch rotors push one way only.
  const char* cannot_turn_over() const {
    if (self.vehicle_.rotor_kind == RotorKind::kFixedPitch) return "rotors of fixed pitch cannot fly inverted";
    if (!flying() || self.mode_ != Mode::kHold) return "only while holding";
    if (self.manoeuvre_.active()) return "another manoeuvre is flown";
    if (self.stopping_ || self.estimate_.v_WB.norm() > kHoveringSpeed) return "not hovering yet";
    return nullptr;
  }

  CommandResult operator()(const CommandResult& result) const { return result; }

  CommandResult operator()(const link::ArmWish& w) const {
    if (w.arm == self.armed_) return kDone;
    if (!w.arm) {
      if (flying() && !w.force) return not_now("flying, not disarmed");
      self.disarm();
      return kDone;
    }
    if (const char* why = self.refuse_to_arm(w.force, kAloud)) {
      self.outbox_.say(Severity::kCritical, Sentence("Arming denied: ", why).text());
      return kNotNow;
    }
    if (!self.home_chosen_) self.set_home(self.estimate_.p_WB);
    self.armed_ = true;
    self.idle_s_ = 0.F;
    if (self.mode_ == Mode::kOffboard) self.offboard_.enter(self.t_us_);  // its first setpoint is due from now on
    if (self.mode_ == Mode::kMission) self.enter(Mode::kMission, Requester::kAutopilot);
    return kDone;
  }
  CommandResult operator()(const link::ModeWish& w) const {
    return self.change_mode(static_cast<Mode>(w.mode), requester(header));
  }
  CommandResult operator()(const link::TakeoffWish& w) const {
    const float height = w.height.value_or(self.params_.takeoff_altitude);
    if (!(height >= kTakeoffLowest && height <= kTakeoffHighest)) return kNo;
    const CommandResult result = self.change_mode(Mode::kTakeoff, requester(header));
    if (result == kDone) self.takeoff_height_ = height;
    return result;
  }
  CommandResult operator()(const link::LandWish&) const {
    return flying() ? self.change_mode(Mode::kLand, requester(header)) : not_now("not flying");
  }
  CommandResult operator()(const link::ReturnWish&) const { return self.change_mode(Mode::kReturn, requester(header)); }
  CommandResult operator()(const link::MissionStartWish& w) const {
    const CommandResult result = self.change_mode(Mode::kMission, requester(header));
    if (result == kDone && w.item >= 0) self.runner_.set_current(w.item);
    return result;
  }
  CommandResult operator()(const link::PauseWish&) const {
    const MissionState state = self.mission_state();
    if (state != MissionState::kActive && state != MissionState::kPaused) return not_now("no mission to pause");
    return self.change_mode(Mode::kHold, requester(header));
  }
  CommandResult operator()(const link::ContinueWish&) const {
    const MissionState state = self.mission_state();
    if (state != MissionState::kActive && state != MissionState::kPaused) return not_now("no mission to continue");
    return self.change_mode(Mode::kMission, requester(header));
  }
  CommandResult operator()(const link::MissionCurrentWish& w) const {
    if (self.count() == 0) return not_now("no mission stored");
    const int seq = w.seq < 0 ? self.runner_.current() : w.seq;
    const bool owner = self.mode_context().ground_station_owns_offboard;
    if (requester(header) == Requester::kGroundStation) {
      if (!owner) return not_now("the ground station does not fly this mission");
      self.runner_.take_over(seq);
    } else if (w.reset) {
      self.runner_.set_current_and_clear_jumps(seq);
    } else {
      self.runner_.set_current(seq);
    }
    self.outbox_.send(link::kToAll, link::Telemetry{link::msg::kMissionCurrent, self.status()});
    return kDone;
  }
  CommandResult operator()(const link::RepositionWish& w) const {
    if (!flying()) return not_now("not flying");
    if (self.mode_ != Mode::kHold && !w.change_to_hold) return not_now("not in Hold");
    const bool anything = w.has_position || w.has_height;
    Vec3 to = self.estimate_.p_WB;
    if (w.has_position) to.head<2>() = w.position.head<2>();
    if (w.has_height) to.z() = w.position.z();
    if (self.manoeuvre_.active()) return not_now("a manoeuvre is flown");
    const Vec3 from_home = to - self.home_position();
    if (self.inverted_ && from_home.z() < self.params_.inverted_height_min) return not_now("inverted, too low");
    if (from_home.norm() > kRepositionFarthest || from_home.z() < 0.F) return kNo;
    if (anything && fence_forbids(from_home.head<2>().norm(), from_home.z(), self.params_)) {
      return not_now("outside the fence");
    }
    const CommandResult result = self.change_mode(Mode::kHold, requester(header));
    if (result != kDone) return result;
    self.stopping_ = !anything;
    if (anything) {
      self.hold_position_ = to;
      self.recovery_ = Recovery::kNone;
    }
    if (w.has_yaw) self.hold_yaw_ = w.yaw;
    return kDone;
  }
  CommandResult operator()(const link::SpeedWish& w) const {
    if (w.kind == link::SpeedWish::Kind::kGround) self.runner_.set_speed(w.speed);
    return kDone;
  }
  CommandResult operator()(const link::YawWish& w) const {
    if (!flying() || self.mode_ != Mode::kHold) return not_now("yaw only while holding");
    if (self.inverted_ || self.manoeuvre_.active()) return not_now("yaw only while upright");
    self.hold_yaw_ = w.relative ? self.hold_yaw_ + w.yaw : w.yaw;
    return kDone;
  }
  CommandResult operator()(const link::HomeWish& w) const {
    if (!self.estimate_.position_valid) return not_now("no position");
    if (w.here) {
      self.set_home(self.estimate_.p_WB);
    } else {
      self.home_ = link::home_given(self.origin_, {w.lat_degE7, w.lon_degE7, w.alt_mm});
    }
    self.home_chosen_ = true;
    return kDone;
  }
  CommandResult operator()(const link::OriginWish& w) const {
    if (self.armed_) return not_now("armed, origin kept");
    self.origin_ = {w.lat_degE7, w.lon_degE7, w.alt_mm};
    self.home_.reset();
    self.outbox_.send(link::kToAll, link::Telemetry{link::msg::kGpsGlobalOrigin, self.status()});
    return kDone;
  }
  CommandResult operator()(const link::IntervalWish& w) const {
    return self.streams_.set_interval(header.from.link, w.id, w.interval_us);
  }
  CommandResult operator()(const link::IntervalQuery& w) const {
    const std::optional<std::int32_t> interval = self.streams_.interval_us(header.from.link, w.id);
    if (!interval) return kNo;
    self.outbox_.send(header.from, link::MessageInterval{static_cast<std::uint16_t>(w.id), *interval});
    return kDone;
  }
  CommandResult operator()(const link::MessageWish& w) const {
    const CommandResult result = self.streams_.can_send(w.id, w.parameter, self.status());
    return result == kNo && w.old_command ? kNotNow : result;
  }
  CommandResult operator()(const link::PowerWish& w) const {
    if (w.kind == link::PowerWish::Kind::kNothing) return kDone;
    if (self.armed_) return not_now("armed, stays on");
    (w.kind == link::PowerWish::Kind::kReboot ? self.reboot_ : self.shut_down_) = true;
    return kDone;
  }
  CommandResult operator()(const link::ParamStorageWish& w) const {
    using Kind = link::ParamStorageWish::Kind;
    if (w.kind == Kind::kReset) {
      if (self.armed_) return not_now("armed, parameters kept");
      self.param_service_.reset(self.params_, wall_us);
    }
    if (w.kind == Kind::kReload && self.armed_) return not_now("armed, parameters kept");
    if (w.kind == Kind::kSave || w.kind == Kind::kReset) {
      self.params_damaged_ = false;  // a person has seen that they are the defaults, and says that they are right
      self.param_service_.touch(wall_us);
    }
    return kDone;  // values are stored within a second of any change, so saving and reloading have nothing left to do
  }
  CommandResult operator()(const link::CalibrationWish&) const { return self.armed_ ? not_now("armed") : kDone; }
  CommandResult operator()(const link::PrearmChecksWish&) const {
    if (self.armed_) return not_now("armed");
    const char* why = self.refuse_to_arm(false, kAloud);
    if (why != nullptr) self.outbox_.say(Severity::kWarning, Sentence("Arming denied: ", why).text());
    return kDone;
  }
  CommandResult operator()(const link::TerminationWish& w) const {
    if (!w.terminate) return kDone;
    self.terminate();
    self.outbox_.say(Severity::kEmergency, "Failsafe: terminated by command");
    return kDone;
  }
  CommandResult operator()(const link::InvertedWish& w) const {
    if (flying() && self.mode_ == Mode::kHold && w.inverted == self.inverted_) return kDone;
    if (const char* why = cannot_turn_over()) return not_now(why);
    if (w.inverted && height() < self.params_.inverted_height_min) {
      return not_now("below INV_MIN_ALT, ", static_cast<int>(self.params_.inverted_height_min), " m above home");
    }
    self.turn_over(BodyAxis::kRoll, 0.5F);
    self.inverted_ = w.inverted;
    return kDone;
  }
  CommandResult operator()(const link::FlipWish& w) const {
    if (const char* why = cannot_turn_over()) return not_now(why);
    if (height() < self.params_.flip_height_min) {
      return not_now("below FLIP_MIN_ALT, ", static_cast<int>(self.params_.flip_height_min), " m above home");
    }
    const float time = Manoeuvre::duration(w.turns, self.vehicle_, self.params_);
    if (w.longest_time && time > *w.longest_time) {
      return not_now("the flip takes ", static_cast<int>(std::ceil(time * 1e3F)), " ms");
    }
    const float loss = Manoeuvre::height_loss(w.turns);
    if (w.least_height && height() - loss < *w.least_height) {
      return not_now("the flip may lose ", static_cast<int>(std::ceil(loss)), " m");
    }
    self.turn_over(static_cast<BodyAxis>(w.axis), w.turns);
    const bool ends_turned_over = std::fmod(std::abs(w.turns), 1.F) != 0.F;
    self.inverted_ = self.inverted_ != ends_turned_over;
    return kDone;
  }
};

CommandResult Autopilot::apply(const link::Wish& wish, const link::Header& header, std::uint64_t wall_us) {
  return std::visit(Applying{*this, header, wall_us}, wish);
}

}  // namespace halfroll
