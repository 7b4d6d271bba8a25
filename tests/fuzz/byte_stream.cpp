// Any bytes on any link, into a vehicle on the ground, in hover or on a mission. The first byte is the situation; of
// each frame, the compatibility flags say after how many milliseconds it comes and the sequence number on which link.
#include "flying_vehicle.hpp"

namespace {

using namespace halfroll;
using namespace halfroll::fuzz;

constexpr int kLongestMs = 400;

Bytes waypoint(std::uint16_t seq, std::int32_t north_degE7, std::int32_t east_degE7) {
  auto m = to_autopilot<mavlink_mission_item_int_t>();
  m.seq = seq;
  m.command = MAV_CMD_NAV_WAYPOINT;
  m.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT;
  m.autocontinue = 1;
  m.x = 473977420 + north_degE7;
  m.y = 85455940 + east_degE7;
  m.z = 10.F;
  return frame(m, mavlink_msg_mission_item_int_encode_status);
}

struct Situations {
  FlyingVehicle grounded, hovering, on_mission;

  Situations() {
    grounded.fly(1500);
    hovering = grounded;
    auto count = to_autopilot<mavlink_mission_count_t>();
    count.count = 3;
    hovering.step(frame(count, mavlink_msg_mission_count_encode_status));
    for (std::uint16_t seq = 0; seq < 3; ++seq) hovering.step(waypoint(seq, 900 * seq, 450 * seq * seq));
    hovering.take_off();
    on_mission = hovering;
    on_mission.step(command(MAV_CMD_MISSION_START, 0.F));
    on_mission.fly(2500);
    if (on_mission.autopilot().mode() != Mode::kMission) fail("the mission has not begun", 0);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Situations situations;
  if (size < 2) return 0;
  FlyingVehicle vehicle = data[0] % 3 == 0   ? situations.grounded
                          : data[0] % 3 == 1 ? situations.hovering
                                             : situations.on_mission;
  int left_ms = kLongestMs;
  for (const Bytes& piece : pieces(data + 1, size - 1)) {
    const bool is_frame = looks_like_a_frame(piece);
    const int wait_ms = is_frame ? piece[3] : 0;
    if ((left_ms -= wait_ms + 1) < 0) break;
    vehicle.fly(wait_ms);
    const auto link = static_cast<std::uint8_t>(is_frame ? piece[4] % link::kLinkCount : 1);
    vehicle.step(piece, {link, static_cast<std::uint8_t>(is_frame ? piece[4] / 4 % 4 : 0)});
  }
  vehicle.fly(20);
  return 0;
}
