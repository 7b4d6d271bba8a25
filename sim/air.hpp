// Forces and torques of the air. Why: they are linear in airspeed and body rate, so what four hubs and the body add up
// to is a handful of numbers, and those are linear in rotor speed.
#pragma once
#include "sim/plant.hpp"
#include "sim/rotors.hpp"

namespace halfroll::sim {

/// Coefficients in body axes. Blades lose thrust to air along their axis and are pushed by air across it, air as it
/// passes each hub, (air_B + w x place), summed over the hubs.
struct AirCoefficients {
  double across = 0.0, along = 0.0;                             // [N·s/m], force per airspeed; of the body, too
  double across_x = 0.0, across_y = 0.0, across_turning = 0.0;  // of blades, times the hub's place
  double along_x = 0.0, along_y = 0.0;                          // likewise
  double along_xx = 0.0, along_xy = 0.0, along_yy = 0.0;        // and times it once more

  /// And those of a rotor that turns at this share of its nominal speed.
  void add(const AirCoefficients& rotor, double speed) {
    across += speed * rotor.across;
    along += speed * rotor.along;
    across_x += speed * rotor.across_x;
    across_y += speed * rotor.across_y;
    across_turning += speed * rotor.across_turning;
    along_x += speed * rotor.along_x;
    along_y += speed * rotor.along_y;
    along_xx += speed * rotor.along_xx;
    along_xy += speed * rotor.along_xy;
    along_yy += speed * rotor.along_yy;
  }
};

inline AirCoefficients air_of_body(const Plant& plant) { return {plant.drag_N_s_m, plant.drag_N_s_m}; }

/// Of a rotor at nominal speed, whose hub is at `place` [m] from the centre of mass, body x and y.
inline AirCoefficients air_of_rotor(const Plant& plant, const Eigen::Vector2d& place) {
  const double x = place.x(), y = place.y(), d = plant.rotor_drag_N_s_m, k = plant.rotor_inflow_N_s_m;
  return {d, k, d * x, d * y, d * (x * x + y * y), k * x, k * y, k * x * x, k * x * y, k * y * y};
}

}  // namespace halfroll::sim
