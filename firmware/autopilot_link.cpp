// Bytes in, bytes out: messages to the services they belong to, and the state that telemetry shows.
#include <cmath>
#include <limits>

#include "autopilot.hpp"
#include "core/quaternion.hpp"
#include "link/echo.hpp"
#include "link/position_targets.hpp"
#include "link/sentence.hpp"

namespace halfroll {
namespace {

using link::CommandResult;
using link::Sentence;
using link::Severity;

constexpr float kUprightCosine = 0.7071F;  // within 45 deg
constexpr float kStillSpeed = 0.5F;        // [m/s]
constexpr float kStillRate = 0.5F;         // [rad/s]
std::uint32_t source_of(const link::Header& h) {
  return (std::uint32_t{h.sender.system} << 24U) | (std::uint32_t{h.sender.component} << 16U) |
         (std::uint32_t{h.from.link} << 8U) | h.from.slot;
}

}  // namespace

LinkOutputs Autopilot::service(const LinkInputs& in) {
  exchange(in, std::numeric_limits<std::size_t>::max());
  missions_.step(mission_situation(), outbox_);
  streams_.service(in.wall_us, status(), outbox_);
  return finish(in);
}

/// At most so many bytes of each link: the shell offers no more, but the loop relies on nobody.
void Autopilot::exchange(const LinkInputs& in, std::size_t most_bytes) {
  outbox_.begin(static_cast<std::uint8_t>(params_.system_id), t_us_);
  if (in.stored.slot == link::StorageSlot::kMission) missions_.stored(in.stored.ok, mission_situation(), outbox_);
  if (in.stored.slot == link::StorageSlot::kSigning) signing_.stored(in.stored.ok);
  if (in.stored.slot == link::StorageSlot::kParams) {
    param_service_.stored(in.stored.ok, in.wall_us, outbox_);
    if (owed_) {
      owed_->answer.result = in.stored.ok ? CommandResult::kAccepted : CommandResult::kFailed;
      outbox_.send(owed_->to, owed_->answer);
      owed_.reset();
    }
  }
  std::array<std::size_t, link::kLinkCount> left;
  left.fill(most_bytes);
  for (std::size_t i = 0; i < in.rx_count; ++i) {
    const link::Datagram& datagram = in.rx[i];
    const std::size_t index = datagram.from.link % link::kLinkCount;
    link::LinkCounters& counters = counters_[index];
    if (datagram.size > left[index]) {
      left[index] = 0;
      counters.passed_over(datagram.size);
      continue;
    }
    left[index] -= datagram.size;
    link::Parser& parser = parsers_[index][datagram.from.slot % 9U];
    const std::uint32_t bad_before = parser.bad_frames();
    parser.parse(datagram, [&](const link::Received& received) {
      counters.received(received);
      if (signing_.admits(received, in.wall_us)) return receive(received, in.wall_us);
      counters.refused();
      outbox_.say(Severity::kWarning, "Signing: frames without a valid signature refused");
    });
    counters.bad(parser.bad_frames() - bad_before);
  }
  if (missions_.revision() != mission_revision_) {
    mission_revision_ = missions_.revision();
    mission_started_ = false;
    runner_.reset(first());
  }
}

LinkOutputs Autopilot::finish(const LinkInputs& in) {
  param_service_.service(in.wall_us, params_, outbox_);
  missions_.set_current(runner_.current());
  if (ask_time_now_) outbox_.send({0, 0}, link::Timesync{0, time_asked_ns_});  // last: what is answered has been sent
  ask_time_now_ = false;
  LinkOutputs out;
  out.store = missions_.take_storage();
  if (out.store.slot == link::StorageSlot::kNone && param_service_.save_due(in.wall_us))
    out.store = param_service_.save(params_);
  if (out.store.slot == link::StorageSlot::kNone) out.store = signing_.take_storage();
  for (std::size_t i = 0; i < outbox_.size(); ++i) {
    signing_.sign(outbox_.frames()[i], in.wall_us);
  }
  out.tx = outbox_.frames();
  out.tx_count = outbox_.size();
  out.shut_down = shut_down_;
  out.reboot = reboot_;
  return out;
}

void Autopilot::ask_time() {
  time_asked_ns_ = static_cast<std::int64_t>(t_us_) * 1000;
  time_answered_ = false;
  ask_time_now_ = true;
}

/// One overload per kind of message.
struct Autopilot::Dispatch {
  Autopilot& self;
  const link::Header& from;
  link::MissionSituation mission;
  std::uint64_t wall_us;
  bool from_ground;

