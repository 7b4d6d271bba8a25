// May it arm? Why: the first failing check is named, so a person knows what to mend.
#pragma once
#include "core/modes.hpp"

namespace halfroll {

struct ArmingContext {
  bool terminated = false;
  bool attitude_valid = false;
  bool sensors_healthy = true;  // gyro and accelerometer give finite numbers
  bool upright = false;
  bool still = false;
  bool position_valid = false;
  bool battery_sufficient = false;
  bool failsafe_acting = false;
  Mode mode = Mode::kHold;
  const char* mission_problem = nullptr;  // why the stored mission cannot be flown; nullptr if it can
  bool uploading = false;
  bool params_damaged = false;
};

/// nullptr if it may arm, else why not. `forced` skips the checks that are about prudence, not possibility.
const char* refuse_arming(const ArmingContext& context, bool forced);

}  // namespace halfroll
