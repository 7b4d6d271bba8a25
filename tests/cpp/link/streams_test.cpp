// Rates and requests over simulated time.
#include "link/streams.hpp"

#include <limits>
#include <map>

#include "client.hpp"

using namespace halfroll;
using namespace halfroll::link;

namespace {

using Counts = std::map<std::pair<int, std::uint32_t>, int>;

VehicleStatus with_home() {
  VehicleStatus status;
  status.home = Home{};
  return status;
}

/// Frames by (link, message) over `seconds` of vehicle time.
Counts run(Streams& streams, int seconds, VehicleStatus status = with_home()) {
  Counts counts;
  Outbox outbox;
  for (int ms = 0; ms < seconds * 1000; ++ms) {
    status.t_us = static_cast<std::uint64_t>(ms) * 1000;
    outbox.begin(1, status.t_us);
    streams.step(status, outbox);
    for (const TxFrame& frame : client::frames(outbox)) ++counts[{frame.to.link, client::read(frame).msgid}];
  }
  CHECK(outbox.overflows() == 0);
  return counts;
}

}  // namespace

TEST_CASE("every stream keeps its rate on each link within 20 per cent") {
  Streams streams;
  Counts counts = run(streams, 10);
  for (const StreamRow& row : kStreams) {
    for (int link = 0; link < kLinkCount; ++link) {
      CAPTURE(row.id);
      CAPTURE(link);
      const double wanted = 10.0 * static_cast<double>(row.rate_hz[static_cast<std::size_t>(link)]);
      CHECK(counts[{link, row.id}] >= 0.8 * wanted);
      CHECK(counts[{link, row.id}] <= 1.2 * wanted);
    }
  }
}

TEST_CASE("attitude and position go out together, at multiples of 10 ms, with one stamp") {
  Streams streams;
  Outbox outbox;
  VehicleStatus status;
  for (status.t_us = 0; status.t_us < 200000; status.t_us += 1000) {
    outbox.begin(1, status.t_us);
    streams.step(status, outbox);
    std::vector<std::uint32_t> stamps;
    for (const TxFrame& frame : client::frames(outbox)) {
      const auto message = client::read(frame);
      if (frame.to.link != 0) continue;
      if (message.msgid == 31) stamps.push_back(mavlink_msg_attitude_quaternion_get_time_boot_ms(&message));
      if (message.msgid == 32) stamps.push_back(mavlink_msg_local_position_ned_get_time_boot_ms(&message));
    }
    const auto ms = static_cast<std::uint32_t>(status.t_us / 1000);
    CHECK(stamps == (ms % 10 == 0 ? std::vector<std::uint32_t>{ms, ms} : std::vector<std::uint32_t>{}));
  }
}

TEST_CASE("an interval changes the asking link only; -1 is off and 0 the default") {
  Streams streams;
  CHECK(streams.set_interval(1, msg::kActuatorOutputStatus, 2500.F) == CommandResult::kAccepted);
  CHECK(streams.set_interval(1, msg::kAttitude, -1.F) == CommandResult::kAccepted);
  Counts counts = run(streams, 2);
  CHECK(counts[{1, msg::kActuatorOutputStatus}] == 800);
  CHECK(counts[{0, msg::kActuatorOutputStatus}] == 0);
  CHECK(counts[{1, msg::kAttitude}] == 0);
  CHECK(streams.interval_us(1, msg::kAttitude) == -1);
  CHECK(streams.set_interval(1, msg::kAttitude, 0.F) == CommandResult::kAccepted);
  CHECK(streams.interval_us(1, msg::kAttitude) == 100000);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  for (const float us : {2499.F, 1.F, -2.F, kNan, kInf}) {
    CHECK(streams.set_interval(0, msg::kAttitude, us) == CommandResult::kDenied);
  }
  CHECK(streams.set_interval(0, 9999, 10000.F) == CommandResult::kDenied);
}