  SetpointOrigin origin(std::uint32_t stamp_ms) const {
    return {stamp_ms, source_of(from), from_ground, self.patience(from.from)};
  }
  template <class S>
  void take(const S& setpoint) const {
    const bool active = self.mode_ == Mode::kOffboard;
    if (const char* why = self.offboard_.accept(setpoint, self.t_us_, active, self.params_)) {
      self.outbox_.say(Severity::kWarning, Sentence("Offboard: setpoint dropped (", why, ")").text());
    }
  }
  void operator()(const link::Command& m) const { self.receive_command(m, from, wall_us); }
  /// What no message answers: a refusal that has no reason of its own is told as a text.
  void obey(const link::Wish& wish, const char* refusal) const {
    if (self.apply(wish, from, wall_us) == CommandResult::kDenied) self.outbox_.say(Severity::kWarning, refusal);
  }
  void operator()(const link::SetMode& m) const { obey(link::read_set_mode(m), "Command: SET_MODE: no such mode"); }
  void operator()(const link::SetGlobalOrigin& m) const {
    obey(link::read_set_origin(m), "Command: origin refused (no place on earth)");
  }
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
    take(LinkSetpoint{m.q_WD, m.w_WD_D, m.thrust, m.type_mask, origin(m.time_boot_ms)});
  }
  void operator()(const link::ExternalPose& m) const {
    if (!link::is_pose_frame(m.frame)) {
      self.outbox_.say(Severity::kWarning, Sentence("Command: pose dropped (frame ", int{m.frame}, ")").text());
    } else if (!is_pose(m.pose)) {
      self.outbox_.say(Severity::kWarning, "Command: pose dropped (no place or no attitude)");
    } else {
      self.linked_pose_ = LinkedPose{m.pose, source_of(from)};
    }
  }
  void operator()(const link::PositionTarget& m) const {
    const link::PositionDatum datum{self.origin_, self.home_position().z(),
                                    heading_after_levelling(self.estimate_.q_WB)};
    LinkPositionSetpoint setpoint = link::read_position_target(m, datum);
    setpoint.origin = origin(m.time_boot_ms);
    take(setpoint);
  }
  void operator()(const link::Timesync& m) const {
    self.keeps_our_time_[from.from.link % link::kLinkCount] |= static_cast<std::uint16_t>(1U << (from.from.slot % 16U));
    if (m.tc1 != 0 && from_ground && m.ts1 == self.time_asked_ns_) self.time_answered_ = true;
    link::answer(m, from, self.t_us_, self.outbox_);
  }
  void operator()(const link::Ping& m) const { link::answer(m, from, self.outbox_); }
  void operator()(const link::FileTransfer& m) const { link::answer(m, from, self.outbox_); }
  void operator()(const link::StatusText& m) const {
    if (from_ground) self.outbox_.send(link::kToAll, m);  // the ground station speaks for us
  }
  void operator()(const link::Heartbeat& m) const {
    if (m.type == link::kGroundControlStation) self.ground_heard_us_ = self.t_us_;
    if (self.ground_heard_us_) self.say_boot_faults();
  }
  void operator()(const link::SetupSigning& m) const {
    if (!self.signing_.may_be_set_up(from.from.link)) return;
    if (self.armed_) return self.outbox_.say(Severity::kWarning, "Command: armed, signing key kept");
    self.signing_.set_up(m);
    self.outbox_.say(Severity::kNotice, "Command: signing key changed");
  }
  void operator()(const link::Unhandled&) const {}
  // Everything left is mission transfer.
  template <class M>
  void operator()(const M& m) const {
    self.missions_.receive(m, from, mission, self.outbox_);
  }
};

void Autopilot::receive(const link::Received& received, std::uint64_t wall_us) {
  const link::Header& header = received.header;
  if (!link::is_for_us(header, static_cast<std::uint8_t>(params_.system_id))) return;
  const bool from_ground = header.sender.component == link::kGroundComponent;
  if (from_ground) {
    ++ground_frames_;
    ground_heard_us_ = t_us_;  // by any frame: in lockstep its heartbeats follow another clock
  }
  std::visit(Dispatch{*this, header, mission_situation(), wall_us, from_ground}, received.message);
}

