// What the links ask of the autopilot, and what they get. The decision whether a wish fits the moment is made here;
// how it was encoded is commands.cpp's business.
#include <cmath>

#include "autopilot.hpp"
#include "core/quaternion.hpp"
#include "link/echo.hpp"
#include "link/sentence.hpp"

namespace halfroll {
namespace {

using link::CommandResult;
using link::Sentence;
using link::Severity;

constexpr float kUprightCosine = 0.7071F;     // within 45 deg
constexpr float kStillSpeed = 0.5F;           // [m/s]
constexpr float kStillRate = 0.5F;            // [rad/s]
constexpr float kRepositionFarthest = 10e3F;  // [m]
constexpr float kTakeoffLowest = 0.5F, kTakeoffHighest = 500.F;  // [m] above home

Requester requester(const link::Header& header) {
  return header.sender.component == link::kGroundComponent ? Requester::kGroundStation : Requester::kUser;
}

std::uint32_t source_of(const link::Header& h) {
  return (std::uint32_t{h.sender.system} << 24U) | (std::uint32_t{h.sender.component} << 16U) |
         (std::uint32_t{h.from.link} << 8U) | h.from.slot;
}

}  // namespace

LinkOutputs Autopilot::service(const LinkInputs& in) {
  exchange(in);
  missions_.step(mission_situation(), outbox_);
  streams_.service(in.wall_us, status(), outbox_);
  return finish(in);
}

void Autopilot::exchange(const LinkInputs& in) {
  outbox_.begin(static_cast<std::uint8_t>(params_.system_id), t_us_);
  if (in.stored.slot == link::StorageSlot::kMission) missions_.stored(in.stored.ok, mission_situation(), outbox_);
  if (in.stored.slot == link::StorageSlot::kParams) param_service_.stored(in.stored.ok, in.wall_us, outbox_);
  for (std::size_t i = 0; i < in.rx_count; ++i) {
    const link::Datagram& datagram = in.rx[i];
    link::Parser& parser = parsers_[datagram.from.link % link::kLinkCount][datagram.from.slot % 9U];
    parser.parse(datagram, [&](const link::Received& received) { receive(received, in.wall_us); });
  }
}

LinkOutputs Autopilot::finish(const LinkInputs& in) {
  param_service_.service(in.wall_us, params_, outbox_);
  missions_.set_current(runner_.current());
  streams_.show_changes(status(), outbox_);
  LinkOutputs out;
  out.store = missions_.take_storage();
  if (out.store.slot == link::StorageSlot::kNone && param_service_.save_due(in.wall_us)) out.store = param_service_.save(params_);
  out.tx = outbox_.frames();
  out.tx_count = outbox_.size();
  out.shut_down = shut_down_;
  out.reboot = reboot_;
  return out;
}

void Autopilot::ask_time() {
  outbox_.begin(static_cast<std::uint8_t>(params_.system_id), t_us_);
  time_asked_ns_ = static_cast<std::int64_t>(t_us_) * 1000;
  time_answered_ = false;
  outbox_.send({0, 0}, link::Timesync{0, time_asked_ns_});
}

void Autopilot::receive(const link::Received& received, std::uint64_t wall_us) {
  const link::Header& header = received.header;
  if (!link::is_for_us(header, static_cast<std::uint8_t>(params_.system_id))) return;
  const bool from_ground = header.sender.component == link::kGroundComponent;
  if (from_ground) ++ground_frames_;
  const link::MissionSituation mission = mission_situation();

  struct Dispatch {
    Autopilot& self;
    const link::Header& from;
    const link::MissionSituation& mission;
    std::uint64_t wall_us;
    bool from_ground;

    void operator()(const link::Command& m) const { self.receive_command(m, from, wall_us); }
    void operator()(const link::SetMode& m) const { self.apply(link::read_set_mode(m), from, wall_us); }
    void operator()(const link::SetGlobalOrigin& m) const { self.apply(link::read_set_origin(m), from, wall_us); }
    void operator()(const link::ParamRequestList& m) const { self.param_service_.receive(m, from, wall_us); }
    void operator()(const link::ParamRequestRead& m) const {
      self.param_service_.receive(m, from, self.params_, self.outbox_);
    }
    void operator()(const link::ParamSet& m) const {
      self.param_service_.receive(m, from, self.armed_, wall_us, self.params_, self.outbox_);
    }
    void operator()(const link::MissionSetCurrent& m) const {
      if (m.seq < self.count()) {
        self.runner_.set_current(m.seq);
        self.outbox_.send(link::kToAll, link::Telemetry{link::msg::kMissionCurrent, self.status()});
      } else {
        self.outbox_.say(Severity::kWarning, Sentence("Mission: no item ", m.seq).text());
      }
    }
    void operator()(const link::SetAttitudeTarget& m) const {
      const LinkSetpoint setpoint{m.q_WD, m.w_WD_D, m.thrust, m.type_mask, m.time_boot_ms, source_of(from), from_ground};
      const bool active = self.mode_ == Mode::kOffboard;
      if (const char* why = self.offboard_.accept(setpoint, self.t_us_, active, self.params_)) {
        self.outbox_.say(Severity::kWarning, Sentence("Offboard: setpoint dropped (", why, ")").text());
      }
    }
    void operator()(const link::PositionTarget&) const {
      self.outbox_.say(Severity::kWarning, "Offboard: setpoint dropped (position target)");
    }
    void operator()(const link::Timesync& m) const {
      if (m.tc1 != 0 && from_ground && m.ts1 == self.time_asked_ns_) self.time_answered_ = true;
      link::answer(m, from, self.t_us_, self.outbox_);
    }
    void operator()(const link::Ping& m) const { link::answer(m, from, self.outbox_); }
    void operator()(const link::FileTransfer& m) const { link::answer(m, from, self.outbox_); }
    void operator()(const link::StatusText& m) const {
      if (from_ground) self.outbox_.send(link::kToAll, m);  // the ground station speaks for us
    }
    void operator()(const link::Heartbeat&) const {}
    void operator()(const link::Unhandled&) const {}
    // Everything left is mission transfer.
    template <class M>
    void operator()(const M& m) const {
      self.missions_.receive(m, from, mission, self.outbox_);
    }
  };
  std::visit(Dispatch{*this, header, mission, wall_us, from_ground}, received.message);
}

void Autopilot::receive_command(const link::Command& command, const link::Header& header, std::uint64_t wall_us) {
  const link::Wish wish = link::read_command(command, {origin_, home_position().z(), px4_identity_, count()});
  const CommandResult result = apply(wish, header, wall_us);
  outbox_.send(header.from, link::acknowledgement(command, header, result));
  if (const auto* message = std::get_if<link::MessageWish>(&wish); message != nullptr && result == CommandResult::kAccepted) {
    streams_.send_requested(header.from, message->id, message->parameter, status(), outbox_);
  }
}

/// One overload per kind of wish: is it possible now, and then it is done.
struct Autopilot::Applying {
  Autopilot& self;
  const link::Header& header;
  std::uint64_t wall_us;

