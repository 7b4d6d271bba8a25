// The simulated vehicle: what never changes during a flight. Why: physics keeps constants and state apart, so a state
// can be copied, compared and continued while everybody reads the same Plant.
//
// An effect whose numbers are 0 does not exist on this vehicle; a Scenario may switch off one that does (effects).
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/constants.hpp"
#include "core/vehicle.hpp"

namespace halfroll::sim {

using Vec3d = Eigen::Vector3d;

/// Axes and rotor places as in core/types.hpp; SI throughout. docs/world.md has the sources of the numbers.
struct Plant {
  double gravity = kGravity;                   // [m/s²]
  double air_density = 1.225;                  // [kg/m³]
  double mass = 0.571;                         // [kg]
  Vec3d inertia = {0.00365, 0.00365, 0.0068};  // [kg·m²], principal, body axes
  double arm = 0.175;                          // [m], rotor to centre of mass
  double yaw_coefficient = 0.010;              // [m], rotor torque per thrust
  double drag_N_s_m = 0.05;                    // force per airspeed
  double drag_N_s2_m2 = 0.0;                   // force per airspeed squared: density times drag area / 2

  RotorKind rotor_kind = RotorKind::kVariablePitch;
  bool ideal_rotors = false;      // thrust = command at once; for tests of the rest
  double thrust_min = -3.0;       // [N], per rotor; a fixed-pitch rotor may also stop
  double thrust_max = 3.0;        // [N]
  double rotor_delay = 0.003;     // [s], dead time, at most kLongestRotorDelay (rotors.hpp)
  double rotor_lag = 0.018;       // [s], of blade pitch (variable pitch), of speed when it rises (fixed pitch)
  double rotor_lag_down = 0.018;  // [s], fixed pitch: of speed when it falls
  double rotor_slew_N_s = 126.0;  // variable pitch: fastest change of blade pitch, as thrust at nominal speed
  double servo_stiction_N = 0.0;  // variable pitch: a blade at rest stays until it is off by this, as thrust

  double rotor_speed_rad_s = 0.0;   // variable pitch: governed speed; fixed pitch: speed at thrust_max
  double rotor_inertia = 0.0;       // [kg·m²], one rotor about its axis
  double rotor_radius = 0.0;        // [m]
  double rotor_inflow_N_s_m = 0.0;  // thrust lost per speed of the air along the axis, at nominal speed
  double rotor_drag_N_s_m = 0.0;    // force per speed of the air across the axis, at nominal speed
  double profile_torque = 0.0;      // [N·m] at nominal speed and no thrust, physical torque only
  double figure_of_merit = 0.0;     // ideal over real hover power; 0: power is not modelled
  double governor_droop = 0.0;      // variable pitch: share of speed lost at full thrust
  double governor_lag = 0.05;       // [s], variable pitch: of speed
  double governor_headroom = 0.15;  // share of the full voltage that the governor can do without

  double battery_full_V = 0.0;          // open circuit; 0: no battery is modelled
  double battery_empty_V = 0.0;         // open circuit, nothing left
  double battery_capacity_Ah = 1.0;     // from full to empty
  double battery_resistance_ohm = 0.0;  // battery, leads and connector

  double leg_height = 0.05;         // [m], centre of mass above the feet
  double foot_radius = 0.12;        // [m], feet sit below the arms, this far from the centre
  double contact_frequency = 80.0;  // [rad/s], natural frequency of the vehicle on its four feet
  double contact_damping = 0.6;     // damping ratio of the same
  double friction = 0.8;            // Coulomb coefficient
  double crash_speed = 3.0;         // [m/s]: whatever meets the ground faster breaks
};

/// The same vehicle on legs in proportion to its radius of gyration, so that ground contact is as stiff to turning as
/// to sinking, whatever the size.
inline Plant with_fitting_legs(Plant plant) {
  const double gyration = std::sqrt(std::min(plant.inertia.x(), plant.inertia.y()) / plant.mass);
  plant.leg_height = 0.6 * gyration;
  plant.foot_radius = 1.5 * gyration;
  return plant;
}

/// Where rotor i sits, from the centre of the frame [m], body x and y; and which way its drag turns the body.
inline Eigen::Vector2d rotor_place(const Plant& plant, std::size_t i) {
  const std::array<Eigen::Vector2d, 4> places = {{{0, plant.arm}, {-plant.arm, 0}, {0, -plant.arm}, {plant.arm, 0}}};
  return places[i];
}
inline constexpr std::array<double, 4> kTorqueSign = {-1.0, 1.0, -1.0, 1.0};

}  // namespace halfroll::sim