TEST_CASE("a change of mode, arming, landed state, home or mission shows at once on every link") {
  Streams streams;
  Outbox outbox;
  VehicleStatus status;
  outbox.begin(1, 0);
  streams.show_changes(status, outbox);
  CHECK(outbox.size() == 0);
  status.armed = true;
  status.mode = Mode::kMission;
  status.landed = LandedState::kInAir;
  status.home = Home{};
  status.mission.current = 3;
  status.origin = {5, 0, 0};
  streams.show_changes(status, outbox);
  for (const std::uint32_t id : {msg::kHeartbeat, msg::kCurrentMode, msg::kExtendedSysState, msg::kHomePosition,
                                 msg::kMissionCurrent, msg::kGpsGlobalOrigin}) {
    CHECK(client::frames(outbox, id).size() == kLinkCount);
  }
  outbox.begin(1, 0);
  streams.show_changes(status, outbox);
  CHECK(outbox.size() == 0);
}

TEST_CASE("the attitude's sign never jumps") {
  Streams streams;
  Outbox outbox;
  VehicleStatus status;
  status.estimate.q_WB = {0.6F, 0.8F, 0, 0};
  for (status.t_us = 0; status.t_us < 50000; status.t_us += 1000) {
    status.estimate.q_WB = {-status.estimate.q_WB.w, -status.estimate.q_WB.x, 0, 0};
    outbox.begin(1, status.t_us);
    streams.step(status, outbox);
    for (const TxFrame& frame : client::frames(outbox, 31)) {
      CHECK(+client::read(frame, mavlink_msg_attitude_quaternion_decode).q1 == 0.6F);
    }
  }
}

TEST_CASE("requests are answered to the asker, unknown and unavailable ones refused") {
  Streams streams;
  Outbox outbox;
  VehicleStatus status;
  const Endpoint to{1, 3};
  const auto ask = [&](std::uint32_t id, float p) {
    outbox.begin(1, 0);
    streams.send_requested(to, id, p, status, outbox);
    for (const TxFrame& frame : client::frames(outbox)) CHECK(frame.to == to);
    return outbox.size();
  };
  CHECK(ask(msg::kAutopilotVersion, 0) == 1);
  CHECK(ask(msg::kAvailableModes, 0) == kWireModeCount);
  CHECK(ask(msg::kAvailableModes, 6) == 1);
  CHECK(ask(msg::kMessageInterval, 31) == 1);
  CHECK(+client::read(outbox.frames()[0], mavlink_msg_message_interval_decode).interval_us == 100000);
  for (const float index : {7.F, -1.F, 0.5F, std::numeric_limits<float>::quiet_NaN()}) {
    CHECK(streams.can_send(msg::kAvailableModes, index, status) == CommandResult::kDenied);
  }
  CHECK(streams.can_send(msg::kHomePosition, 0, status) == CommandResult::kDenied);
  CHECK(streams.can_send(300, 0, status) == CommandResult::kDenied);
  CHECK(streams.can_send(397, 0, status) == CommandResult::kDenied);
  for (const StreamRow& row : kStreams) CHECK(streams.can_send(row.id, 0, with_home()) == CommandResult::kAccepted);
}

TEST_CASE("while time stands heartbeats go out once a second of wall time, and none extra while it passes") {
  Streams streams;
  VehicleStatus status;
  Outbox outbox;
  int standing = 0, passing = 0;
  for (std::uint64_t wall_us = 0; wall_us < 10000000; wall_us += 10000) {
    outbox.begin(1, 0);
    streams.service(wall_us, status, outbox);
    standing += static_cast<int>(client::frames(outbox, 0).size());
  }
  for (std::uint64_t wall_us = 10000000; wall_us < 20000000; wall_us += 10000) {
    status.t_us += 10000;
    outbox.begin(1, 0);
    streams.service(wall_us, status, outbox);
    passing += static_cast<int>(client::frames(outbox, 0).size());
  }
  CHECK(standing == 9 * kLinkCount);
  CHECK(passing == 0);
}
