#include "core/arming.hpp"

namespace halfroll {

const char* refuse_arming(const ArmingContext& c, bool forced) {
  struct Check {
    bool passed;
    bool hard;  // also when forced
    const char* why;
  };
  const bool mode_arms =
      c.mode == Mode::kHold || c.mode == Mode::kMission || c.mode == Mode::kTakeoff || c.mode == Mode::kOffboard;
  const Check checks[] = {
      {!c.terminated, true, "terminated"},
      {c.attitude_valid, true, "no attitude"},
      {c.sensors_healthy, true, "gyro or accelerometer"},
      {c.upright, false, "not upright"},
      {c.still, false, "not still"},
      {c.position_valid, false, "no position"},
      {c.battery_sufficient, false, "battery"},
      {!c.failsafe_acting, false, "failsafe"},
      {mode_arms, true, "mode"},
      {c.mode != Mode::kMission || c.mission_problem == nullptr, false, c.mission_problem},
      {!c.uploading, false, "mission upload in progress"},
      {!c.params_damaged, false, "parameter file damaged"},
  };
  for (const Check& check : checks) {
    if (!check.passed && (check.hard || !forced)) return check.why;
  }
  return nullptr;
}

}  // namespace halfroll
