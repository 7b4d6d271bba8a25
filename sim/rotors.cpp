#include "sim/rotors.hpp"

#include <algorithm>
#include <cmath>

namespace halfroll::sim {
namespace {

/// The commands that reach the rotors now, having left `rotor_delay` ago.
const RotorCommands& delayed(const Plant& plant, const Rotors& rotors, int substep) {
  const int late = static_cast<int>(std::lround(plant.rotor_delay / kSubstep)) - substep;
  const std::size_t back = late > 0 ? static_cast<std::size_t>((late + kSubsteps - 1) / kSubsteps) : 0;
  return rotors.issued[(rotors.newest - back) % kRememberedCommands];
}

/// Share of the way to its target that a first-order lag covers in one substep.
double covered(double lag) { return -std::expm1(-kSubstep / lag); }

}  // namespace

Rotors steady(const RotorCommands& commands) {
  Rotors rotors;
  rotors.issued.fill(commands);
  std::copy(commands.thrust.begin(), commands.thrust.end(), rotors.thrust.begin());
  return rotors;
}

void issue(Rotors& rotors, const RotorCommands& commands) {
  rotors.newest = (rotors.newest + 1) % kRememberedCommands;
  rotors.issued[rotors.newest] = commands;
}

void advance(const Plant& plant, Rotors& rotors, int substep) {
  const bool fixed_pitch = plant.rotor_kind == RotorKind::kFixedPitch;
  const RotorCommands& arrived = plant.ideal_rotors ? rotors.issued[rotors.newest] : delayed(plant, rotors, substep);
  const double up = covered(plant.rotor_lag), down = covered(plant.rotor_lag_down);
  const double most = plant.rotor_slew_N_s * kSubstep;
  for (std::size_t i = 0; i < 4; ++i) {
    const double least = fixed_pitch ? 0.0 : plant.thrust_min;  // a fixed-pitch motor can be switched off
    const double wanted = std::clamp(static_cast<double>(arrived.thrust[i]), least, plant.thrust_max);
    double& thrust = rotors.thrust[i];
    if (plant.ideal_rotors) {
      thrust = wanted;
    } else if (fixed_pitch) {
      const double target = std::sqrt(wanted), speed = std::sqrt(thrust);
      const double next = speed + (target > speed ? up : down) * (target - speed);
      thrust = next * next;
    } else {
      thrust += std::clamp(up * (wanted - thrust), -most, most);
    }
  }
}

BodyLoad load(const Plant& plant, const Rotors& rotors) {
  const auto& f = rotors.thrust;
  return {f[0] + f[1] + f[2] + f[3],
          {plant.arm * (f[0] - f[2]), plant.arm * (f[1] - f[3]), plant.yaw_coefficient * (f[1] + f[3] - f[0] - f[2])}};
}

}  // namespace halfroll::sim
