// The autopilot: sensors and bytes in, rotor commands and bytes out, one millisecond a step. No clock, no socket, no
// file.
#pragma once
#include <optional>

#include "core/arming.hpp"
#include "core/estimator.hpp"
#include "core/failsafes.hpp"
#include "core/landing.hpp"
#include "core/manoeuvre.hpp"
#include "core/mission_runner.hpp"
#include "core/modes.hpp"
#include "core/offboard.hpp"
#include "core/outer_loop.hpp"
#include "core/pose_source.hpp"
#include "core/rotor.hpp"
#include "core/rotor_monitor.hpp"
#include "link/commands.hpp"
#include "link/frames.hpp"
#include "link/link_counters.hpp"
#include "link/missions.hpp"
#include "link/params.hpp"
#include "link/signing.hpp"
#include "link/streams.hpp"

namespace halfroll {

struct Battery {
  float voltage = 16.8F;        // [V]
  float state_of_charge = 1.F;  // 0..1
};

/// What the links brought since the last call.
struct LinkInputs {
  const link::Datagram* rx = nullptr;
  std::size_t rx_count = 0;
  std::uint64_t wall_us = 0;   // the shell's monotonic clock: paces bulk answers and heartbeats while time stands
  link::StorageResult stored;  // outcome of the last StorageRequest
};

/// What the links take away; valid until the next call.
struct LinkOutputs {
  const link::TxFrame* tx = nullptr;
  std::size_t tx_count = 0;
  link::StorageRequest store;
  bool shut_down = false;  // the vehicle was told to switch off
  bool reboot = false;
};

struct Inputs {
  Measurements measured;
  Battery battery;
  LinkInputs link;
};

struct Outputs {
  RotorCommands rotors;
  LinkOutputs link;
};

/// Everything decided before the first step.
struct Boot {
  link::Origin origin{473977420, 85455940, 488000};
  bool px4_identity = false;
  std::uint64_t unix_us_at_wall_0 = 0;  // the time of day when wall_us was 0; 0 if nobody knows
  std::array<link::SigningPolicy, link::kLinkCount> signing_policies = {};
  std::optional<link::SigningKey> signing_key;
  link::StoredImage params, mission, signing;  // read only while booting
  link::Text<50> last_words;                   // of a board that fell and started again: told to the first who listens
};

/// One vehicle's firmware. A value: copying it copies the whole autopilot; equal states fly equal flights.
class Autopilot final : private MissionItems {
 public:
  Autopilot(const Vehicle& vehicle, const Params& params, const Boot& boot = {});

  /// Advance 1 ms: sensors sampled now, commands for the millisecond that follows. The first step is at t = 0.
  Outputs step(const Inputs& in);
  /// Answer the links while no time passes (the simulator stands, or between steps).
  LinkOutputs service(const LinkInputs& in);

  /// Lockstep: queue TIMESYNC (tc1 = 0, ts1 = now) to link A's default peer; answered once component 191 echoes it.
  void ask_time();
  bool time_answered() const { return time_answered_; }
  /// Valid frames of component 191 so far (it is alive while this grows).
  std::uint32_t ground_frames() const { return ground_frames_; }

  std::uint64_t t_us() const { return t_us_; }  // of the last step
  bool armed() const { return armed_; }
  Mode mode() const { return mode_; }
  bool on_ground() const { return landed_.on_ground(); }
  const Estimate& estimate() const { return estimate_; }
  const Estimator& estimator() const { return estimator_; }
  const Reference& reference() const { return reference_; }
  const Params& params() const { return params_; }
  bool same_state(const Autopilot& other) const;
  /// Of all that same_state compares, the mission by its id.
  std::uint32_t state_checksum() const;
  /// What holds after every step, whatever came in: unit quaternions, no NaN or infinity in anything remembered, rotor
  /// commands and parameters within their limits, bounded integrators. The first that does not, in words, or null.
  /// For tests and checked builds: it looks at the whole state.
  const char* broken_invariant() const;

 private:
  static constexpr bool kAloud = true, kQuietly = false;  // whether a refusal may say more by STATUSTEXT

  // autopilot.cpp: the loop, modes
  void navigate();
  bool wants_to_fly() const;
  bool imu_healthy() const;
  void disarm();
  void enter(Mode mode, Requester who);
  void set_home(const Vec3& position);
  Vec3 home_position() const;

  // autopilot_failsafes.cpp
  FailsafeInputs failsafe_inputs() const;
  void watch();
  void fail_safe(const FailsafeRow& row);
  void announce(const FailsafeRow& row, FailsafeAction action);
  void terminate();
  bool hold_before_unflyable_item(const FollowerTarget& target);

  // autopilot_flight.cpp
  void stand_by();
  void fly_to(const FollowerTarget& target);
  void descend(FollowerTarget target);
  void fly_mission();
  void fly_return();
  void fly_offboard();
  void follow_link();
  void fly_position();
  void land_without_position();
  void restart_follower();
  void start_recovery();
  void report_reached();
  FollowerTarget hold_target() const;
  void hold();
  void hold_at(const Vec3& position);
  void turn_over(BodyAxis axis, float turns);
  void fly_manoeuvre();
  void fly_reference();