void Autopilot::receive_command(const link::Command& command, const link::Header& header, std::uint64_t wall_us) {
  const link::Wish wish = link::read_command(command, {origin_, home_position().z(), px4_identity_, count()});
  const auto* storage = std::get_if<link::ParamStorageWish>(&wish);
  if (storage != nullptr && storage->kind == link::ParamStorageWish::Kind::kSave && param_service_.save_at_once()) {
    owed_ = Owed{header.from, link::acknowledgement(command, header, CommandResult::kAccepted)};
    return;
  }
  const CommandResult result = apply(wish, header, wall_us);
  outbox_.send(header.from, link::acknowledgement(command, header, result));
  if (const auto* message = std::get_if<link::MessageWish>(&wish);
      message != nullptr && result == CommandResult::kAccepted) {
    streams_.send_requested(header.from, message->id, message->parameter, status(), outbox_);
  }
}

/// Once somebody is there to read it.
void Autopilot::say_boot_faults() {
  using State = link::StoredState;
  if (boot_faults_said_) return;
  boot_faults_said_ = true;
  if (last_words_.chars[0] != '\0') outbox_.say(Severity::kCritical, last_words_);
  if (params_state_ == State::kLost) outbox_.say(Severity::kCritical, "Params: stored file damaged, defaults in use");
  if (mission_state_at_boot_ == State::kLost) {
    outbox_.say(Severity::kCritical, "Mission: stored file damaged, none loaded");
  }
  if (params_state_ == State::kOtherCopyDamaged) {
    outbox_.say(Severity::kWarning, "Params: a copy was damaged, last good one in use");
  }
  if (mission_state_at_boot_ == State::kOtherCopyDamaged) {
    outbox_.say(Severity::kWarning, "Mission: a copy was damaged, last good one in use");
  }
}

ModeContext Autopilot::mode_context() const {
  ModeContext c;
  c.armed = armed_;
  c.on_ground = landed_.on_ground();
  c.position_valid = estimate_.position_valid;
  c.mission_stored = count() > 0;
  c.terminated = terminated_;
  c.battery_critical = armed_ && battery_.state_of_charge < params_.battery_critical;
  c.ground_station_owns_offboard =
      mode_ == Mode::kOffboard && offboard_.owned_by_ground_station(entered_by_ground_station_);
  return c;
}

CommandResult Autopilot::change_mode(Mode mode, Requester who) {
  const char* why = refuse_mode(mode_, mode, who, mode_context());
  if (why == nullptr && mode == Mode::kMission && armed_ && mode_ != Mode::kMission) why = mission_problem(kAloud);
  if (why != nullptr) {
    outbox_.say(Severity::kWarning, Sentence("Mode: no ", mode_name(mode), ": ", why).text());
    return CommandResult::kTemporarilyRejected;
  }
  if (mode != mode_) enter(mode, who);
  return CommandResult::kAccepted;
}

const char* Autopilot::refuse_to_arm(bool forced, bool aloud) {
  ArmingContext c;
  c.terminated = terminated_;
  c.attitude_valid = estimate_.attitude_valid;
  c.upright = up_axis(estimate_.q_WB).z() > kUprightCosine;
  c.still = estimate_.v_WB.norm() < kStillSpeed && estimate_.w_WB_B.norm() < kStillRate;
  c.position_valid = estimate_.position_valid;
  c.battery_sufficient = battery_.state_of_charge > params_.battery_critical;
  c.mode = mode_;
  c.mission_problem = mode_ == Mode::kMission ? mission_problem(aloud) : nullptr;
  c.failsafe_acting = failsafe_until_us_ > t_us_;
  c.sensors_healthy = imu_healthy();
  c.uploading = missions_.uploading();
  c.params_damaged = params_damaged_;
  return refuse_arming(c, forced);
}

