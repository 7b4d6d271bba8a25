// A Plant in a Scenario, worked out once. Why: what a step multiplies by is divided, rooted and summed up here, and
// effects that are off have numbers that are 0, so the physics asks for no names.
#pragma once
#include "sim/air.hpp"
#include "sim/contact.hpp"
#include "sim/plant.hpp"
#include "sim/rigid_body.hpp"
#include "sim/rotors.hpp"
#include "sim/scenario.hpp"
#include "sim/wind.hpp"

namespace halfroll::sim {

struct Model {
  Model(const Plant& plant, const Scenario& scenario);

  Plant plant;  // numbers of effects that are off are 0
  Scenario scenario;
  Inertia inertia;                              // payload included, about the common centre of mass
  Vec3d centre;                                 // that centre, from the vehicle's own [m], body axes
  std::array<Eigen::Vector2d, 4> rotor_places;  // [m], from the common centre
  RotorModel rotors;
  WindModel wind;
  AirCoefficients body_air;
  std::array<AirCoefficients, 4> rotor_air;  // at nominal speed
  bool air_moves_blades;                     // inflow or rotor drag
  double ground;                             // [m], height of the ground in W
  double ground_reach;                       // [m], in W: above it, the ground does nothing within a substep
  double spin = 0.0;                         // [N·m·s], angular momentum of one rotor at nominal speed
  bool plain;                                // away from the ground there is nothing but rotors and plain drag
  double hover_power = 0.0;                  // [W/N^1.5], electrical power of a rotor per thrust^1.5; 0: no battery
  bool has_faults = false;
};

/// Force along up and torque of four thrusts (paper Eq 4, about the common centre of mass).
inline BodyLoad rotor_load(const Model& model, const PerRotor& f) {
  const Plant& plant = model.plant;
  const auto& at = model.rotor_places;
  BodyLoad load = {f[0] + f[1] + f[2] + f[3], {0.0, 0.0, plant.yaw_coefficient * (f[1] + f[3] - f[0] - f[2])}};
  if (model.scenario.effects.physical_torque) {
    double torque = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      torque += kTorqueSign[i] * (plant.yaw_coefficient * std::abs(f[i]) + plant.profile_torque);
    }
    load.torque_B.z() = torque;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    load.torque_B.x() += at[i].y() * f[i];
    load.torque_B.y() -= at[i].x() * f[i];
  }
  return load;
}

}  // namespace halfroll::sim
