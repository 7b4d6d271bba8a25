// Four rotors between command and thrust. Why: what a rotor cannot do at once - dead time, lag, slew - decides which
// trajectories can be flown, so it is modelled as measured on the paper's vehicle (its bench times are tests).
#pragma once
#include <array>
#include <cstddef>

#include "sim/plant.hpp"
#include "sim/rigid_body.hpp"

namespace halfroll::sim {

inline constexpr int kSubsteps = 4;                                             // of each millisecond
inline constexpr double kSubstep = 1e-3 / kSubsteps;                            // [s]
inline constexpr std::size_t kRememberedCommands = 64;                          // milliseconds; a power of two
inline constexpr double kLongestRotorDelay = 1e-3 * (kRememberedCommands - 1);  // [s]

struct Rotors {
  std::array<double, 4> thrust = {0.0, 0.0, 0.0, 0.0};         // [N]
  std::array<RotorCommands, kRememberedCommands> issued = {};  // ring, one a millisecond
  std::size_t newest = 0;
};

/// Rotors that have been following `commands` for long.
Rotors steady(const RotorCommands& commands);

/// Take the command of this millisecond.
void issue(Rotors& rotors, const RotorCommands& commands);

/// Advance by kSubstep; `substep` counts from 0 within the millisecond. Variable pitch: dead time, first-order lag of
/// thrust, slew limit. Fixed pitch: dead time, first-order lag of speed sqrt(thrust), slower or faster when it falls;
/// a command of 0 stops the rotor. The lags are exact, hence stable however long the substep.
void advance(const Plant& plant, Rotors& rotors, int substep);

/// Force along body up and torque of the four thrusts (paper Eq 4): {0, 0, force}, torque, both in body axes.
struct BodyLoad {
  double thrust = 0.0;
  Vec3d torque_B = Vec3d::Zero();
};
BodyLoad load(const Plant& plant, const Rotors& rotors);

}  // namespace halfroll::sim
