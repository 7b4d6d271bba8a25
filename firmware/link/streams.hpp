// Which message goes out in this millisecond. Why: rates are a table per link, due times follow from the step count
// alone.
#pragma once
#include <algorithm>

#include "link/outbox.hpp"
#include "link/vehicle_status.hpp"

namespace halfroll::link {

struct StreamRow {
  std::uint32_t id;
  std::array<float, kLinkCount> rate_hz;
};
/// In sending order; 0 Hz: on interval or request only. Others than these cannot be asked for.
inline constexpr StreamRow kStreams[] = {
    {msg::kHeartbeat, {1.F, 1.F, 1.F}},
    {msg::kAttitudeQuaternion, {100.F, 10.F, 50.F}},
    {msg::kLocalPosition, {100.F, 5.F, 50.F}},
    {msg::kAttitudeTarget, {50.F, 5.F, 0.F}},
    {msg::kAttitude, {0.F, 10.F, 0.F}},
    {msg::kGlobalPositionInt, {10.F, 5.F, 10.F}},
    {msg::kSysStatus, {2.F, 2.F, 2.F}},
    {msg::kExtendedSysState, {5.F, 2.F, 2.F}},
    {msg::kGpsRawInt, {2.F, 2.F, 0.F}},
    {msg::kVfrHud, {0.F, 4.F, 0.F}},
    {msg::kBatteryStatus, {1.F, 1.F, 1.F}},
    {msg::kHomePosition, {0.5F, 0.5F, 0.5F}},
    {msg::kGpsGlobalOrigin, {0.2F, 0.2F, 0.2F}},
    {msg::kMissionCurrent, {2.F, 2.F, 2.F}},
    {msg::kSystemTime, {1.F, 1.F, 1.F}},
    {msg::kCurrentMode, {0.5F, 0.5F, 0.5F}},
    {msg::kAvailableModesMonitor, {0.2F, 0.2F, 0.2F}},
    {msg::kActuatorOutputStatus, {0.F, 0.F, 0.F}},
    {msg::kAutopilotVersion, {0.F, 0.F, 0.F}},
    {msg::kAvailableModes, {0.F, 0.F, 0.F}},
    {msg::kOdometry, {0.F, 0.F, 0.F}},
    {msg::kHighresImu, {0.F, 0.F, 0.F}},
    {msg::kAltitude, {0.F, 0.F, 0.F}},
};
inline constexpr std::size_t kStreamCount = sizeof(kStreams) / sizeof(kStreams[0]);

class Streams {
 public:
  Streams();

  /// Whether step() has a stream to send in the step that ended at t_us.
  bool due(std::uint64_t t_us) const { return t_us >= *std::min_element(next_due_us_.begin(), next_due_us_.end()); }
  /// Send all that is due in the step that ended at status.t_us, on all links, and what has changed. Whenever due()
  /// says so and at least every 100 ms, before any TIMESYNC request.
  void step(VehicleStatus status, Outbox&);
  /// Send what has changed since last shown: heartbeat and mode, landed state, home, origin, mission. In step and in
  /// service.
  void show_changes(const VehicleStatus& status, Outbox&);
  /// Heartbeats by wall clock, once a second, while no time passes.
  void service(std::uint64_t wall_us, const VehicleStatus& status, Outbox&);

  /// SET_MESSAGE_INTERVAL: -1 off, 0 the table's rate, else [us] >= 2500.
  CommandResult set_interval(int link, std::uint32_t id, float interval_us);
  /// [us]; -1 off. None: not a stream.
  std::optional<std::int32_t> interval_us(int link, std::uint32_t id) const;

  /// GET_MESSAGE_INTERVAL and REQUEST_MESSAGE: whether it can be answered; then, after the ACK, send it.
  CommandResult can_send(std::uint32_t id, float parameter, const VehicleStatus& status) const;
  void send_requested(Endpoint to, std::uint32_t id, float parameter, VehicleStatus status, Outbox&) const;

  auto state() const { return std::tie(interval_us_, due_us_, next_due_us_, next_step_us_, shown_, q_shown_); }

 private:
  struct Shown {
    std::uint32_t heartbeat = 0;  // mode, armed, status packed
    LandedState landed = LandedState::kOnGround;
    Origin origin;
    std::optional<Home> home;
    MissionProgress mission;
    bool operator==(const Shown& o) const {
      return heartbeat == o.heartbeat && landed == o.landed && origin == o.origin && home == o.home &&
             mission == o.mission;
    }
  };

  void schedule(std::size_t link, std::size_t row, std::uint64_t from_us);

  std::array<std::array<std::int32_t, kStreamCount>, kLinkCount> interval_us_;  // 0 or less: off
  std::array<std::array<std::uint64_t, kStreamCount>, kLinkCount> due_us_ = {};
  std::array<std::uint64_t, kLinkCount> next_due_us_ = {};  // the earliest of a link: most steps look no further
  std::uint64_t next_step_us_ = 0;
  std::optional<Shown> shown_;
  Quat q_shown_;  // sign of the last attitude: the next one continues it
  std::uint64_t heartbeat_wall_us_ = 0;
  std::uint64_t standing_at_us_ = 0;
};

}  // namespace halfroll::link
