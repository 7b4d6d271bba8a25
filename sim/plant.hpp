// The simulated vehicle: what never changes during a flight. Why: physics keeps constants and state apart, so a state
// can be copied, compared and continued while everybody reads the same Plant.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "core/vehicle.hpp"

namespace halfroll::sim {

using Vec3d = Eigen::Vector3d;

/// Axes and rotor places as in core/types.hpp; SI throughout.
struct Plant {
  double gravity = kGravity;                   // [m/s²]
  double mass = 0.571;                         // [kg]
  Vec3d inertia = {0.00365, 0.00365, 0.0068};  // [kg·m²], principal, body axes
  double arm = 0.175;                          // [m], rotor to centre of mass
  double yaw_coefficient = 0.010;              // [m], rotor torque per thrust, also for thrust < 0
  double drag_N_s_m = 0.05;                    // force per speed; a scenario may switch it off

  RotorKind rotor_kind = RotorKind::kVariablePitch;
  bool ideal_rotors = false;      // thrust = command at once; for tests of the rest
  double thrust_min = -3.0;       // [N], per rotor; a fixed-pitch rotor may also stop
  double thrust_max = 3.0;        // [N]
  double rotor_delay = 0.003;     // [s], dead time, at most kLongestRotorDelay (rotors.hpp)
  double rotor_lag = 0.018;       // [s], of thrust (variable pitch), of speed when it rises (fixed pitch)
  double rotor_lag_down = 0.018;  // [s], fixed pitch: of speed when it falls
  double rotor_slew_N_s = 126.0;  // variable pitch: fastest change of thrust

  double leg_height = 0.05;         // [m], centre of mass above the feet
  double foot_radius = 0.12;        // [m], feet sit below the arms, this far from the centre
  double contact_frequency = 80.0;  // [rad/s], natural frequency of the vehicle on its four feet
  double contact_damping = 0.6;     // damping ratio of the same
  double friction = 0.8;            // Coulomb coefficient
};

/// The same vehicle on legs in proportion to its radius of gyration, so that ground contact is as stiff to turning as
/// to sinking, whatever the size.
inline Plant with_fitting_legs(Plant plant) {
  const double gyration = std::sqrt(std::min(plant.inertia.x(), plant.inertia.y()) / plant.mass);
  plant.leg_height = 0.6 * gyration;
  plant.foot_radius = 1.5 * gyration;
  return plant;
}

}  // namespace halfroll::sim
