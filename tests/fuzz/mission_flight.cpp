// Missions of any items, stored and flown: started, paused, jumped in, overwritten and sped up on the way. The first
// byte is the number of items, five bytes make each (what, parameter, north, east, height); then come orders, two bytes
// each.
#include "flying_vehicle.hpp"

namespace {

using namespace halfroll;
using namespace halfroll::fuzz;

constexpr int kLongestMs = 6000;
constexpr int kMostItems = 48;
constexpr std::int32_t kMetre_degE7 = 90;  // northward, about

/// Four parameters that an item may or may not have.
struct Kind {
  std::uint16_t command;
  float p[4];
  int of_byte = -1;  // the parameter that a byte gives
  float scale = 1.F;
};
constexpr Kind kKinds[] = {
    {MAV_CMD_NAV_WAYPOINT, {}},
    {MAV_CMD_NAV_WAYPOINT, {}, 0, 0.01F},
    {MAV_CMD_NAV_WAYPOINT, {}, 3, 2.F},
    {MAV_CMD_NAV_SPLINE_WAYPOINT, {}, 0, 0.01F},
    {MAV_CMD_NAV_LOITER_TIME, {}, 0, 0.02F},
    {MAV_CMD_NAV_LOITER_UNLIM, {}},
    {MAV_CMD_NAV_TAKEOFF, {}},
    {MAV_CMD_NAV_LAND, {}},
    {MAV_CMD_NAV_RETURN_TO_LAUNCH, {}},
    {MAV_CMD_NAV_DELAY, {}, 0, 0.02F},
    {MAV_CMD_CONDITION_DELAY, {}, 0, 0.02F},
    {MAV_CMD_CONDITION_YAW, {}, 0, 2.F},
    {MAV_CMD_CONDITION_YAW, {0.F, 0.F, 1.F, 1.F}, 0, 1.F},
    {MAV_CMD_DO_JUMP, {0.F, -1.F}, 0, 1.F},
    {MAV_CMD_DO_JUMP, {0.F, 3.F}, 0, 1.F},
    {MAV_CMD_DO_CHANGE_SPEED, {1.F, -2.F}},
    {MAV_CMD_DO_CHANGE_SPEED, {1.F}, 1, 0.1F},
    {MAV_CMD_DO_SET_HOME, {1.F}},
    {MAV_CMD_DO_SET_HOME, {0.F}},
    {MAV_CMD_DO_LAND_START, {}},
    {MAV_CMD_DO_INVERTED_FLIGHT, {1.F}},
    {MAV_CMD_USER_1, {1.F, 0.F, 0.F, 5.F}, 1, 0.5F},
    {MAV_CMD_WAYPOINT_USER_1, {10.F, 0.F}, 1, 0.5F},
    {MAV_CMD_IMAGE_START_CAPTURE, {}, 0, 1.F},
};

Bytes item(std::uint16_t seq, Reader& input) {
  const Kind& kind = kKinds[input.byte() % std::size(kKinds)];
  const float value = static_cast<float>(input.byte());
  auto m = to_autopilot<mavlink_mission_item_int_t>();
  m.seq = seq;
  m.command = kind.command;
  m.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT;
  m.autocontinue = 1;
  float* const p[] = {&m.param1, &m.param2, &m.param3, &m.param4};
  for (int i = 0; i < 4; ++i) *p[i] = kind.of_byte == i ? kind.scale * value : kind.p[i];
  const bool placed = kind.command != MAV_CMD_NAV_DELAY && kind.command != MAV_CMD_USER_1;
  const auto metres = [](std::uint8_t byte) { return byte - 128; };
  const std::int32_t north = metres(input.byte()) * kMetre_degE7 / 16, east = metres(input.byte()) * kMetre_degE7 / 16;
  const std::uint8_t height = input.byte();
  if (kind.command == MAV_CMD_USER_1) m.frame = MAV_FRAME_MISSION;
  if (placed) {
    m.x = 473977420 + north;
    m.y = 85455940 + east;
    m.z = 0.05F * static_cast<float>(height);
  }
  return frame(m, mavlink_msg_mission_item_int_encode_status);
}

void upload(FlyingVehicle& vehicle, Reader& input) {
  auto m = to_autopilot<mavlink_mission_count_t>();
  m.count = input.byte() % kMostItems;
  vehicle.step(frame(m, mavlink_msg_mission_count_encode_status));
  for (std::uint16_t seq = 0; seq < m.count; ++seq) vehicle.step(item(seq, input));
  vehicle.fly(2);
}

FlyingVehicle low_in_the_air() {
  FlyingVehicle vehicle;
  vehicle.fly(1500);
  vehicle.take_off(2.F);
  return vehicle;
}

Bytes order(std::uint8_t what, std::uint8_t how) {
  const float value = how;
  switch (what) {
    case 0: return command(MAV_CMD_MISSION_START, value >= 128.F ? value - 128.F : 0.F);
    case 1: return command(MAV_CMD_DO_PAUSE_CONTINUE, static_cast<float>(how % 2));
    case 2: return command(MAV_CMD_DO_SET_MISSION_CURRENT, static_cast<float>(how % 64), static_cast<float>(how / 128));
    case 3: return command(MAV_CMD_DO_CHANGE_SPEED, 1.F, how == 0 ? -2.F : 0.2F * value);
    case 4: return command(MAV_CMD_DO_SET_MODE, 1.F, 4.F);
    case 5: return command(MAV_CMD_COMPONENT_ARM_DISARM, static_cast<float>(how % 2));
    case 6: {
      auto m = to_autopilot<mavlink_mission_set_current_t>();
      m.seq = how;
      return frame(m, mavlink_msg_mission_set_current_encode_status);
    }
    case 7: {
      auto m = to_autopilot<mavlink_mission_write_partial_list_t>();
      m.start_index = static_cast<std::int16_t>(how % 16);
      m.end_index = static_cast<std::int16_t>(how / 16);
      return frame(m, mavlink_msg_mission_write_partial_list_encode_status);
    }
    case 8: {
      const auto m = to_autopilot<mavlink_mission_clear_all_t>();
      return frame(m, mavlink_msg_mission_clear_all_encode_status);
    }
    case 9: return command(MAV_CMD_NAV_RETURN_TO_LAUNCH, 0.F);
    default: return command(MAV_CMD_DO_SET_HOME, 1.F);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FlyingVehicle hovering = low_in_the_air();
  FlyingVehicle vehicle = hovering;
  Reader input(data, size);
  upload(vehicle, input);
  vehicle.step(command(MAV_CMD_MISSION_START, 0.F));
  int left_ms = kLongestMs;
  while (!input.empty()) {
    const std::uint8_t what = input.byte() % 20;
    const std::uint8_t how = input.byte();
    if (what > 10) {
      const int wait_ms = 8 * how;
      if ((left_ms -= wait_ms) < 0) break;
      vehicle.fly(wait_ms);
    } else {
      vehicle.step(order(what, how));
      if (what == 7) vehicle.step(item(how % 16, input));
    }
  }
  return 0;
}