  // autopilot_link.cpp: bytes in and out
  void exchange(const LinkInputs& in, std::size_t most_bytes);
  LinkOutputs finish(const LinkInputs& in);
  void receive(const link::Received& received, std::uint64_t wall_us);
  void receive_command(const link::Command& command, const link::Header& header, std::uint64_t wall_us);
  link::CommandResult change_mode(Mode mode, Requester who);
  const char* mission_problem(bool aloud);
  const char* judge_mission(bool aloud);
  ModeContext mode_context() const;
  float patience(link::Endpoint client) const;
  link::MissionSituation mission_situation() const;
  MissionState mission_state() const;
  link::VehicleStatus status() const;
  void say_boot_faults();
  const char* refuse_to_arm(bool forced, bool aloud);
  link::CommandResult apply(const link::Wish& wish, const link::Header& header, std::uint64_t wall_us);
  struct Dispatch;  // one overload per kind of message
  struct Applying;  // one overload per kind of wish (autopilot_commands.cpp)

  // MissionItems
  int count() const override { return missions_.count(); }
  int first() const override;
  FlightItem item(int seq) const override;

  auto state() const;

  Vehicle vehicle_;
  Params params_;
  bool px4_identity_ = false;
  bool started_ = false;
  std::uint64_t t_us_ = 0;

  Imu imu_;
  std::optional<std::uint64_t> imu_failed_us_;  // last sample that was no number
  Battery battery_;
  PoseSource pose_source_;
  std::optional<LinkedPose> linked_pose_;  // the last that came since the step before
  Estimator estimator_;
  Estimate estimate_;
  LandedDetector landed_;

  Mode mode_ = Mode::kHold;
  Mode user_mode_ = Mode::kHold;  // last asked for by a person
  bool armed_ = false;
  bool flown_ = false;  // left the ground since armed
  bool terminated_ = false;
  bool entered_by_ground_station_ = false;
  float idle_s_ = 0.F;                   // on the ground with nothing to fly
  std::uint64_t failsafe_until_us_ = 0;  // system status critical till then
  Failsafes failsafes_;
  RotorMonitor rotor_monitor_;
  std::optional<std::uint64_t> ground_heard_us_;  // last heartbeat of a ground control station or of component 191
  bool position_was_valid_ = false;
  std::uint8_t position_resets_ = 0;
  bool prearm_checks_pass_ = false;

  Follower follower_;
  Vec3 hold_position_ = Vec3::Zero();
  float hold_yaw_ = 0.F;
  bool stopping_ = false;  // on the way to rest; hold_position_ is where that will be
  /// That in a hurry, for setpoints were lost: upright, or at speed whichever way up is nearer.
  enum class Recovery : std::uint8_t { kNone, kUpright, kEitherWayUp };
  Recovery recovery_ = Recovery::kNone;
  Manoeuvre manoeuvre_;
  bool inverted_ = false;        // HOLD is, or after the manoeuvre will be, upside down
  float takeoff_height_ = 2.5F;  // above home [m]
  bool return_climbing_ = false;
  MissionRunner runner_;
  bool mission_started_ = false;
  std::uint32_t mission_revision_ = 0;
  Offboard offboard_;
  OffboardStage offboard_stage_ = OffboardStage::kWaiting;

  OuterLoop outer_loop_;
  Setpoint setpoint_;
  std::uint8_t setpoint_mask_ = 0;
  Reference reference_;
  RotorLagInverse rotor_lag_inverse_;
  RotorCommands rotors_;

  link::Origin origin_;
  std::optional<link::Home> home_;
  bool home_chosen_ = false;  // by command since the last disarm
  std::array<std::array<link::Parser, 9>, link::kLinkCount> parsers_ = {};
  link::ParamService param_service_;
  struct Owed {
    link::Endpoint to;
    link::CommandAck answer;
  };
  std::optional<Owed> owed_;  // to whom asked for parameters to be stored, once they are
  link::MissionService missions_;
  link::Streams streams_;
  link::Signing signing_;
  std::uint64_t unix_us_at_wall_0_ = 0, unix_us_at_boot_ = 0;
  link::Outbox outbox_;
  std::array<std::uint16_t, link::kLinkCount> keeps_our_time_ = {};  // a bit per endpoint that has sent TIMESYNC
  std::array<link::LinkCounters, link::kLinkCount> counters_ = {};
  bool params_damaged_ = false;
  link::StoredState params_state_ = link::StoredState::kNothing, mission_state_at_boot_ = link::StoredState::kNothing;
  bool boot_faults_said_ = false;
  link::Text<50> last_words_;
  bool shut_down_ = false, reboot_ = false;
  /// What the verdict on the stored mission hangs on: revision, home, origin and parameters.
  using MissionDatum = std::tuple<std::uint32_t, Vec3, link::Origin, float, float, float, float, float, float, float>;
  std::optional<MissionDatum> mission_judged_at_;
  bool mission_flyable_ = false;
  link::Text<50> problem_;  // of the stored mission, in words
  std::int64_t time_asked_ns_ = -1;
  bool time_answered_ = true;
  bool ask_time_now_ = false;
  std::uint32_t ground_frames_ = 0;
};

}  // namespace halfroll
