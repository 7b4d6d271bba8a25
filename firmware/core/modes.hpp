// Modes and who may enter them when. Why: one table of transitions, and a reason in words for every refusal.
#pragma once
#include <cstdint>

namespace halfroll {

enum class Mode : std::uint8_t { kHold, kMission, kReturn, kLand, kTakeoff, kOffboard };
inline constexpr int kModeCount = 6;

// Numbers of the last two are MAVLink's.
enum class LandedState : std::uint8_t { kOnGround = 1, kInAir = 2, kTakeoff = 3, kLanding = 4 };
enum class MissionState : std::uint8_t { kNone = 1, kNotStarted = 2, kActive = 3, kPaused = 4, kComplete = 5 };

/// Who asks. The ground station may only take over a mission and give it back; it never overrides a user's mode.
enum class Requester : std::uint8_t { kUser, kGroundStation, kAutopilot };

struct ModeContext {
  bool armed = false;
  bool on_ground = true;
  bool position_valid = false;
  bool mission_stored = false;
  bool terminated = false;
  bool battery_critical = false;
  bool ground_station_owns_offboard = false;
};

/// A set of modes or of requesters, one bit each.
using Bits = std::uint8_t;
constexpr Bits bit(Mode mode) { return static_cast<Bits>(1U << static_cast<unsigned>(mode)); }
constexpr Bits bit(Requester who) { return static_cast<Bits>(1U << static_cast<unsigned>(who)); }

/// One reason not to change mode.
struct ModeRule {
  Bits who, from, to;
  bool (*refused)(const ModeContext&);
  const char* why;   // a few words, for STATUSTEXT
  const char* when;  // for docs/mavlink.md
};
inline constexpr int kModeRuleCount = 12;
/// The first rule that refuses wins; what no rule refuses is free. The autopilot's own changes ask nobody.
extern const ModeRule kModeRules[kModeRuleCount];

/// nullptr if `to` may be entered from `from` now, else why not.
const char* refuse_mode(Mode from, Mode to, Requester who, const ModeContext& context);

const char* mode_name(Mode mode);

}  // namespace halfroll
