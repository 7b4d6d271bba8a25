// Four rotors between command and thrust. Why: what a rotor cannot do at once - dead time, lag, slew - decides which
// trajectories can be flown, so it is modelled as measured on the paper's vehicle (its bench times are tests).
//
// Variable pitch: blades follow the command after a dead time, with lag and slew limit; thrust = pitch x speed squared.
// The governor keeps the speed up, less droop and what the battery cannot give. Fixed pitch: speed follows the root of
// the command, rising and falling with lags of their own; thrust = speed squared.
#pragma once
#include <array>
#include <cstddef>

#include "core/types.hpp"
#include "sim/plant.hpp"

namespace halfroll::sim {

inline constexpr int kSubsteps = 4;                                             // of each millisecond
inline constexpr double kSubstep = 1e-3 / kSubsteps;                            // [s]
inline constexpr std::size_t kRememberedCommands = 64;                          // milliseconds; a power of two
inline constexpr double kLongestRotorDelay = 1e-3 * (kRememberedCommands - 1);  // [s]

using PerRotor = std::array<double, 4>;

struct Rotors {
  PerRotor pitch = {0.0, 0.0, 0.0, 0.0};  // [N], variable pitch: of the blades, as thrust at nominal speed in still air
  PerRotor speed = {0.0, 0.0, 0.0, 0.0};  // share of rotor_speed_rad_s
  PerRotor thrust = {0.0, 0.0, 0.0, 0.0};  // [N], in still air, away from the ground
  std::array<bool, 4> blade_moving = {false, false, false, false};
  std::array<RotorCommands, kRememberedCommands> issued = {};  // ring, one a millisecond
  std::size_t newest = 0;
};

/// What has happened to the rotors, and what the battery can give.
struct RotorCondition {
  PerRotor share = {1.0, 1.0, 1.0, 1.0};  // of thrust
  std::array<bool, 4> stuck = {false, false, false, false};
  std::array<bool, 4> dead = {false, false, false, false};
  double speed_ceiling = 1.0;  // share of nominal speed
  bool sound = true;           // none of the above
};

/// A Plant's rotors with what every step needs worked out: shares of a way that half a substep and a whole one cover.
struct RotorModel {
  explicit RotorModel(const Plant& plant);

  struct Share {
    double half, whole;
  };
  bool variable_pitch, ideal;
  int delay_substeps;
  double thrust_min, thrust_max;
  Share lag, lag_down, governor, slew;  // slew [N]
  double stiction_N, droop_per_N;
  bool governed;  // speed is not simply nominal

  /// Blades on sound, governed rotors: nothing but lag and slew limit.
  bool plain_blades() const { return variable_pitch && !ideal && !governed && stiction_N <= 0.0; }
};

/// Force along body up and torque of four thrusts (paper Eq 4), body axes.
struct BodyLoad {
  double thrust = 0.0;
  Vec3d torque_B = Vec3d::Zero();
};

/// Thrusts over one substep, in its middle and when it ends.
struct ThrustHistory {
  PerRotor middle, end;
};

/// Rotors that have been following `commands` for long.
Rotors steady(const Plant& plant, const RotorCommands& commands);

/// Take the command of this millisecond.
void issue(Rotors& rotors, const RotorCommands& commands);

/// Advance by kSubstep; `substep` counts from 0 within the millisecond. The lags are exact, hence stable however long
/// the substep. A fixed-pitch rotor that is commanded 0 stops; one that runs is never slower than at thrust_min.
ThrustHistory advance(const RotorModel& model, Rotors& rotors, int substep, const RotorCondition& condition);

}  // namespace halfroll::sim
