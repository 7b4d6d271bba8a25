// The planner's picture of vehicle and limits. Why: numbers only, SI, filled from the vehicle file by the Python side;
// the kernel has no defaults of its own.
#pragma once
#include <array>
#include <limits>
#include <vector>

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

/// How rotors follow their commands: thrust with a lag (variable pitch), or motor speed, the root of thrust, with one
/// (fixed pitch). A command that lies outside of its range would be needed for a thrust that cannot be followed.
struct Drive {
  double lag_up = 0.0, lag_down = 0.0;                     // [s]; 0: at once
  bool of_speed = false;                                   // the lag is that of motor speed
  double command_min = -kNoLimit, command_max = kNoLimit;  // [N]
};

/// Where the nose points: within an angle of the direction d of flight, or from here to a point (both horizontal):
///   cos(yaw) dx + sin(yaw) dy >= cosine sqrt(d . d + slack^2) - slack
/// which asks for less the shorter d is, and for nothing where there is no direction.
struct Heading {
  enum class Rule { kNone, kPath, kPoint };
  Rule rule = Rule::kNone;
  double cosine = 0.0, slack = 0.0;  // slack in the unit of d: m/s or m
  double x = 0.0, y = 0.0;           // the point [m]
};

/// What must hold at every time. Infinite entries are switched off.
struct Limits {
  double rotor_min = 0.0;            // [N] each rotor
  double rotor_max = 0.0;            // [N]
  double force_min = -kNoLimit;      // [N] size of the thrust vector: keeps the attitude from turning at once
  double force_z_min = -kNoLimit;    // [N] its vertical part: upright flight
  double rotor_rate_max = kNoLimit;  // [N/s] either way
  Drive drive;
  double tilt_cos_min = -kNoLimit;  // cosine of the largest tilt of the thrust axis
  double body_rate_max = kNoLimit;  // [rad/s]
  double floor = -kNoLimit;         // [m] lowest height
  double ceiling = kNoLimit;        // [m] highest
  Heading heading;
  bool vertical = false;  // purely vertical flight: body upright, thrust signed, force limits do not apply
};

/// A vertical plane that is not crossed: x, y (a unit normal) times the position is at most offset.
struct Wall {
  double x, y, offset;
};

/// What differs from leg to leg.
struct PieceLimits {
  double speed_max = kNoLimit;  // [m/s]
  std::vector<Wall> walls;
  /// One that is never met, beyond the last.
  Wall wall(int i) const { return i < static_cast<int>(walls.size()) ? walls[i] : Wall{0.0, 0.0, 1.0}; }
};

}  // namespace halfroll::planner
