// A mission item as the follower flies it. Why: wire formats, frames and geodesy end in link/; here is only what to do.
#pragma once
#include "core/types.hpp"

namespace halfroll {

enum class ItemKind : std::uint8_t {
  kSkip,      // nothing to fly: reached at once
  kTakeoff,   // climb, then to `position` if it has one
  kWaypoint,  // to `position`, within `radius`, wait `hold_s` (infinite: stay)
  kLand,      // over `position` if it has one, descend, disarm
  kReturn,    // hand over to RTL; ends the mission
  kDelay,     // wait hold_s where we are
  kJump,      // to item `jump_to`, `repeats` times (-1: always)
  kSpeed,     // horizontal speed from here on
  kYaw,       // turn to yaw
  kSetHome,   // home is `position`
};

struct FlightItem {
  ItemKind kind = ItemKind::kSkip;
  Vec3 position = Vec3::Zero();  // W; z is meaningful even where has_position is false (takeoff height)
  bool has_position = false;     // x and y given
  float yaw = 0.F;               // W, counter-clockwise from north
  bool has_yaw = false;
  bool yaw_relative = false;  // kYaw: turn by yaw, not to it
  float hold_s = 0.F;
  float radius = 0.F;  // 0: NAV_ACC_RAD
  float speed = 0.F;   // [m/s]; -1 keep, -2 default
  int jump_to = 0;
  int repeats = 0;
};

}  // namespace halfroll
