// What a command asks for. Why: every wire encoding of a wish is read here once; whether the wish fits the moment is
// the autopilot's to decide.
#pragma once
#include <optional>
#include <variant>

#include "link/frames.hpp"
#include "link/messages.hpp"

namespace halfroll::link {

struct ArmWish {
  bool arm = false, force = false;
};
struct ModeWish {
  Mode mode = Mode::kHold;
};
struct TakeoffWish {
  std::optional<float> height;  // [m] above home; none: MIS_TAKEOFF_ALT
};
struct LandWish {};
struct ReturnWish {};
struct MissionStartWish {
  int item = -1;  // -1: current
};
struct PauseWish {};
struct ContinueWish {};
struct MissionCurrentWish {
  int seq = -1;  // -1: keep
  bool reset = false;
};
struct RepositionWish {
  bool change_to_hold = false;
  bool has_position = false, has_height = false, has_yaw = false;  // what is not given is kept
  Vec3 position = Vec3::Zero();                                    // W
  float yaw = 0.F;                                                 // W [rad]
  std::optional<float> speed;                                      // [m/s]
};
struct SpeedWish {
  enum class Kind : std::uint8_t { kGround, kClimb, kDescend } kind = Kind::kGround;
  float speed = -1.F;  // [m/s]; -1 keep, -2 default
};
struct YawWish {
  float yaw = 0.F;  // W [rad]; a turn if relative
  bool relative = false;
  int direction = 0;  // +1 clockwise, -1 counter-clockwise seen from above, 0 the shorter way
};
struct HomeWish {
  bool here = true;
  std::int32_t lat_degE7 = 0, lon_degE7 = 0, alt_mm = 0;  // above mean sea level
};
struct OriginWish {
  std::int32_t lat_degE7 = 0, lon_degE7 = 0, alt_mm = 0;  // GPS_GLOBAL_ORIGIN must repeat these integers
};
struct IntervalWish {
  std::uint32_t id = 0;
  float interval_us = 0.F;  // not checked: Streams knows what it sends
};
struct IntervalQuery {
  std::uint32_t id = 0;
};
struct MessageWish {
  std::uint32_t id = 0;
  float parameter = 0.F;     // p2: index
  bool old_command = false;  // 410, 520: not available is TEMPORARILY_REJECTED, not DENIED
};
struct PowerWish {
  enum class Kind : std::uint8_t { kNothing, kReboot, kShutDown } kind = Kind::kNothing;
};
struct ParamStorageWish {
  enum class Kind : std::uint8_t { kReload, kSave, kReset, kNothing } kind = Kind::kNothing;
};
struct CalibrationWish {};
struct PrearmChecksWish {};
struct TerminationWish {
  bool terminate = false;
};
struct InvertedWish {
  bool inverted = false;
};
struct FlipWish {
  int axis = 1;                                     // 1 roll, 2 pitch
  float turns = 1.F;                                // multiple of 0.5, signed
  std::optional<float> least_height, longest_time;  // [m] above home, [s]
};

/// The answer itself, or what is asked for.
using Wish = std::variant<CommandResult, ArmWish, ModeWish, TakeoffWish, LandWish, ReturnWish, MissionStartWish,
                          PauseWish, ContinueWish, MissionCurrentWish, RepositionWish, SpeedWish, YawWish, HomeWish,
                          OriginWish, IntervalWish, IntervalQuery, MessageWish, PowerWish, ParamStorageWish,
                          CalibrationWish, PrearmChecksWish, TerminationWish, InvertedWish, FlipWish>;

/// What a command is read against.
struct CommandSituation {
  Origin origin;
  float home_z = 0.F;         // W [m]
  bool px4_identity = false;  // takeoff height in COMMAND_LONG is above sea level
  int mission_count = 0;
};

Wish read_command(const Command& command, const CommandSituation& situation);
/// Message SET_MODE (11): no ACK follows.
Wish read_set_mode(const SetMode& message);
/// Message SET_GPS_GLOBAL_ORIGIN (48).
Wish read_set_origin(const SetGlobalOrigin& message);

inline CommandAck acknowledgement(const Command& command, const Header& header, CommandResult result) {
  return {header.sender, command.command, result};
}

}  // namespace halfroll::link