  static constexpr CommandResult kDone = CommandResult::kAccepted, kNotNow = CommandResult::kTemporarilyRejected,
                                 kNo = CommandResult::kDenied;

  bool flying() const { return self.armed_ && !self.landed_.on_ground(); }
  CommandResult not_now(const char* why) const {
    self.outbox_.say(Severity::kWarning, Sentence("Command: ", why).text());
    return kNotNow;
  }

  CommandResult operator()(const CommandResult& result) const { return result; }

  CommandResult operator()(const link::ArmWish& w) const {
    if (w.arm == self.armed_) return kDone;
    if (!w.arm) {
      if (flying() && !w.force) return not_now("flying, not disarmed");
      self.disarm();
      return kDone;
    }
    const char* why = nullptr;
    if (!self.prearm(w.force, &why)) {
      self.outbox_.say(Severity::kCritical, Sentence("Arming denied: ", why).text());
      return kNotNow;
    }
    if (!self.home_chosen_) self.set_home_here();
    self.armed_ = true;
    self.idle_s_ = 0.F;
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
    if (w.item >= 0) self.runner_.set_current(w.item);
    return self.change_mode(Mode::kMission, requester(header));
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
    const bool handed_over = self.mode_ == Mode::kOffboard && requester(header) == Requester::kGroundStation;
    if (handed_over) {
      self.runner_.take_over(seq);
      for (int i = self.runner_.take_reached(); i >= 0; i = self.runner_.take_reached()) {
        self.outbox_.send(link::kToAll, link::MissionItemReached{static_cast<std::uint16_t>(i)});
      }
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
    Vec3 to = anything ? self.estimate_.p_WB : self.follower_.stopping_point(self.params_);
    if (w.has_position) to.head<2>() = w.position.head<2>();
    if (w.has_height) to.z() = w.position.z();
    const Vec3 from_home = to - self.home_position();
    if (from_home.norm() > kRepositionFarthest || from_home.z() < 0.F) return kNo;
    const CommandResult result = self.change_mode(Mode::kHold, requester(header));
    if (result != kDone) return result;
    self.hold_position_ = to;
    if (w.has_yaw) self.hold_yaw_ = w.yaw;
    return kDone;
  }
  CommandResult operator()(const link::SpeedWish& w) const {
    if (w.kind == link::SpeedWish::Kind::kGround) self.runner_.set_speed(w.speed);
    return kDone;
  }
  CommandResult operator()(const link::YawWish& w) const {
    if (!flying() || self.mode_ != Mode::kHold) return not_now("yaw only while holding");
    self.hold_yaw_ = w.relative ? self.hold_yaw_ + w.yaw : w.yaw;
    return kDone;
  }
  CommandResult operator()(const link::HomeWish& w) const {
    if (!self.estimate_.position_valid) return not_now("no position");
    if (w.here) {
      self.set_home_here();
    } else {
      const Vec3 position = link::local_from_global(self.origin_, w.lat_degE7, w.lon_degE7, w.alt_m);
      self.home_ = link::Home{position, 0.F, w.lat_degE7, w.lon_degE7, static_cast<std::int32_t>(std::lround(w.alt_m * 1e3))};
    }
    self.home_chosen_ = true;
    return kDone;
  }
  CommandResult operator()(const link::OriginWish& w) const {
    if (self.armed_) return not_now("armed, origin kept");
    self.origin_ = {w.lat_degE7, w.lon_degE7, static_cast<double>(w.alt_mm) * 1e-3};
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
    return kDone;  // values are stored within a second of any change, so saving and reloading have nothing left to do
  }
  CommandResult operator()(const link::CalibrationWish&) const { return self.armed_ ? not_now("armed") : kDone; }
  CommandResult operator()(const link::PrearmChecksWish&) const {
    if (self.armed_) return not_now("armed");
    const char* why = nullptr;
    if (!self.prearm(false, &why)) self.outbox_.say(Severity::kWarning, Sentence("Arming denied: ", why).text());
    return kDone;
  }
  CommandResult operator()(const link::TerminationWish& w) const {
    if (!w.terminate) return kDone;
    self.disarm();
    self.terminated_ = true;
    self.outbox_.say(Severity::kEmergency, "Failsafe: terminated by command");
    return kDone;
  }
  CommandResult operator()(const link::InvertedWish&) const { return not_now("inverted hold is not flown on board yet"); }
  CommandResult operator()(const link::FlipWish&) const { return not_now("flips are not flown on board yet"); }
};

CommandResult Autopilot::apply(const link::Wish& wish, const link::Header& header, std::uint64_t wall_us) {
  return std::visit(Applying{*this, header, wall_us}, wish);
}

ModeContext Autopilot::mode_context() const {
  ModeContext c;
  c.armed = armed_;
  c.on_ground = landed_.on_ground();
  c.position_valid = estimate_.position_valid;
  c.mission_stored = count() > 0;
  c.terminated = terminated_;
  c.battery_critical = armed_ && battery_.state_of_charge < params_.battery_critical;
  c.ground_station_owns_offboard = mode_ == Mode::kOffboard && entered_by_ground_station_;
  return c;
}

CommandResult Autopilot::change_mode(Mode mode, Requester who) {
  const char* why = refuse_mode(mode_, mode, who, mode_context());
  if (why == nullptr && mode == Mode::kMission && armed_ && mode_ != Mode::kMission) why = mission_problem();
  if (why != nullptr) {
    outbox_.say(Severity::kWarning, Sentence("Mode: no ", mode_name(mode), ": ", why).text());
    return CommandResult::kTemporarilyRejected;
  }
  if (mode != mode_) enter(mode, who);
  return CommandResult::kAccepted;
}

bool Autopilot::prearm(bool forced, const char** why) {
  ArmingContext c;
  c.terminated = terminated_;
  c.attitude_valid = estimate_.attitude_valid;
  c.upright = up_axis(estimate_.q_WB).z() > kUprightCosine;
  c.still = estimate_.v_WB.norm() < kStillSpeed && estimate_.w_WB_B.norm() < kStillRate;
  c.position_valid = estimate_.position_valid;
  c.battery_sufficient = battery_.state_of_charge > params_.battery_critical;
  c.mode = mode_;
  c.mission_problem = mode_ == Mode::kMission ? mission_problem() : nullptr;
  c.uploading = missions_.uploading();
  c.params_damaged = params_damaged_;
  *why = refuse_arming(c, forced);
  return *why == nullptr;
}

/// Why the stored mission cannot be flown from here: first position too far, or a height below home or above the limit.
const char* Autopilot::mission_problem() {
  if (count() == 0) return "no mission stored";
  const Vec3 home = home_position();
  bool first_position = true;
  for (int seq = first(); seq < count(); ++seq) {
    const FlightItem flown = item(seq);
    const bool high_matters = flown.kind == ItemKind::kTakeoff || flown.kind == ItemKind::kWaypoint;
    const float height = flown.position.z() - home.z();
    const float distance = (flown.position - home).head<2>().norm();
    const char* end = nullptr;
    int amount = 0;
    if (first_position && flown.has_position && distance > params_.mission_first_distance_max) {
      amount = static_cast<int>(distance * 1e-3F);
      end = " km away";
    }
    if (end == nullptr && high_matters && height < 0.F) {
      amount = static_cast<int>(-height);
      end = " m below home";
    }
    if (end == nullptr && high_matters && height > params_.mission_altitude_max) {
      amount = static_cast<int>(height);
      end = " m above home";
    }
    if (end != nullptr) {
      problem_ = Sentence("item ", seq, " is ", amount, end).text();
      return problem_.c_str();
    }
    first_position = first_position && !flown.has_position;
  }
  return nullptr;
}

link::MissionSituation Autopilot::mission_situation() const {
  return {t_us_, std::max(1.F, params_.simulation_speed), armed_ && mission_state() == MissionState::kActive,
          static_cast<int>(params_.mission_seq0_home), params_.mission_altitude_max};
}

MissionState Autopilot::mission_state() const {
  if (count() == 0) return MissionState::kNone;
  if (runner_.complete()) return MissionState::kComplete;
  const bool ground_flies_it = mode_ == Mode::kOffboard && entered_by_ground_station_ && mission_started_;
  if (armed_ && (mode_ == Mode::kMission || ground_flies_it)) return MissionState::kActive;
  return mission_started_ ? MissionState::kPaused : MissionState::kNotStarted;
}

link::VehicleStatus Autopilot::status() const {
  link::VehicleStatus s;
  s.t_us = t_us_;
  s.px4_identity = px4_identity_;
  s.armed = armed_;
  s.mode = static_cast<link::WireMode>(mode_);
  s.intended_mode = static_cast<link::WireMode>(user_mode_);
  const bool critical = failsafe_until_us_ > t_us_;
  s.system_status = terminated_ ? link::SystemStatus::kTerminated
                    : critical  ? link::SystemStatus::kCritical
                    : armed_    ? link::SystemStatus::kActive
                                : link::SystemStatus::kStandby;
  const bool descending = mode_ == Mode::kLand || (mode_ == Mode::kReturn && !return_climbing_);
  const bool climbing = mode_ == Mode::kTakeoff;
  s.landed = static_cast<decltype(s.landed)>(landed_.on_ground() ? LandedState::kOnGround
                                             : descending        ? LandedState::kLanding
                                             : climbing          ? LandedState::kTakeoff
                                                                 : LandedState::kInAir);
  s.imu = imu_;
  s.estimate = estimate_;
  s.setpoint = setpoint_;
  s.setpoint.q_WD = reference_.q_WD;
  s.setpoint.w_WD_D = reference_.w_WD_D;
  s.setpoint_mask = setpoint_mask_;
  s.thrust_normalised = setpoint_.thrust / params_.thrust_reference;
  for (std::size_t i = 0; i < 4; ++i) s.rotor_thrust_normalised[i] = rotors_.thrust[i] / vehicle_.thrust_max;
  s.battery_voltage = battery_.voltage;
  s.state_of_charge = battery_.state_of_charge;
  s.health.battery = battery_.state_of_charge > params_.battery_critical;
  s.health.prearm_checks = estimate_.attitude_valid && estimate_.position_valid && !terminated_ && !params_damaged_;
  s.origin = origin_;
  s.home = home_;
  s.mission.current = static_cast<std::uint16_t>(runner_.current());
  s.mission.total = static_cast<std::uint16_t>(count());
  s.mission.state = static_cast<decltype(s.mission.state)>(mission_state());
  s.mission.in_mission_mode = mode_ == Mode::kMission;
  s.mission.id = missions_.id();
  return s;
}

}  // namespace halfroll