/// Why the stored mission cannot be flown from here. Quietly it is judged once, until something it hangs on changes: a
/// long mission takes longer than a step should.
const char* Autopilot::mission_problem(bool aloud) {
  const MissionDatum datum{missions_.revision(),
                           home_position(),
                           origin_,
                           params_.mission_first_distance_max,
                           params_.mission_altitude_max,
                           params_.takeoff_altitude,
                           params_.mission_seq0_home,
                           params_.fence_distance,
                           params_.fence_height,
                           params_.fence_action};
  if (aloud || !(mission_judged_at_ == datum)) {
    const char* why = judge_mission(aloud);
    mission_flyable_ = why == nullptr;
    if (!mission_flyable_) problem_ = why;
    mission_judged_at_ = datum;
  }
  return mission_flyable_ ? nullptr : problem_.c_str();
}

/// First position too far, a height below home or above the limit, or a place outside the fence.
const char* Autopilot::judge_mission(bool aloud) {
  if (count() == 0) return "no mission stored";
  const Vec3 home = home_position();
  bool first_position = true;
  for (int seq = first(); seq < count(); ++seq) {
    const FlightItem flown = item(seq);
    const bool high_matters = flown.kind == ItemKind::kTakeoff || flown.kind == ItemKind::kWaypoint;
    const float height = flown.position.z() - home.z();
    const float distance = (flown.position - home).head<2>().norm();
    const bool too_far = first_position && flown.has_position && distance > params_.mission_first_distance_max;
    const bool too_low = high_matters && height < 0.F, too_high = high_matters && height > params_.mission_altitude_max;
    if (too_low || too_high) {
      const float amount = too_low ? -height : height;
      const char* end = too_low ? " m below home" : " m above home";
      problem_ = Sentence("item ", seq, " is ", static_cast<int>(amount), end).text();
    }
    if (too_far) {
      if (aloud && (too_low || too_high))
        outbox_.say(Severity::kWarning, Sentence("Mission: ", problem_.c_str()).text());
      problem_ = Sentence("item ", seq, " is ", static_cast<int>(distance * 1e-3F), " km away").text();
    }
    if (too_far || too_low || too_high) return problem_.c_str();
    if (fence_forbids(flown.has_position ? distance : 0.F, high_matters ? height : 0.F, params_)) {
      problem_ = Sentence("item ", seq, " is outside the fence").text();
      return problem_.c_str();
    }
    first_position = first_position && !flown.has_position;
  }
  return nullptr;
}

/// How many times slower than vehicle time a client's clock runs: all but those that have asked for ours keep the
/// wall's.
float Autopilot::patience(link::Endpoint client) const {
  const bool ours = (keeps_our_time_[client.link % link::kLinkCount] >> (client.slot % 16U) & 1U) != 0;
  return ours ? 1.F : std::max(1.F, params_.simulation_speed);
}

link::MissionSituation Autopilot::mission_situation() const {
  return {t_us_, std::max(1.F, params_.simulation_speed), armed_ && mission_state() == MissionState::kActive,
          static_cast<int>(params_.mission_seq0_home), params_.mission_altitude_max};
}

MissionState Autopilot::mission_state() const {
  if (count() == 0) return MissionState::kNone;
  if (runner_.complete()) return MissionState::kComplete;
  const bool ground_flies_it = mode_context().ground_station_owns_offboard && mission_started_;
  if (armed_ && (mode_ == Mode::kMission || ground_flies_it)) return MissionState::kActive;
  return mission_started_ ? MissionState::kPaused : MissionState::kNotStarted;
}

link::VehicleStatus Autopilot::status() const {
  link::VehicleStatus s;
  s.t_us = t_us_;
  s.epoch_at_boot_us = unix_us_at_boot_;
  s.px4_identity = px4_identity_;
  s.armed = armed_;
  s.mode = static_cast<link::WireMode>(mode_);
  s.intended_mode = static_cast<link::WireMode>(user_mode_);
  const bool critical = failsafe_until_us_ > t_us_ || failsafes_.acting(params_);
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
  s.health.gyro = s.health.accelerometer = imu_healthy();
  s.health.rotors = failsafes_.faulty_rotor() == 0;
  s.fence_set = params_.fence_action > 0.F && (params_.fence_distance > 0.F || params_.fence_height > 0.F);
  s.health.fence = !failsafes_.active(FailsafeCause::kFence);
  s.health.prearm_checks = armed_ || prearm_checks_pass_;
  for (std::size_t i = 0; i < link::kLinkCount; ++i) {
    s.links[i] = &counters_[i].totals();
  }
  s.setpoints_dropped = offboard_.dropped();
  s.frames_unsent = outbox_.overflows();
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
