#include "core/rotor.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"

namespace halfroll {
namespace {

/// 1 - e^(-x), share of a step that a first-order lag makes; to 1e-5 for x < 0.3 (a lag of 3 ms and more).
float lag_share(float lag) {
  if (!(lag > kDt)) return 1.F;
  const float x = kDt / lag;
  return x / (1.F + x * (0.5F + x / 12.F));
}

}  // namespace

RotorCommands RotorLagInverse::step(const RotorCommands& wanted, const Vehicle& vehicle, const Params& params) {
  if (vehicle.rotor_kind == RotorKind::kVariablePitch) return wanted;
  const float least = std::max(vehicle.thrust_min, 0.F), most = vehicle.thrust_max;
  const float slowest = std::sqrt(least), fastest = std::sqrt(most);
  const float share_up = lag_share(vehicle.rotor_lag), share_down = lag_share(vehicle.rotor_lag_down);
  RotorCommands command;
  for (std::size_t i = 0; i < 4; ++i) {
    float& speed = speed_[i];
    speed = std::max(speed, slowest);  // a running rotor is never slower, so this is where it starts
    const float wanted_speed = std::sqrt(std::max(wanted.thrust[i], 0.F));
    const float asked = std::clamp(speed + params.lag_compensation * (wanted_speed - speed), slowest, fastest);
    speed += (asked > speed ? share_up : share_down) * (asked - speed);
    command.thrust[i] = std::clamp(asked * asked, least, most);
  }
  return command;
}

}  // namespace halfroll
