#include "sim/model.hpp"

#include <algorithm>

namespace halfroll::sim {
namespace {

Plant with_effects(Plant plant, const Effects& on) {
  if (!on.drag) plant.drag_N_s_m = plant.drag_N_s2_m2 = 0.0;
  if (!on.rotor_drag) plant.rotor_drag_N_s_m = 0.0;
  if (!on.inflow) plant.rotor_inflow_N_s_m = 0.0;
  if (!on.gyroscopic) plant.rotor_inertia = 0.0;
  if (!on.governor) plant.governor_droop = 0.0;
  if (!on.stiction) plant.servo_stiction_N = 0.0;
  if (!on.battery) plant.battery_full_V = 0.0;
  return plant;
}

Vec3d centre_of(const Plant& plant, const Payload& payload) {
  return payload.position * (payload.mass / (plant.mass + payload.mass));
}

/// Two bodies about their common centre: the reduced mass turns at their distance (Steiner).
Inertia inertia_of(const Plant& plant, const Payload& payload) {
  const double mass = plant.mass + payload.mass, reduced = plant.mass * payload.mass / mass;
  const Vec3d& r = payload.position;
  const Eigen::Matrix3d moments = Eigen::Matrix3d(plant.inertia.asDiagonal()) +
                                  reduced * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  return {mass, moments};
}

/// Highest place of the body, in W, where its feet could touch or its rotors feel the ground, and a little more.
double reach_of_ground(const Plant& plant, const Effects& on) {
  constexpr double kSpare = 0.1;  // [m]
  const double feet = plant.leg_height + plant.foot_radius, air = on.ground_effect ? 5.0 * plant.rotor_radius : 0.0;
  return ground_z(plant) + std::max(feet, air) + kSpare;
}

double power_per_thrust(const Plant& plant) {
  constexpr double kPi = 3.14159265358979323846;
  if (plant.figure_of_merit <= 0.0 || plant.rotor_radius <= 0.0) return 0.0;
  const double disc = kPi * plant.rotor_radius * plant.rotor_radius;
  return 1.0 / (plant.figure_of_merit * std::sqrt(2.0 * plant.air_density * disc));
}

}  // namespace

Model::Model(const Plant& given, const Scenario& in)
    : plant(with_effects(given, in.effects)),
      scenario(in),
      inertia(inertia_of(given, in.payload)),
      centre(centre_of(given, in.payload)),
      rotors(plant),
      wind(in.wind),
      body_air(air_of_body(plant)),
      air_moves_blades(plant.rotor_inflow_N_s_m > 0.0 || plant.rotor_drag_N_s_m > 0.0),
      ground(ground_z(plant)),
      ground_reach(reach_of_ground(plant, in.effects)),
      spin(plant.rotor_inertia * plant.rotor_speed_rad_s),
      plain(!air_moves_blades && spin <= 0.0 && plant.drag_N_s2_m2 <= 0.0),
      hover_power(plant.battery_full_V > 0.0 ? power_per_thrust(plant) : 0.0),
      has_faults(std::any_of(in.faults.begin(), in.faults.end(),
                             [](const Fault& fault) { return fault.kind != Fault::Kind::kNone; })) {
  for (std::size_t i = 0; i < 4; ++i) {
    rotor_places[i] = rotor_place(plant, i) - centre.head<2>();
    rotor_air[i] = air_of_rotor(plant, rotor_places[i]);
  }
  if (plant.battery_full_V > 0.0) rotors.governed = true;
}

}  // namespace halfroll::sim
