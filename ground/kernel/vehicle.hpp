// The planner's picture of vehicle and limits. Why: numbers only, SI, filled from the vehicle file by the Python side;
// the kernel has no defaults of its own.
#pragma once
#include <array>
#include <limits>

namespace halfroll::planner {

/// A rigid body with four rotors in plus layout, thrust along +z of the body.
struct Vehicle {
  double mass = 0.0;                // [kg]
  std::array<double, 3> inertia{};  // [kg m²], principal, body axes
  double arm = 0.0;                 // [m]
  double yaw_coefficient = 0.0;     // [m], rotor torque per thrust
  double gravity = 9.81;            // [m/s²]
};

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// What must hold at every time. Infinite entries are switched off.
struct Limits {
  double rotor_min = 0.0;           // [N] each rotor
  double rotor_max = 0.0;           // [N]
  double force_min = -kNoLimit;     // [N] size of the thrust vector: keeps the attitude from turning at once
  double force_z_min = -kNoLimit;   // [N] its vertical part: upright flight
  double body_rate_max = kNoLimit;  // [rad/s]
  double floor = -kNoLimit;         // [m] lowest height
  bool vertical = false;            // purely vertical flight: body upright, thrust signed, force limits do not apply
};

}  // namespace halfroll::planner
