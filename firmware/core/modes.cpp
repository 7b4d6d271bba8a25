#include "core/modes.hpp"

#include <array>

namespace halfroll {
namespace {

constexpr Bits kAnyMode = (1U << kModeCount) - 1U;
constexpr Bits kUser = bit(Requester::kUser), kGround = bit(Requester::kGroundStation), kBoth = kUser | kGround;
constexpr Bits kHold = bit(Mode::kHold), kMission = bit(Mode::kMission), kReturn = bit(Mode::kReturn),
               kLand = bit(Mode::kLand), kTakeoff = bit(Mode::kTakeoff), kOffboard = bit(Mode::kOffboard);
constexpr const char* kNotGrounds = "not the ground station's to change";

constexpr Bits except(Bits modes) { return static_cast<Bits>(kAnyMode & ~modes); }
bool always(const ModeContext&) { return true; }
bool in_flight(const ModeContext& c) { return c.armed && !c.on_ground; }

}  // namespace

const ModeRule kModeRules[kModeRuleCount] = {
    {kBoth, kAnyMode, kAnyMode, [](const ModeContext& c) { return c.terminated; }, "terminated", "terminated"},
    {kBoth, kAnyMode, except(kLand | kReturn), [](const ModeContext& c) { return c.battery_critical; },
     "battery critical", "battery critical"},
    {kGround, kAnyMode, kHold | kReturn | kLand | kTakeoff, always, kNotGrounds, "always"},
    {kGround, except(kMission), kOffboard, always, kNotGrounds, "always"},
    {kGround, except(kOffboard), kMission, always, kNotGrounds, "always"},
    {kGround, kOffboard, kMission, [](const ModeContext& c) { return !c.ground_station_owns_offboard; }, kNotGrounds,
     "another source is followed"},
    {kBoth, kAnyMode, kMission, [](const ModeContext& c) { return !c.mission_stored; }, "no mission stored",
     "no mission stored"},
    {kBoth, kAnyMode, kMission | kTakeoff | kOffboard,
     [](const ModeContext& c) { return c.armed && !c.position_valid; }, "no position", "armed without a position"},
    {kBoth, kAnyMode, kHold, [](const ModeContext& c) { return in_flight(c) && !c.position_valid; }, "no position",
     "flying without a position"},
    {kBoth, kAnyMode, kTakeoff, in_flight, "already flying", "flying"},
    {kBoth, kAnyMode, kReturn | kLand, [](const ModeContext& c) { return !c.armed; }, "disarmed", "disarmed"},
    {kBoth, kAnyMode, kReturn, [](const ModeContext& c) { return !c.position_valid; }, "no position", "no position"},
};

const char* refuse_mode(Mode from, Mode to, Requester who, const ModeContext& context) {
  for (const ModeRule& rule : kModeRules) {
    const bool applies = (rule.who & bit(who)) != 0 && (rule.from & bit(from)) != 0 && (rule.to & bit(to)) != 0;
    const bool change_of_ground = rule.who != kGround || from != to;
    if (applies && change_of_ground && rule.refused(context)) return rule.why;
  }
  return nullptr;
}

const char* mode_name(Mode mode) {
  constexpr std::array<const char*, kModeCount> kNames = {"Hold", "Mission", "Return", "Land", "Takeoff", "Offboard"};
  return kNames[static_cast<std::size_t>(mode)];
}

}  // namespace halfroll
