#include "core/failsafes.hpp"

#include "core/trig.hpp"

namespace halfroll {
namespace {

using In = FailsafeInputs;

constexpr float kRadian = 0.017453293F;    // [rad] in a degree
constexpr float kBatteryRecovers = 0.05F;  // above its threshold: the voltage of a battery wavers
constexpr float kFenceInside = 1.F;        // [m] inside the fence again

float at_once(const Params&) { return 0.F; }
bool never(const In&, const Params&) { return false; }

bool tumbling(const In& in, const Params& p) {
  return in.axis_cosine < cosine(p.tumble_angle_deg * kRadian) || in.rate_error > p.tumble_rate;
}

bool attitude_lost(const In& in, const Params& p) {
  return in.flying && !in.offboard && (!in.attitude_valid || tumbling(in, p));
}

bool beyond(float distance, float limit) { return limit > 0.F && distance > limit; }

bool outside_fence(const In& in, const Params& p) {
  return in.flying && in.position_valid && (beyond(in.distance, p.fence_distance) || beyond(in.height, p.fence_height));
}

bool inside_fence(const In& in, const Params& p) {
  return !in.flying ||
         !(beyond(in.distance + kFenceInside, p.fence_distance) || beyond(in.height + kFenceInside, p.fence_height));
}

FailsafeAction fence_action(const Params& p) {  // numbered as in PX4
  constexpr FailsafeAction kActions[] = {FailsafeAction::kNone,   FailsafeAction::kWarn,      FailsafeAction::kHold,
                                         FailsafeAction::kReturn, FailsafeAction::kTerminate, FailsafeAction::kLand};
  return kActions[static_cast<int>(p.fence_action)];
}

FailsafeAction ground_action(const Params& p) {
  constexpr FailsafeAction kActions[] = {FailsafeAction::kWarn, FailsafeAction::kHold, FailsafeAction::kReturn,
                                         FailsafeAction::kLand};
  return kActions[static_cast<int>(p.ground_loss_action)];
}

FailsafeAction offboard_action(const Params& p) {
  constexpr FailsafeAction kActions[] = {FailsafeAction::kHold, FailsafeAction::kLand, FailsafeAction::kReturn,
                                         FailsafeAction::kMission};
  return kActions[static_cast<int>(p.offboard_loss_action)];
}

}  // namespace

const std::array<FailsafeRow, kFailsafeCount> kFailsafes = {{
    {FailsafeCause::kAttitudeLost, "attitude lost",
     "attitude estimate lost, or thrust axis `FD_FAIL_ANG` or rate `FD_FAIL_RATE` off the reference, for `FD_FAIL_T`, "
     "outside OFFBOARD",
     "motors off", "reboot", attitude_lost, never, [](const Params& p) { return p.tumble_time; },
     [](const Params&) { return FailsafeAction::kTerminate; }},
    {FailsafeCause::kRotor, "rotor",
     "one rotor's thrust `FD_ROTOR_ERR` of its hover thrust off its command for `FD_ROTOR_T`, the others' less than "
     "half "
     "of that",
     "LAND", "disarming", [](const In& in, const Params&) { return in.flying && in.suspect_rotor != 0; }, never,
     [](const Params& p) { return p.rotor_fault_time; }, [](const Params&) { return FailsafeAction::kLand; }},
    {FailsafeCause::kPositionLost, "position lost", "no position estimate",
     "LAND: level, down at `MPC_LAND_SPEED` by dead reckoning", "a position again: LAND goes on with it",
     [](const In& in, const Params&) { return in.flying && !in.position_valid; },
     [](const In& in, const Params&) { return in.position_valid; }, at_once,
     [](const Params&) { return FailsafeAction::kLand; }},
    {FailsafeCause::kBatteryCritical, "battery critical", "state of charge below `BAT_CRIT_THR`",
     "LAND; a user may choose between LAND and RTL", "0.05 above it",
     [](const In& in, const Params& p) { return in.flying && in.state_of_charge < p.battery_critical; },
     [](const In& in, const Params& p) { return in.state_of_charge > p.battery_critical + kBatteryRecovers; }, at_once,
     [](const Params&) { return FailsafeAction::kLand; }},
    {FailsafeCause::kBatteryLow, "battery low", "state of charge below `BAT_LOW_THR`", "warning", "0.05 above it",
     [](const In& in, const Params& p) { return in.state_of_charge < p.battery_low; },
     [](const In& in, const Params& p) { return in.state_of_charge > p.battery_low + kBatteryRecovers; }, at_once,
     [](const Params&) { return FailsafeAction::kWarn; }},
    {FailsafeCause::kFence, "fence",
     "farther from home than `GF_MAX_HOR_DIST` or higher above it than `GF_MAX_VER_DIST`", "`GF_ACTION`",
     "1 m inside again", outside_fence, inside_fence, at_once, fence_action},
    {FailsafeCause::kGroundLost, "GCS lost",
     "no heartbeat of a ground control station (type 6) and no frame of component 191 for `COM_DL_LOSS_T`, once one "
     "was heard",
     "`NAV_DLL_ACT`", "a heartbeat",
     [](const In& in, const Params& p) { return in.flying && in.ground_silence_s > p.ground_loss_after; },
     [](const In& in, const Params& p) { return in.ground_silence_s <= p.ground_loss_after; }, at_once, ground_action},
    {FailsafeCause::kOffboardLost, "offboard lost", "in OFFBOARD no good setpoint for `OFB_LOSS_T`", "`OFB_LOSS_ACT`",
     "a new mode command", [](const In& in, const Params&) { return in.offboard_lost; },
     [](const In& in, const Params&) { return !in.offboard_lost; }, at_once, offboard_action},
}};

bool fence_forbids(float distance, float height, const Params& p) {
  return fence_action(p) > FailsafeAction::kWarn &&
         (beyond(distance, p.fence_distance) || beyond(height, p.fence_height));
}

Failsafes::Change Failsafes::step(const FailsafeInputs& in, float dt, const Params& params) {
  Change change;
  for (std::size_t i = 0; i < kFailsafeCount; ++i) {
    const FailsafeRow& row = kFailsafes[i];
    const std::uint32_t bit = 1U << i;
    if ((active_ & bit) != 0) {
      if (row.ends(in, params)) change.ended |= bit;
      continue;
    }
    lasting_s_[i] = row.begins(in, params) ? lasting_s_[i] + dt : 0.F;
    if (lasting_s_[i] > row.lasting_s(params) && row.action(params) != FailsafeAction::kNone) change.begun |= bit;
  }
  active_ = (active_ | change.begun) & ~change.ended;
  if ((change.begun >> static_cast<unsigned>(FailsafeCause::kRotor) & 1U) != 0) faulty_rotor_ = in.suspect_rotor;
  return change;
}

bool Failsafes::acting(const Params& params) const {
  for (std::size_t i = 0; i < kFailsafeCount; ++i) {
    if ((active_ >> i & 1U) != 0 && kFailsafes[i].action(params) > FailsafeAction::kWarn) return true;
  }
  return false;
}

}  // namespace halfroll
