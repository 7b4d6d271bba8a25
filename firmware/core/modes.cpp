#include "core/modes.hpp"

#include <array>

namespace halfroll {
namespace {

using Condition = bool (*)(Mode from, const ModeContext&);

bool in_flight(const ModeContext& c) { return c.armed && !c.on_ground; }

struct Rule {
  Mode to;
  Condition refused;
  const char* why;
};

// First rule that refuses wins. Modes without a row here are free.
constexpr std::array<Rule, 8> kRules = {{
    {Mode::kMission, [](Mode, const ModeContext& c) { return !c.mission_stored; }, "no mission stored"},
    {Mode::kMission, [](Mode, const ModeContext& c) { return c.armed && !c.position_valid; }, "no position"},
    {Mode::kTakeoff, [](Mode, const ModeContext& c) { return in_flight(c); }, "already flying"},
    {Mode::kTakeoff, [](Mode, const ModeContext& c) { return c.armed && !c.position_valid; }, "no position"},
    {Mode::kReturn, [](Mode, const ModeContext& c) { return !c.armed; }, "disarmed"},
    {Mode::kReturn, [](Mode, const ModeContext& c) { return !c.position_valid; }, "no position"},
    {Mode::kLand, [](Mode, const ModeContext& c) { return !c.armed; }, "disarmed"},
    {Mode::kOffboard, [](Mode, const ModeContext& c) { return c.armed && !c.position_valid; }, "no position"},
}};

}  // namespace

const char* refuse_mode(Mode from, Mode to, Requester who, const ModeContext& context) {
  if (who == Requester::kAutopilot) return nullptr;
  if (context.terminated) return "terminated";
  if (context.battery_critical && to != Mode::kLand && to != Mode::kReturn) return "battery critical";
  if (who == Requester::kGroundStation) {
    const bool takes_over = from == Mode::kMission && to == Mode::kOffboard;
    const bool gives_back = from == Mode::kOffboard && to == Mode::kMission && context.ground_station_owns_offboard;
    if (from != to && !takes_over && !gives_back) return "not the ground station's to change";
  }
  for (const Rule& rule : kRules) {
    if (rule.to == to && rule.refused(from, context)) return rule.why;
  }
  return nullptr;
}

const char* mode_name(Mode mode) {
  constexpr std::array<const char*, kModeCount> kNames = {"Hold", "Mission", "Return", "Land", "Takeoff", "Offboard"};
  return kNames[static_cast<std::size_t>(mode)];
}

}  // namespace halfroll
